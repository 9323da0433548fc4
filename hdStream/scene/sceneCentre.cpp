// SPDX-License-Identifier: Apache-2.0
#include "hdStream/scene/sceneCentre.h"

#include <glm/geometric.hpp>

#include <cmath>

namespace hds {

namespace {

/// How far from the origin a scene may lie, in half diagonals, before it is recentred.
constexpr double kMaxRelativeDistance = 4.0;

struct DoubleBounds {
    glm::dvec3 min{1e300};
    glm::dvec3 max{-1e300};
    void Extend(const glm::dvec3& point) {
        if (std::isfinite(point.x) && std::isfinite(point.y) && std::isfinite(point.z)) {
            min = glm::min(min, point);
            max = glm::max(max, point);
        }
    }
};

void ExtendByLeaf(const glm::dmat4& worldFromObject, const LeafObject& leaf, DoubleBounds* bounds) {
    for (int corner = 0; corner < 8; ++corner) {
        const glm::dvec3 point((corner & 1) != 0 ? leaf.bounds.max.x : leaf.bounds.min.x,
                               (corner & 2) != 0 ? leaf.bounds.max.y : leaf.bounds.min.y,
                               (corner & 4) != 0 ? leaf.bounds.max.z : leaf.bounds.min.z);
        bounds->Extend(glm::dvec3(worldFromObject * glm::dvec4(leaf.origin + point, 1.0)));
    }
}

} // namespace

glm::dvec3 ChooseSceneCentre(const SceneDescription& scene, const std::vector<DrawnLeaf>& leaves) {
    DoubleBounds bounds;
    for (const DrawnLeaf& leaf : leaves) {
        const Placement& placement = leaf.Prim().placement;
        if (placement.instancerPath.empty()) {
            ExtendByLeaf(placement.worldFromObject, leaf.object, &bounds);
        }
    }
    for (const auto& [path, volume] : scene.volumes) {
        if (volume.placement.instancerPath.empty() && volume.placement.visible) {
            bounds.Extend(glm::dvec3(volume.placement.worldFromObject[3]));
        }
    }
    for (const auto& [path, instancer] : scene.instancers) {
        if (!instancer.placement.instancerPath.empty() || !instancer.placement.visible) {
            continue;
        }
        for (std::size_t i = 0; i < instancer.instanceTransforms.Size(); ++i) {
            const glm::dmat4 transform =
                instancer.placement.worldFromObject * instancer.instanceTransforms.At(i);
            bounds.Extend(glm::dvec3(transform[3]));
        }
    }
    if (bounds.min.x > bounds.max.x) {
        return glm::dvec3(0.0);
    }
    const glm::dvec3 middle = 0.5 * (bounds.min + bounds.max);
    const double halfDiagonal = 0.5 * glm::length(bounds.max - bounds.min);
    if (glm::length(middle) <= kMaxRelativeDistance * halfDiagonal) {
        return glm::dvec3(0.0);
    }
    // Rounded to a power of two of the scene's size, so that subtracting it loses no bits of nearby
    // positions that are themselves round.
    const double step = halfDiagonal > 0.0 ? std::exp2(std::floor(std::log2(halfDiagonal))) : 0.0;
    return step > 0.0 ? glm::round(middle / step) * step : middle;
}

} // namespace hds
