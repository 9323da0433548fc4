// SPDX-License-Identifier: Apache-2.0
// Camera and image size -> the constants that kernels/integrator/camera.clh reads.
#pragma once

#include "hdStream/integrator/renderOptions.h"
#include "hdStream/scene/mediaBounds.h"
#include "kernels/shared/frame.h"

#include <glm/vec3.hpp>

namespace hds {

/// Whether a camera needs HDS_FEATURE_CAMERA_LENS.
bool NeedsLensKernels(const CameraPrim& camera, const Shutter& shutter);

/// Frame constants of a render. The film back is conformed to the display window by the policy.
/// \param centre scene centre, subtracted in double.
/// \param numLights entries of the light table.
shared::HdsFrameParams MakeFrameParams(const RenderOptions& options, const glm::dvec3& centre,
                                       std::uint32_t numLights);

/// Where the display window lies in camera space: at distance 1 of a perspective, in scene units
/// for an orthographic camera.
struct FilmWindow {
    double left = 0.0;
    double top = 0.0;
    double width = 0.0;
    double height = 0.0; ///< y up: the lower edge is at top - height
};

/// The film back of a lens, conformed to the display window by the policy. \pre a camera with a
/// film.
FilmWindow ConformedFilmWindow(const RenderOptions& options, const LensSample& lens);

/// Length of rays from outside of a box to the camera; 0: no camera ray begins in the box. \param
/// moves what is in the box may leave it while the shutter is open.
float MediaProbeLength(const shared::HdsFrameParams& params, const MediaBounds& box, bool moves);

} // namespace hds
