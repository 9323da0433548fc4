// SPDX-License-Identifier: Apache-2.0
#include "hdStream/hydra/camera.h"

#include "hdStream/hydra/arrays.h"
#include "hdStream/hydra/motion.h"
#include "hdStream/hydra/renderParam.h"

#include <pxr/imaging/hd/sceneDelegate.h>

#include <cmath>
#include <utility>

PXR_NAMESPACE_OPEN_SCOPE

namespace {

/// Linear factor on radiance; until 25.05 Hydra's cameras had the exponent only.
float ExposureScaleOf(const HdCamera& camera) {
#if PXR_VERSION >= 2505
    return camera.GetLinearExposureScale();
#else
    return camera.GetExposure() == 0.0F
               ? 1.0F
               : static_cast<float>(std::pow(2.0, static_cast<double>(camera.GetExposure())));
#endif
}

} // namespace

hds::CameraPrim HdStreamCameraFrom(const HdCamera& camera) {
    hds::CameraPrim prim;
    prim.worldFromCamera = HdStreamToGlm(camera.GetTransform());
    prim.orthographic = camera.GetProjection() == HdCamera::Orthographic;
    prim.horizontalAperture = camera.GetHorizontalAperture();
    prim.verticalAperture = camera.GetVerticalAperture();
    prim.horizontalApertureOffset = camera.GetHorizontalApertureOffset();
    prim.verticalApertureOffset = camera.GetVerticalApertureOffset();
    prim.focalLength = camera.GetFocalLength();
    prim.nearClip = camera.GetClippingRange().GetMin();
    prim.farClip = camera.GetClippingRange().GetMax();
    prim.fStop = camera.GetFStop();
    prim.focusDistance = camera.GetFocusDistance();
    prim.exposureScale = ExposureScaleOf(camera);
    for (const GfVec4d& plane : camera.GetClipPlanes()) {
        prim.clippingPlanes.emplace_back(plane[0], plane[1], plane[2], plane[3]);
    }
    prim.shutter = {camera.GetShutterOpen(), camera.GetShutterClose()};
    return prim;
}

HdStreamCamera::HdStreamCamera(const SdfPath& id) : HdCamera(id) {}

void HdStreamCamera::Sync(HdSceneDelegate* delegate, HdRenderParam* renderParam,
                          HdDirtyBits* dirtyBits) {
    const bool isDirty = (*dirtyBits & AllDirty) != 0;
    HdCamera::Sync(delegate, renderParam, dirtyBits);
    if (!isDirty) {
        return;
    }
    auto* param = static_cast<HdStreamRenderParam*>(renderParam);
    hds::CameraPrim prim = HdStreamCameraFrom(*this);
    prim.samples = HdStreamSampleTransform(delegate, GetId(), prim.shutter);
    param->SetShutter(GetId(), prim.shutter);
    param->Push([path = GetId().GetString(), prim = std::move(prim)](
                    hds::Session& session) mutable { session.SetCamera(path, std::move(prim)); });
}

void HdStreamCamera::Finalize(HdRenderParam* renderParam) {
    auto* param = static_cast<HdStreamRenderParam*>(renderParam);
    param->SetShutter(GetId(), {});
    param->Push([path = GetId().GetString()](hds::Session& session) { session.Remove(path); });
}

PXR_NAMESPACE_CLOSE_SCOPE
