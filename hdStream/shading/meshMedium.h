// SPDX-License-Identifier: Apache-2.0
// What the volume of a material fills meshes with. Explained in docs/volumes.md.
#pragma once

#include "hdStream/base/log.h"
#include "hdStream/shading/materialNetwork.h"
#include "kernels/shared/meshMedium.h"

#include <glm/vec3.hpp>

#include <optional>
#include <string>

namespace hds {

/// The medium that a material's terminal "volume" makes of the inside of meshes; nothing where
/// there is none, or, with a warning, where its numbers make no sense. Fields of volumes count as
/// 1: a mesh has none. \param materialPath subject of the warnings.
std::optional<shared::HdsMeshMedium>
ReadMeshMedium(const MaterialNetwork& network, const std::string& materialPath, Warnings& warnings);

/// A medium of coefficients by unit of length. Those that are too large are bounded.
shared::HdsMeshMedium MakeMeshMedium(const glm::vec3& absorption, const glm::vec3& scattering,
                                     float asymmetry, const glm::vec3& emission);

} // namespace hds
