// SPDX-License-Identifier: Apache-2.0
#include "hdStream/scene/placements.h"

#include "hdStream/scene/groupRecords.h"
#include "kernels/shared/frame.h"

#include <glm/matrix.hpp>

#include <algorithm>
#include <cmath>

namespace hds {

namespace {

/// The parent's categories and those of one of the instancer's instances.
std::set<std::string> CategoriesOf(const Placed& parent, const InstancerPrim& instancer,
                                   std::int32_t index) {
    std::set<std::string> categories = parent.categories;
    if (static_cast<std::size_t>(index) < instancer.instanceCategories.size()) {
        const std::set<std::string>& own =
            instancer.instanceCategories[static_cast<std::size_t>(index)];
        categories.insert(own.begin(), own.end());
    }
    return categories;
}

} // namespace

MovingTransform PlacementTransform(const Placement& placement, const Shutter& shutter) {
    return {placement.worldFromObject, placement.samples, shutter};
}

double NumPlacements(const SceneDescription& scene, const Placement& placement, int* chainLength) {
    double number = 1.0;
    const Placement* placed = &placement;
    int chain = 0;
    for (; !placed->instancerPath.empty() && chain < kMaxInstancerChain; ++chain) {
        const auto found = scene.instancers.find(placed->instancerPath);
        number *= static_cast<double>(placed->instances.size());
        if (found == scene.instancers.end()) {
            return 0.0;
        }
        placed = &found->second.placement;
    }
    if (chainLength != nullptr) {
        *chainLength = chain;
    }
    return number;
}

void WarnOfTooMany(const SceneDescription& scene, const std::string& path,
                   const Placement& placement, Warnings& warnings) {
    if (NumPlacements(scene, placement) > kMostPlacements) {
        warnings.Add(path, "placed more than 16777216 times by instancers in instancers; left out");
    }
}

std::vector<Placed> PlacementsOf(const SceneDescription& scene, const Placement& placement,
                                 const Shutter& shutter, int chain) {
    if (placement.instancerPath.empty()) {
        return {{PlacementTransform(placement, shutter), -1, {}}};
    }
    const auto found = scene.instancers.find(placement.instancerPath);
    if (found == scene.instancers.end() || !found->second.placement.visible ||
        chain >= kMaxInstancerChain ||
        (chain == 0 && NumPlacements(scene, placement) > kMostPlacements)) {
        return {};
    }
    const InstancerPrim& instancer = found->second;
    const std::size_t limit = instancer.instanceTransforms.Size();
    const SharedSpan<std::int32_t>& instances = placement.instances;
    const auto count = static_cast<std::int64_t>(instances.size());
    std::vector<Placed> placements;
    for (const Placed& parent : PlacementsOf(scene, instancer.placement, shutter, chain + 1)) {
        for (std::size_t rank = 0; rank < instances.size(); ++rank) {
            const std::int32_t index = instances[rank];
            if (index >= 0 && static_cast<std::size_t>(index) < limit) {
                placements.push_back(
                    {parent.worldFromObject * InstanceTransform(instancer, index, shutter) *
                         PlacementTransform(placement, shutter),
                     std::max<std::int64_t>(parent.id, 0) * count + std::int64_t(rank),
                     CategoriesOf(parent, instancer, index)});
            }
        }
    }
    return placements;
}

bool CanBeInverted(const glm::dmat4& matrix) {
    const double determinant = glm::determinant(matrix);
    return std::abs(determinant) > 0.0 && std::isfinite(determinant);
}

bool CanBeInverted(const MovingTransform& transform) {
    bool canBe = CanBeInverted(transform.AtFrame());
    for (int i = 0; transform.Moves() && i <= HDS_MAX_MOTION_SEGMENTS; ++i) {
        canBe = canBe && CanBeInverted(transform.At(double(i) / HDS_MAX_MOTION_SEGMENTS));
    }
    return canBe;
}

void ForEachPlacement(const SceneDescription& scene, const Placement& placement,
                      const std::function<void(const glm::dmat4&)>& onPlacement) {
    for (const Placed& placed : PlacementsOf(scene, placement, Shutter())) {
        onPlacement(placed.worldFromObject.AtFrame());
    }
}

void ForEachPlacement(const SceneDescription& scene, const Placement& placement,
                      const Shutter& shutter,
                      const std::function<void(const MovingTransform&)>& onPlacement) {
    for (const Placed& placed : PlacementsOf(scene, placement, shutter)) {
        onPlacement(placed.worldFromObject);
    }
}

} // namespace hds
