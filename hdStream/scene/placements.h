// SPDX-License-Identifier: Apache-2.0
// Where instancers place a prim, one placement after the other: for what has a record of its own,
// and for lights, media and bounds. Explained in docs/architecture.md, "Instances".
#pragma once

#include "hdStream/base/log.h"
#include "hdStream/scene/motion.h"
#include "hdStream/scene/sceneDescription.h"

#include <cstdint>
#include <functional>
#include <set>
#include <string>
#include <vector>

namespace hds {

/// Deepest chain of instancers that is followed; longer ones are cycles in all likelihood.
constexpr int kMaxInstancerChain = 64;

/// A prim in world space. id: its parent-major instanceId; -1: not instanced.
struct Placed {
    MovingTransform worldFromObject;
    std::int64_t id = -1;
    std::set<std::string> categories; ///< of the instances
};

/// From a prim to what its instancer places, or to the world.
MovingTransform PlacementTransform(const Placement& placement, const Shutter& shutter);

/// Whether a matrix can be inverted: at the frame, and at the times of all keys that there may be.
bool CanBeInverted(const glm::dmat4& matrix);
bool CanBeInverted(const MovingTransform& transform);

/// Most placements of one prim that are looked at one after the other: chains of instancers
/// multiply.
constexpr double kMostPlacements = 1 << 24;

/// How many placements a prim has at most, of which some may be of no use.
/// \param chainLength instancers above the prim, where not null.
double NumPlacements(const SceneDescription& scene, const Placement& placement,
                     int* chainLength = nullptr);

/// Tells of a prim that has more than kMostPlacements.
void WarnOfTooMany(const SceneDescription& scene, const std::string& path,
                   const Placement& placement, Warnings& warnings);

/// All placements in world space, none where they are more than kMostPlacements; parent-major: the
/// parent's are the outer loop. \param chain instancers that have been followed so far.
std::vector<Placed> PlacementsOf(const SceneDescription& scene, const Placement& placement,
                                 const Shutter& shutter, int chain = 0);

/// Placements of an instancer in world space (its own and its ancestors' instances composed,
/// parent-major) for a prim; calls `onPlacement(worldFromPrototype)` for each. For
/// bounds, at the frame.
void ForEachPlacement(const SceneDescription& scene, const Placement& placement,
                      const std::function<void(const glm::dmat4& worldFromObject)>& onPlacement);
/// The same while the shutter is open, for lights.
void ForEachPlacement(
    const SceneDescription& scene, const Placement& placement, const Shutter& shutter,
    const std::function<void(const MovingTransform& worldFromObject)>& onPlacement);

} // namespace hds
