// SPDX-License-Identifier: Apache-2.0
// Leaves by path, as a hierarchy takes them.
#pragma once

#include "hdStream/scene/hierarchy.h"

#include <map>
#include <string>
#include <vector>

namespace hds::test {

/// \pre the scene, which must outlive the result, has these prims.
inline std::vector<DrawnLeaf> DrawnLeaves(const SceneDescription& scene,
                                          const std::map<std::string, LeafObject>& leaves) {
    std::vector<DrawnLeaf> drawn;
    for (const auto& [path, leaf] : leaves) {
        drawn.push_back({&*scene.geometry.find(path), leaf});
    }
    return drawn;
}

} // namespace hds::test
