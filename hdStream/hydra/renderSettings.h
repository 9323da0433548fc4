// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <pxr/imaging/hd/renderSettings.h>
#include <pxr/pxr.h>

PXR_NAMESPACE_OPEN_SCOPE

/// A render settings prim: while it is the scene's active one, its "hdstream:" attributes hold
/// where the application has not set the same setting. Camera, resolution and outputs are the
/// host's to pass on.
class HdStreamRenderSettings final : public HdRenderSettings {
public:
    explicit HdStreamRenderSettings(const SdfPath& id);

    void Finalize(HdRenderParam* renderParam) override;

protected:
    void _Sync(HdSceneDelegate* delegate, HdRenderParam* renderParam,
               const HdDirtyBits* dirtyBits) override;
};

PXR_NAMESPACE_CLOSE_SCOPE
