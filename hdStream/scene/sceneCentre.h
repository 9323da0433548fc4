// SPDX-License-Identifier: Apache-2.0
// The world position that device coordinates are relative to.
#pragma once

#include "hdStream/scene/hierarchy.h"

namespace hds {

/// The middle of the drawn prims' placements (instances by their own origins), or the world's
/// origin for a scene that is not far from it: at most four times its own half diagonal away.
/// Positions near the origin so keep their authored bits.
glm::dvec3 ChooseSceneCentre(const SceneDescription& scene, const std::vector<DrawnLeaf>& leaves);

} // namespace hds
