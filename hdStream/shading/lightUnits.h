// SPDX-License-Identifier: Apache-2.0
// What UsdLux's light inputs mean in radiometric units: colour temperature, emission, and the size
// by which `normalize` divides. Source: UsdLux schema documentation (OpenUSD 24.08, normalize as
// spelled out since 25.05). Explained in docs/lights.md.
#pragma once

#include "hdStream/shading/lightDescription.h"
#include "kernels/shared/light.h"

#include <glm/mat3x3.hpp>
#include <glm/vec3.hpp>

namespace hds {

/// Colour of a black body in linear Rec. 709, scaled to luminance 1; kelvin, clamped to [1000,
/// 10000]. Equals UsdLuxBlackbodyTemperatureAsRgb.
glm::dvec3 BlackbodyRgb(double kelvin);

/// intensity * 2^exposure * color * temperature: radiance before `normalize`.
glm::dvec3 LightEmission(const LightDescription& light);

/// World-space area of the emitting surface of a sphere, rect, disk or cylinder (without caps)
/// under the linear part of its transform; exact for any affine map (ellipsoids by quadrature).
double LightArea(const LightDescription& light, const glm::dmat3& worldFromLight);

/// Half of a distant light's angle in radians, clamped to [0, pi].
double DistantHalfAngle(const LightDescription& light);

/// Irradiance at normal incidence from a distant light of radiance 1:
/// pi sin^2 up to a half angle of 90 degrees, pi (2 - sin^2) beyond; 1 for angle 0.
/// It is also what `normalize` divides a distant light by.
double DistantIrradiance(double halfAngle);

/// What is not physical about a light, as kernels read it: at rest and without filters.
shared::HdsLightControls LightControls(const LightDescription& light);

} // namespace hds
