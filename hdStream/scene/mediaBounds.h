// SPDX-License-Identifier: Apache-2.0
// Meshes that a medium fills: where they are, and which wins. Explained in docs/volumes.md.
#pragma once

#include "hdStream/geometry/geometryDescription.h"
#include "hdStream/scene/hierarchy.h"

#include <glm/vec3.hpp>

#include <optional>
#include <vector>

namespace hds {

/// The priority of the inside of a prim where bodies overlap, as its primvars say: constant ones of
/// one number. That of hdstream wins over RenderMan's.
std::optional<float> DielectricPriority(const std::vector<Primvar>& primvars);

/// A box; empty as it is made.
struct MediaBounds {
    glm::dvec3 min{1e300};
    glm::dvec3 max{-1e300};
};

/// The box of all placements of leaves with HDS_INSTANCE_MEDIUM while the shutter is open, relative
/// to the centre of the scene.
MediaBounds FindMediaBounds(const SceneDescription& scene, const std::vector<DrawnLeaf>& leaves,
                            glm::dvec3 centre, const Shutter& shutter);

} // namespace hds
