// SPDX-License-Identifier: Apache-2.0
// Gaussian splats as a source of chunks: a group is a splat. Explained in docs/splats.md.
#pragma once

#include "hdStream/base/log.h"
#include "hdStream/geometry/chunkSource.h"

#include <cstdint>
#include <memory>
#include <optional>
#include <string>

namespace hds {

/// Primvars of splats, by the names of UsdVolParticleField3DGaussianSplat: vertex ones, with a
/// value a splat. A quaternion is i, j, k, real.
constexpr const char* kSplatOrientations = "orientations";
constexpr const char* kSplatScales = "scales";
constexpr const char* kSplatOpacities = "opacities";
/// Three channels, (degree + 1)^2 values a splat, one splat after another.
constexpr const char* kSplatHarmonics = "radiance:sphericalHarmonicsCoefficients";
constexpr const char* kSplatDegree = "radiance:sphericalHarmonicsDegree"; ///< constant

/// The degree of the harmonics of splats: authored, or 3; nothing where that is none from 0 to 3.
std::optional<std::uint32_t> SplatDegree(const GeometryDescription& splats);

/// Checks the splats and makes their source. Splats that are not finite, have no extent or cover
/// too little to be seen are dropped with a line. \param warnings must outlive the source.
/// \pre splats->primitives is Splats.
std::shared_ptr<const ChunkSource>
MakeSplatSource(std::shared_ptr<const GeometryDescription> splats, const std::string& primPath,
                Warnings& warnings);

} // namespace hds
