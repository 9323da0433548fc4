// SPDX-License-Identifier: Apache-2.0
#include "hdStream/session/imageMetadata.h"

#include "hdStream/integrator/cameraFrame.h"
#include "hdStream/scene/motion.h"
#include "hdStream/session/settingsCheck.h"

#include <glm/mat4x4.hpp>
#include <glm/matrix.hpp>

#include <algorithm>
#include <cmath>

namespace hds {

namespace {

/// Columns of glm are rows of Gf.
std::array<double, 16> RowsOf(const glm::dmat4& matrix) {
    std::array<double, 16> rows{};
    std::copy_n(&matrix[0][0], rows.size(), rows.begin());
    return rows;
}

glm::dmat4 MakeProjection(const CameraPrim& camera, const FilmWindow& film) {
    const double n = static_cast<double>(camera.nearClip);
    const double f = static_cast<double>(camera.farClip);
    const double x = (2.0 * film.left + film.width) / film.width; // the window's centre
    const double y = (2.0 * film.top - film.height) / film.height;
    glm::dmat4 projection(0.0);
    projection[0][0] = 2.0 / film.width;
    projection[1][1] = 2.0 / film.height;
    if (camera.orthographic) {
        projection[2][2] = -2.0 / (f - n);
        projection[3] = {-x, -y, -(f + n) / (f - n), 1.0};
    } else {
        projection[2] = {x, y, -(f + n) / (f - n), -1.0};
        projection[3][2] = -2.0 * f * n / (f - n);
    }
    return projection;
}

} // namespace

ImageMetadata MakeImageMetadata(const Settings& settings, const CameraPrim& camera) {
    ImageMetadata metadata;
    metadata.samples = settings.samples;
    metadata.camera = settings.camera;
    metadata.workingSpace = settings.workingSpace;
    metadata.pixelAspectRatio = settings.pixelAspectRatio;
    const glm::dmat4 view = glm::inverse(camera.worldFromCamera);
    metadata.worldToCamera = RowsOf(view);
    if (camera.lens.projection == CameraProjection::Film) { // no matrix tells of others
        const RenderOptions options = MakeRenderOptions(settings, camera);
        const FilmWindow film = ConformedFilmWindow(options, LensOfFrame(options.camera));
        metadata.worldToNdc = RowsOf(MakeProjection(options.camera, film) * view);
    }
    const auto edge = [&](std::size_t i) {
        return static_cast<std::int32_t>(std::lround(settings.displayWindow[i]));
    };
    if (edge(2) > edge(0) && edge(3) > edge(1)) {
        metadata.displayWindowSize = {static_cast<std::uint32_t>(edge(2) - edge(0)),
                                      static_cast<std::uint32_t>(edge(3) - edge(1))};
        metadata.dataWindowMin = {settings.dataWindowMin[0] - edge(0),
                                  settings.dataWindowMin[1] - edge(1)};
    }
    return metadata;
}

} // namespace hds
