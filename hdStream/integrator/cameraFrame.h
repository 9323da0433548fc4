// SPDX-License-Identifier: Apache-2.0
// Camera and image size -> the constants that kernels/integrator/camera.clh reads.
#pragma once

#include "hdStream/integrator/renderOptions.h"
#include "kernels/shared/frame.h"

#include <glm/vec3.hpp>

namespace hds {

/// Frame constants of a render. The film back is conformed to the display window by the policy.
/// \param centre scene centre, subtracted in double.
/// \param numLights entries of the light table.
shared::HdsFrameParams MakeFrameParams(const RenderOptions& options, const glm::dvec3& centre,
                                       std::uint32_t numLights);

} // namespace hds
