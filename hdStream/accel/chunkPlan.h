// SPDX-License-Identifier: Apache-2.0
// The plan that cuts geometry into chunks, made before any triangle is. Explained in docs/accel.md.
#pragma once

#include "hdStream/geometry/chunkSource.h"
#include "kernels/shared/geometry.h"

#include <cstdint>
#include <vector>

namespace hds {

/// Chunks of geometry: chunk i owns groups[begin[i] .. begin[i + 1]).
struct ChunkPlan {
    std::vector<std::uint32_t> groups; ///< a permutation of the groups that are drawn
    std::vector<std::uint32_t> begin;  ///< numChunks + 1 entries
    std::vector<Bounds> bounds;        ///< [numChunks] holds the groups
    std::vector<std::uint32_t> counts; ///< [numChunks] triangles, upper bounds

    std::size_t NumChunks() const { return bounds.size(); }
};

/// Groups the groups into spatially compact chunks of at most `maxTriangles` (at least 1; a group
/// of more is a chunk of its own) and at most `maxVertices` different vertices. Groups are sorted
/// into the cells of a grid, and the grid is cut by the surface area heuristic until each part is
/// small enough: two passes over the groups, whatever the number of chunks. Deterministic; uses all
/// cores.
ChunkPlan PlanChunks(const PrimitiveGroups& source, std::uint32_t maxTriangles,
                     std::uint32_t maxVertices = HDS_MAX_CHUNK_VERTICES);

} // namespace hds
