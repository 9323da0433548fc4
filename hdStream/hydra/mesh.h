// SPDX-License-Identifier: Apache-2.0
// Meshes.
#pragma once

#include "hdStream/hydra/rprim.h"

#include <pxr/pxr.h>

PXR_NAMESPACE_OPEN_SCOPE

/// A mesh of Hydra on its way into the core.
class HdStreamMesh final : public HdStreamRprim<HdMesh> {
public:
    using HdStreamRprim::HdStreamRprim;

private:
    void SyncLook(HdSceneDelegate* delegate, HdStreamRenderParam* param, HdDirtyBits bits) override;
    void SyncLight(HdSceneDelegate* delegate, HdStreamRenderParam* param);
    void SyncTopology(HdSceneDelegate* delegate, HdStreamRenderParam* param, HdDirtyBits bits,
                      hds::GeometryDescription* mesh) override;
    void SyncSubsets(HdSceneDelegate* delegate, HdStreamRenderParam* param,
                     const HdGeomSubsets& subsets, hds::GeometryDescription* mesh);
    bool CheckGeometry(HdStreamRenderParam* param) const override;
};

PXR_NAMESPACE_CLOSE_SCOPE
