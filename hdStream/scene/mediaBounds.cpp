// SPDX-License-Identifier: Apache-2.0
#include "hdStream/scene/mediaBounds.h"

#include "hdStream/scene/groupRecords.h"
#include "hdStream/scene/placements.h"
#include "kernels/shared/frame.h"

#include <glm/common.hpp>

#include <algorithm>

namespace hds {

namespace {

void Grow(MediaBounds* grown, const MediaBounds& box, const glm::dmat4& transform) {
    for (int corner = 0; corner < 8; ++corner) {
        glm::dvec3 at;
        for (int i = 0; i < 3; ++i) {
            at[i] = (corner >> i & 1) != 0 ? box.max[i] : box.min[i];
        }
        const glm::dvec3 moved = glm::dvec3(transform * glm::dvec4(at, 1.0));
        grown->min = glm::min(grown->min, moved);
        grown->max = glm::max(grown->max, moved);
    }
}

/// Wherever a transform takes the box while the shutter is open: at the frame, and at the times of
/// all keys that there may be, between which it goes straight.
void GrowAlong(MediaBounds* grown, const MediaBounds& box, const MovingTransform& transform) {
    Grow(grown, box, transform.AtFrame());
    for (int i = 0; transform.Moves() && i <= HDS_MAX_MOTION_SEGMENTS; ++i) {
        Grow(grown, box, transform.At(double(i) / HDS_MAX_MOTION_SEGMENTS));
    }
}

/// A box around all placements, level by level: looser than placement by placement, and no matter
/// how many they are.
MediaBounds AroundPlacements(const SceneDescription& scene, const Placement& placement,
                             const Shutter& shutter, MediaBounds box) {
    const Placement* placed = &placement;
    for (int chain = 0; !placed->instancerPath.empty() && chain < kMaxInstancerChain; ++chain) {
        const auto found = scene.instancers.find(placed->instancerPath);
        MediaBounds above;
        for (const std::int32_t index : placed->instances) {
            if (found != scene.instancers.end() && index >= 0 &&
                static_cast<std::size_t>(index) < found->second.instanceTransforms.Size()) {
                GrowAlong(&above, box,
                          InstanceTransform(found->second, index, shutter) *
                              PlacementTransform(*placed, shutter));
            }
        }
        if (above.min.x > above.max.x) {
            return above;
        }
        box = above;
        placed = &found->second.placement;
    }
    MediaBounds world;
    GrowAlong(&world, box, PlacementTransform(*placed, shutter));
    return world;
}

} // namespace

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
                            glm::dvec3 centre, const Shutter& shutter) {
    MediaBounds box;
    for (const DrawnLeaf& leaf : leaves) {
        const LeafObject& object = leaf.object;
        if ((object.flags & HDS_INSTANCE_MEDIUM) == 0) {
            continue;
        }
        MediaBounds own;
        for (int i = 0; i < 3; ++i) {
            own.min[i] = object.origin[i] + static_cast<double>(object.bounds.min[i]);
            own.max[i] = object.origin[i] + static_cast<double>(object.bounds.max[i]);
        }
        const Placement& placement = leaf.Prim().placement;
        glm::dmat4 fromWorld(1.0);
        fromWorld[3] = glm::dvec4(-centre, 1.0);
        if (NumPlacements(scene, placement) > kMostPlacements) {
            Grow(&box, AroundPlacements(scene, placement, shutter, own), fromWorld);
            continue;
        }
        ForEachPlacement(scene, placement, shutter, [&](const MovingTransform& worldFromObject) {
            GrowAlong(&box, own, MovingTransform(fromWorld) * worldFromObject);
        });
    }
    return box;
}

} // namespace hds
