// SPDX-License-Identifier: Apache-2.0
// Curves, points and Gaussian splats.
#pragma once

#include "hdStream/hydra/rprim.h"

#include <pxr/pxr.h>

#include <vector>

PXR_NAMESPACE_OPEN_SCOPE

/// Curves of Hydra on their way into the core.
class HdStreamBasisCurves final : public HdStreamRprim<HdBasisCurves> {
public:
    using HdStreamRprim::HdStreamRprim;

private:
    void SyncTopology(HdSceneDelegate* delegate, HdStreamRenderParam* param, HdDirtyBits bits,
                      hds::GeometryDescription* curves) override;
    void AddDefaultPrimvars(std::vector<hds::Primvar>* primvars) const override;
    bool CheckGeometry(HdStreamRenderParam* param) const override;
};

/// Points of Hydra on their way into the core.
class HdStreamPoints final : public HdStreamRprim<HdPoints> {
public:
    using HdStreamRprim::HdStreamRprim;

private:
    void SyncTopology(HdSceneDelegate* delegate, HdStreamRenderParam* param, HdDirtyBits bits,
                      hds::GeometryDescription* points) override;
    bool CheckGeometry(HdStreamRenderParam* param) const override;
};

/// The type of rprims that Hydra has for particle fields: by its text, which OpenUSD before 26.03
/// has no token for.
const TfToken& HdStreamParticleField();

/// Gaussian splats of Hydra on their way into the core: of UsdVolParticleField3DGaussianSplat,
/// which is what UsdImaging makes particle fields of.
class HdStreamSplats final : public HdStreamRprim<HdPoints> {
public:
    using HdStreamRprim::HdStreamRprim;

private:
    void SyncTopology(HdSceneDelegate* delegate, HdStreamRenderParam* param, HdDirtyBits bits,
                      hds::GeometryDescription* splats) override;
    const TfToken& PointsName() const override;
    bool CheckGeometry(HdStreamRenderParam* param) const override;
};

PXR_NAMESPACE_CLOSE_SCOPE
