// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "hdStream/hydra/materialFrames.h"

#include <pxr/imaging/hd/material.h>
#include <pxr/pxr.h>

#include <string>

PXR_NAMESPACE_OPEN_SCOPE

/// A material of Hydra on its way into the core. Synced in parallel with other materials.
class HdStreamMaterial final : public HdMaterial {
public:
    /// \param frames of the delegate; must outlive it.
    HdStreamMaterial(const SdfPath& id, HdStreamMaterialFrames* frames);

    HdDirtyBits GetInitialDirtyBitsMask() const override;
    void Sync(HdSceneDelegate* delegate, HdRenderParam* renderParam,
              HdDirtyBits* dirtyBits) override;
    void Finalize(HdRenderParam* renderParam) override;

private:
    HdStreamMaterialFrames& _frames;
    std::string _scenePath; ///< empty until the first Sync
};

PXR_NAMESPACE_CLOSE_SCOPE
