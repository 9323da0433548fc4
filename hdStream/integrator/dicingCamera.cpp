// SPDX-License-Identifier: Apache-2.0
#include "hdStream/integrator/dicingCamera.h"

#include "hdStream/integrator/cameraFrame.h"

#include <glm/common.hpp>

namespace hds {

DicingCamera MakeDicingCamera(const RenderOptions& options) {
    const shared::HdsFrameParams params = MakeFrameParams(options, glm::dvec3(0.0), 0);
    DicingCamera camera;
    camera.worldFromCamera = options.camera.worldFromCamera;
    camera.isOrthographic = options.camera.orthographic;
    camera.imageSize = {double(options.imageWidth), double(options.imageHeight)};
    // Raster (0, 0) is the display window's corner, the image starts at the data window's.
    const glm::dvec2 step(params.filmStep[0], params.filmStep[1]);
    const glm::dvec2 dataWindow(params.dataWindowMin[0], params.dataWindowMin[1]);
    const glm::dvec2 first =
        glm::dvec2(params.filmOrigin[0], params.filmOrigin[1]) + dataWindow * step;
    const glm::dvec2 last = first + camera.imageSize * step; // steps may have either sign
    camera.windowMin = glm::min(first, last);
    camera.windowMax = glm::max(first, last);
    camera.nearClip = double(params.nearClip);
    return camera;
}

} // namespace hds
