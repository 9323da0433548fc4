// SPDX-License-Identifier: Apache-2.0
#include "hdStream/hydra/camera.h"

#include "hdStream/hydra/arrays.h"
#include "hdStream/hydra/materialParameters.h"
#include "hdStream/hydra/motion.h"
#include "hdStream/hydra/renderParam.h"

#include <pxr/imaging/hd/cameraSchema.h>
#include <pxr/imaging/hd/renderIndex.h>
#include <pxr/imaging/hd/sceneDelegate.h>
#include <pxr/imaging/hd/sceneIndex.h>

#include <utility>
#include <vector>

PXR_NAMESPACE_OPEN_SCOPE

namespace {

/// Of the lens while the shutter is open, where it changes: as the other front end has them.
constexpr int kLensSteps = 8;

/// Those of the attributes that the scene has.
hds::CameraAttributes ReadAttributes(HdSceneDelegate* delegate, const SdfPath& id,
                                     const std::vector<std::string>& names) {
    hds::CameraAttributes attributes;
    for (const std::string& name : names) {
        const VtValue value = delegate->GetCameraParamValue(id, TfToken(name));
        if (const auto parameter = HdStreamParameterFrom(value)) {
            attributes[name] = *parameter;
        }
    }
    return attributes;
}

/// Linear factor on radiance; until 25.05 Hydra's cameras had the exponent only.
float ExposureScaleOf(const HdCamera& camera, HdSceneDelegate* delegate) {
#if PXR_VERSION >= 2505
    (void)delegate;
    return camera.GetLinearExposureScale();
#else
    return hds::LinearExposureScale(
        camera.GetExposure(),
        delegate ? ReadAttributes(delegate, camera.GetId(), hds::ExposureAttributeNames())
                 : hds::CameraAttributes());
#endif
}

/// The lens and the film while the shutter is open; empty when the scene does not tell of a change.
std::vector<hds::LensSample> SampleLens(HdSceneDelegate* delegate, const SdfPath& id,
                                        const hds::CameraPrim& prim) {
    const HdSceneIndexBaseRefPtr scene = delegate->GetRenderIndex().GetTerminalSceneIndex();
    if (!scene || !prim.shutter.IsOpen()) {
        return {};
    }
    const HdCameraSchema schema = HdCameraSchema::GetFromParent(scene->GetPrim(id).dataSource);
    if (!schema) {
        return {};
    }
    using Member = float hds::LensSample::*;
    const std::pair<HdFloatDataSourceHandle, Member> sources[] = {
        {schema.GetFocalLength(), &hds::LensSample::focalLength},
        {schema.GetFStop(), &hds::LensSample::fStop},
        {schema.GetFocusDistance(), &hds::LensSample::focusDistance},
        {schema.GetHorizontalAperture(), &hds::LensSample::horizontalAperture},
        {schema.GetVerticalAperture(), &hds::LensSample::verticalAperture},
        {schema.GetHorizontalApertureOffset(), &hds::LensSample::horizontalApertureOffset},
        {schema.GetVerticalApertureOffset(), &hds::LensSample::verticalApertureOffset}};
    const auto open = static_cast<float>(prim.shutter.open);
    const auto close = static_cast<float>(prim.shutter.close);
    bool isVarying = false;
    for (const auto& [source, member] : sources) {
        std::vector<HdSampledDataSource::Time> times;
        isVarying = isVarying ||
                    (source && source->GetContributingSampleTimesForInterval(open, close, &times));
    }
    std::vector<hds::LensSample> samples;
    for (int i = 0; isVarying && i <= kLensSteps; ++i) {
        const double time =
            prim.shutter.open + double(i) / kLensSteps * (prim.shutter.close - prim.shutter.open);
        hds::LensSample sample{time,
                               prim.focalLength,
                               prim.fStop,
                               prim.focusDistance,
                               prim.horizontalAperture,
                               prim.verticalAperture,
                               prim.horizontalApertureOffset,
                               prim.verticalApertureOffset};
        for (const auto& [source, member] : sources) {
            if (source) {
                sample.*member = source->GetTypedValue(static_cast<float>(time));
            }
        }
        samples.push_back(sample);
    }
    return samples;
}

} // namespace

hds::CameraPrim HdStreamCameraFrom(const HdCamera& camera, HdSceneDelegate* delegate) {
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
    prim.exposureScale = ExposureScaleOf(camera, delegate);
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
    hds::CameraPrim prim = HdStreamCameraFrom(*this, delegate);
    for (const std::string& problem : hds::SetCameraAttributes(
             ReadAttributes(delegate, GetId(), hds::CameraAttributeNames()), &prim)) {
        param->Warn(GetId(), problem);
    }
    prim.samples = HdStreamSampleTransform(delegate, GetId(), prim.shutter);
    prim.lensSamples = SampleLens(delegate, GetId(), prim);
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
