// SPDX-License-Identifier: Apache-2.0
// Places one UsdLux light: transform, size and bounds of an HdsLight. Scale is moved from the
// matrix into the sizes as far as the shape allows, so that |determinant| is 1 and light space has
// the scale of world space; a rect under any unsheared transform then has a rotation as its matrix.
#pragma once

#include "hdStream/shading/lightDescription.h"
#include "kernels/shared/light.h"

#include <glm/mat4x4.hpp>

namespace hds {

/// Fills worldFromLight, lightFromWorld, params, area, center and boundRadius.
/// \return false when the transform is singular or not finite, or the shape has no size.
bool PlaceLight(const LightDescription& light, const glm::dmat4& worldFromLight,
                shared::HdsLight* out);

} // namespace hds
