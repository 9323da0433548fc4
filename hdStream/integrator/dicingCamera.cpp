// SPDX-License-Identifier: Apache-2.0
#include "hdStream/integrator/dicingCamera.h"

#include "hdStream/integrator/cameraFrame.h"
#include "hdStream/scene/motion.h"

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

/// The display window and what lies beside it of the picture (overscan): left, top, right, bottom.
std::array<double, 4> DicedWindow(const RenderOptions& options) {
    std::array<double, 4> picture = options.uncroppedWindow;
    if (picture == std::array<double, 4>{}) {
        const double left = options.dataWindowMin[0];
        const double top = options.dataWindowMin[1];
        picture = {left, top, left + options.imageWidth, top + options.imageHeight};
    }
    const std::array<double, 4>& display = options.displayWindow;
    return {std::min(display[0], picture[0]), std::min(display[1], picture[1]),
            std::max(display[2], picture[2]), std::max(display[3], picture[3])};
}

} // namespace

DicingCamera MakeDicingCamera(const RenderOptions& options) {
    const shared::HdsFrameParams params = MakeFrameParams(options, glm::dvec3(0.0), 0);
    DicingCamera camera;
    camera.worldFromCamera = options.camera.worldFromCamera;
    const MovingTransform pose(camera.worldFromCamera, options.camera.samples, options.shutter);
    for (std::size_t i = 0; i <= kDicingSteps && pose.Moves(); ++i) {
        camera.path.push_back(pose.At(double(i) / double(kDicingSteps)));
    }
    camera.isOrthographic = (params.flags & HDS_FRAME_ORTHOGRAPHIC) != 0;
    camera.isPanoramic = options.camera.lens.projection != CameraProjection::Film;
    // All that may be drawn: a crop has the rates of the full image.
    const std::array<double, 4> window = DicedWindow(options);
    const glm::dvec2 corner(window[0], window[1]);
    camera.imageSize = glm::dvec2(window[2], window[3]) - corner;
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
