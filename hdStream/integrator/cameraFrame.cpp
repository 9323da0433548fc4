// SPDX-License-Identifier: Apache-2.0
#include "hdStream/integrator/cameraFrame.h"

#include "hdStream/scene/transforms.h"

#include <glm/gtc/matrix_transform.hpp>

#include <algorithm>

namespace hds {

namespace {

/// UsdGeomCamera gives apertures and focal length in tenths of a scene unit.
constexpr double kUnitsPerTenth = 0.1;

} // namespace

shared::HdsFrameParams MakeFrameParams(const RenderOptions& options, const glm::dvec3& centre,
                                       std::uint32_t numLights) {
    const CameraPrim& camera = options.camera;
    shared::HdsFrameParams params{};
    const AffineRows rows =
        RowsFromMatrix(glm::translate(glm::dmat4(1.0), -centre) * camera.worldFromCamera);
    std::copy(rows.begin(), rows.end(), params.worldFromCamera);

    double width = camera.horizontalAperture;
    double height = camera.verticalAperture;
    const double imageAspect =
        options.pixelAspectRatio * options.imageWidth / static_cast<double>(options.imageHeight);
    if (width / height < imageAspect) {
        width = height * imageAspect;
    } else {
        height = width / imageAspect;
    }
    // On the plane at distance 1 for a perspective, in scene units for an orthographic camera.
    const double scale = camera.orthographic ? kUnitsPerTenth : 1.0 / camera.focalLength;
    const double left = (camera.horizontalApertureOffset - 0.5 * width) * scale;
    const double top = (camera.verticalApertureOffset + 0.5 * height) * scale;
    params.filmOrigin[0] = static_cast<float>(left);
    params.filmOrigin[1] = static_cast<float>(top);
    params.filmStep[0] = static_cast<float>(width * scale / options.imageWidth);
    params.filmStep[1] = static_cast<float>(-height * scale / options.imageHeight);

    params.nearClip = static_cast<float>(camera.nearClip);
    params.farClip = static_cast<float>(camera.farClip);
    const bool hasLens = camera.fStop > 0.0 && camera.focusDistance > 0.0;
    params.lensRadius =
        hasLens ? static_cast<float>(0.5 * kUnitsPerTenth * camera.focalLength / camera.fStop)
                : 0.0F;
    params.focusDistance = static_cast<float>(camera.focusDistance);
    params.exposureScale = static_cast<float>(camera.exposureScale);
    params.flags = (camera.orthographic ? HDS_FRAME_ORTHOGRAPHIC : 0U) |
                   (options.russianRoulette ? HDS_FRAME_ROULETTE : 0U);
    params.imageWidth = options.imageWidth;
    params.imageHeight = options.imageHeight;
    params.seed = options.seed;
    params.maxDepth = options.maxDepth;
    params.numLights = numLights;
    return params;
}

} // namespace hds
