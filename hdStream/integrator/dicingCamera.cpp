// SPDX-License-Identifier: Apache-2.0
#include "hdStream/integrator/dicingCamera.h"

#include "hdStream/integrator/cameraFrame.h"

#include <glm/common.hpp>
#include <glm/trigonometric.hpp>

#include <algorithm>
#include <cmath>

namespace hds {

namespace {

/// Rates divide by the distance; a camera may clip nothing.
constexpr double kLeastNearClip = 1e-3;

/// The least angle that a unit of film coordinates stands for; 1 where it is no angle.
double LeastAngle(const CameraLens& lens) {
    const double half = glm::radians(0.5 * double(lens.fieldOfView));
    switch (lens.projection) {
    case CameraProjection::FisheyeEquidistant:
        return half;
    case CameraProjection::FisheyeEquisolid: // at the border, where it is seen from the side
    case CameraProjection::FisheyeStereographic:
        return std::max(std::sin(half), 0.25 * half);
    case CameraProjection::Film:
    case CameraProjection::Latlong:
        break;
    }
    return 1.0;
}

} // namespace

DicingCamera MakeDicingCamera(const RenderOptions& options) {
    const shared::HdsFrameParams params = MakeFrameParams(options, glm::dvec3(0.0), 0);
    DicingCamera camera;
    camera.worldFromCamera = options.camera.worldFromCamera;
    camera.isOrthographic = (params.flags & HDS_FRAME_ORTHOGRAPHIC) != 0;
    camera.isPanoramic = options.camera.lens.projection != CameraProjection::Film;
    // The display window: a crop has the rates of the full image.
    const glm::dvec2 corner(options.displayWindow[0], options.displayWindow[1]);
    camera.imageSize = glm::dvec2(options.displayWindow[2], options.displayWindow[3]) - corner;
    const double scale = LeastAngle(options.camera.lens);
    const glm::dvec2 step = scale * glm::dvec2(params.filmStep[0], params.filmStep[1]);
    const glm::dvec2 first =
        scale * glm::dvec2(params.filmOrigin[0], params.filmOrigin[1]) + corner * step;
    const glm::dvec2 last = first + camera.imageSize * step; // steps may have either sign
    camera.windowMin = glm::min(first, last);
    camera.windowMax = glm::max(first, last);
    camera.nearClip = std::max(kLeastNearClip, double(params.nearClip));
    return camera;
}

} // namespace hds
