// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "hdStream/session/session.h"

#include <pxr/imaging/hd/camera.h>
#include <pxr/pxr.h>

#include <string>

PXR_NAMESPACE_OPEN_SCOPE

/// A camera of Hydra on its way into the core. Its path in the scene is its id.
class HdStreamCamera final : public HdCamera {
public:
    explicit HdStreamCamera(const SdfPath& id);

    void Sync(HdSceneDelegate* delegate, HdRenderParam* renderParam,
              HdDirtyBits* dirtyBits) override;
    void Finalize(HdRenderParam* renderParam) override;
};

/// The core's camera with the values of one of Hydra's: lengths in scene units, as they are.
/// \param delegate of exposure's newer attributes; null: they do not count.
hds::CameraPrim HdStreamCameraFrom(const HdCamera& camera, HdSceneDelegate* delegate);

PXR_NAMESPACE_CLOSE_SCOPE
