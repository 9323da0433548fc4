// SPDX-License-Identifier: Apache-2.0
// The world position that device coordinates are relative to.
#pragma once

#include "hdStream/scene/hierarchy.h"

#include <glm/common.hpp>
#include <glm/geometric.hpp>

#include <vector>

namespace hds {

/// How far placements go in world space; of nothing it is inside out.
struct Reach {
    glm::dvec3 min{1e300};
    glm::dvec3 max{-1e300};

    /// Of points that are not finite nothing.
    void Extend(const glm::dvec3& point);
    void Extend(const Reach& other) {
        min = glm::min(min, other.min);
        max = glm::max(max, other.max);
    }
    bool IsEmpty() const { return min.x > max.x; }
    glm::dvec3 Middle() const { return 0.5 * (min + max); }
    double HalfDiagonal() const { return 0.5 * glm::length(max - min); }
};

/// Of a prim that no instancer places; of others, which count by their instances' origins, nothing.
Reach ReachOfLeaf(const DrawnLeaf& leaf);
/// Of the volumes and the instances; instances are pieces, many of them by some.
Reach ReachBesideLeaves(const SceneDescription& scene, std::vector<Reach>* pieces);

/// The middle of all that is reached, or the world's origin for a scene that is not far from it: at
/// most four times its own half diagonal away. Positions near the origin so keep their authored
/// bits. Where three of four pieces lie together, more than 1024 of their own half diagonals away,
/// the middle is theirs: a few strays that were left at the origin do not cost the others their
/// precision. \param leaves, others the pieces.
glm::dvec3 CentreOfReach(const Reach& all, const std::vector<Reach>& leaves,
                         const std::vector<Reach>& others);

/// Of the drawn prims' placements (instances by their own origins).
glm::dvec3 ChooseSceneCentre(const SceneDescription& scene, const std::vector<DrawnLeaf>& leaves);

} // namespace hds
