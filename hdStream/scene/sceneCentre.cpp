// SPDX-License-Identifier: Apache-2.0
#include "hdStream/scene/sceneCentre.h"

#include <glm/geometric.hpp>

#include <cmath>

namespace hds {

namespace {

/// How far from the origin a scene may lie, in half diagonals, before it is recentred.
constexpr double kMaxRelativeDistance = 4.0;

} // namespace

void Reach::Extend(const glm::dvec3& point) {
    if (std::isfinite(point.x) && std::isfinite(point.y) && std::isfinite(point.z)) {
        min = glm::min(min, point);
        max = glm::max(max, point);
    }
}

Reach ReachOfLeaf(const DrawnLeaf& leaf) {
    Reach reach;
    const Placement& placement = leaf.Prim().placement;
    if (!placement.instancerPath.empty()) {
        return reach;
    }
    const LeafObject& object = leaf.object;
    for (int corner = 0; corner < 8; ++corner) {
        const glm::dvec3 point((corner & 1) != 0 ? object.bounds.max.x : object.bounds.min.x,
                               (corner & 2) != 0 ? object.bounds.max.y : object.bounds.min.y,
                               (corner & 4) != 0 ? object.bounds.max.z : object.bounds.min.z);
        reach.Extend(
            glm::dvec3(placement.worldFromObject * glm::dvec4(object.origin + point, 1.0)));
    }
    return reach;
}

Reach ReachBesideLeaves(const SceneDescription& scene) {
    Reach reach;
    for (const auto& [path, volume] : scene.volumes) {
        if (volume.placement.instancerPath.empty() && volume.placement.visible) {
            reach.Extend(glm::dvec3(volume.placement.worldFromObject[3]));
        }
    }
    for (const auto& [path, instancer] : scene.instancers) {
        if (!instancer.placement.instancerPath.empty() || !instancer.placement.visible) {
            continue;
        }
        for (std::size_t i = 0; i < instancer.instanceTransforms.Size(); ++i) {
            const glm::dmat4 transform =
                instancer.placement.worldFromObject * instancer.instanceTransforms.At(i);
            reach.Extend(glm::dvec3(transform[3]));
        }
    }
    return reach;
}

glm::dvec3 CentreOfReach(const Reach& reach) {
    if (reach.min.x > reach.max.x) {
        return glm::dvec3(0.0);
    }
    const glm::dvec3 middle = 0.5 * (reach.min + reach.max);
    const double halfDiagonal = 0.5 * glm::length(reach.max - reach.min);
    if (glm::length(middle) <= kMaxRelativeDistance * halfDiagonal) {
        return glm::dvec3(0.0);
    }
    // Rounded to a power of two of the scene's size, so that subtracting it loses no bits of nearby
    // positions that are themselves round.
    const double step = halfDiagonal > 0.0 ? std::exp2(std::floor(std::log2(halfDiagonal))) : 0.0;
    return step > 0.0 ? glm::round(middle / step) * step : middle;
}

glm::dvec3 ChooseSceneCentre(const SceneDescription& scene, const std::vector<DrawnLeaf>& leaves) {
    Reach reach = ReachBesideLeaves(scene);
    for (const DrawnLeaf& leaf : leaves) {
        reach.Extend(ReachOfLeaf(leaf));
    }
    return CentreOfReach(reach);
}

} // namespace hds
