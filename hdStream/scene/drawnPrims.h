// SPDX-License-Identifier: Apache-2.0
// What is said of a single prim that is drawn, or may be.
#pragma once

#include "hdStream/scene/commit.h"
#include "hdStream/scene/drawnPaths.h"

#include <algorithm>

namespace hds {

/// What rays see of a prim, and what they see in its place.
constexpr std::uint32_t kSeenFlags =
    HDS_INSTANCE_SEEN | HDS_INSTANCE_HOLDOUT | HDS_INSTANCE_CATCHER;

/// Whether a prim is drawn where it is visible.
inline bool MayBeDrawn(const GeometryStore::Entry& entry, const CommitOptions& options) {
    const auto& [path, prim] = entry;
    const std::vector<std::string>& purposes = options.purposes;
    return prim.geometry &&
           std::find(purposes.begin(), purposes.end(), prim.purpose) != purposes.end() &&
           IsDrawnPath(path, options.drawnPaths, options.hiddenPaths);
}

inline bool IsVisible(const GeometryStore::Entry& entry) {
    return entry.second.placement.visible;
}

/// Adds a prim to the counts of the scene.
inline void CountPrim(const GeometryDescription& geometry, std::uint64_t numPrimitives,
                      SceneCounts* counts) {
    switch (geometry.primitives) {
    case PrimitiveKind::Faces:
        counts->triangles += numPrimitives;
        ++counts->meshes;
        break;
    case PrimitiveKind::Curves:
        counts->curves += geometry.faceVertexCounts.size();
        break;
    case PrimitiveKind::Points:
        counts->points += numPrimitives;
        break;
    case PrimitiveKind::Splats:
        counts->splats += numPrimitives;
        break;
    }
}

} // namespace hds
