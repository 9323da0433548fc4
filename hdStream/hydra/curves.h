// SPDX-License-Identifier: Apache-2.0
// Curves and points.
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

PXR_NAMESPACE_CLOSE_SCOPE
