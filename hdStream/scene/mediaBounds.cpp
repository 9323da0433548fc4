// SPDX-License-Identifier: Apache-2.0
#include "hdStream/scene/mediaBounds.h"

#include "hdStream/scene/placements.h"

#include <glm/common.hpp>
#include <glm/gtc/matrix_transform.hpp>

#include <algorithm>

namespace hds {

std::optional<float> DielectricPriority(const std::vector<Primvar>& primvars) {
    for (const char* name :
         {"hdstream:dielectricPriority", "ri:attributes:trace:intersectpriority"}) {
        const auto found = std::find_if(primvars.begin(), primvars.end(),
                                        [&](const Primvar& one) { return one.name == name; });
        if (found != primvars.end() && found->interpolation == Interpolation::Constant &&
            found->values.size() == 1) {
            return found->values[0];
        }
    }
    return std::nullopt;
}

MediaBounds FindMediaBounds(const SceneDescription& scene, const std::vector<DrawnLeaf>& leaves,
                            glm::dvec3 centre) {
    MediaBounds box;
    for (const DrawnLeaf& leaf : leaves) {
        const LeafObject& object = leaf.object;
        if ((object.flags & HDS_INSTANCE_MEDIUM) == 0) {
            continue;
        }
        ForEachPlacement(scene, leaf.Prim().placement, [&](const glm::dmat4& worldFromObject) {
            for (int corner = 0; corner < 8; ++corner) {
                glm::dvec3 at = object.origin;
                for (int i = 0; i < 3; ++i) {
                    at[i] += static_cast<double>((corner >> i & 1) != 0 ? object.bounds.max[i]
                                                                        : object.bounds.min[i]);
                }
                const glm::dvec3 world = glm::dvec3(worldFromObject * glm::dvec4(at, 1.0)) - centre;
                box.min = glm::min(box.min, world);
                box.max = glm::max(box.max, world);
            }
        });
    }
    return box;
}

} // namespace hds
