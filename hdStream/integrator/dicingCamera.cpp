// SPDX-License-Identifier: Apache-2.0
#include "hdStream/integrator/dicingCamera.h"

#include "hdStream/integrator/cameraFrame.h"

#include <glm/common.hpp>

#include <algorithm>

namespace hds {

namespace {

/// Rates divide by the distance; a camera may clip nothing.
constexpr double kLeastNearClip = 1e-3;

} // namespace

DicingCamera MakeDicingCamera(const RenderOptions& options) {
    const shared::HdsFrameParams params = MakeFrameParams(options, glm::dvec3(0.0), 0);
    DicingCamera camera;
    camera.worldFromCamera = options.camera.worldFromCamera;
    camera.isOrthographic = options.camera.orthographic;
    // The display window: a crop has the rates of the full image.
    const glm::dvec2 corner(options.displayWindow[0], options.displayWindow[1]);
    camera.imageSize = glm::dvec2(options.displayWindow[2], options.displayWindow[3]) - corner;
    const glm::dvec2 step(params.filmStep[0], params.filmStep[1]);
    const glm::dvec2 first = glm::dvec2(params.filmOrigin[0], params.filmOrigin[1]) + corner * step;
    const glm::dvec2 last = first + camera.imageSize * step; // steps may have either sign
    camera.windowMin = glm::min(first, last);
    camera.windowMax = glm::max(first, last);
    camera.nearClip = std::max(kLeastNearClip, double(params.nearClip));
    return camera;
}

} // namespace hds
