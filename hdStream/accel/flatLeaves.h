// SPDX-License-Identifier: Apache-2.0
// The leaves of the flat hierarchy, made of a page: those of one node of its BVH are joined while
// that is worth it. Private to the layer. Explained in docs/accel.md.
#pragma once

#include "hdStream/accel/boxRef.h"
#include "hdStream/accel/flatPlaces.h"

#include <array>
#include <cstdint>
#include <vector>

namespace hds {

/// The parts of a geometry page of triangles.
struct PageParts {
    const shared::HdsBvhNode* nodes;
    const shared::HdsTriangle* triangles;
    const std::uint32_t* primIds;
    const float* vertices;
    std::uint32_t numTriangles;

    explicit PageParts(const std::uint8_t* page);

    /// The number of a vertex.
    std::uint32_t Corner(std::uint32_t triangle, std::uint32_t corner) const {
        return static_cast<std::uint32_t>(triangles[triangle].vertices >>
                                              (corner * HDS_VERTEX_BITS) &
                                          (HDS_MAX_CHUNK_VERTICES - 1U));
    }
};

/// Chunk-local.
using FlatTriangles = std::array<std::uint32_t, HDS_FLAT_TRIANGLES>;

/// A leaf that may still be joined with others.
struct FlatLeafPlan {
    BoxRef box; ///< in world space, widened
    FlatTriangles triangles;
    std::uint8_t count; ///< of them
};

/// \param page of triangles at rest. \return leaves, depth first.
std::vector<FlatLeafPlan> PlanFlatLeaves(const PageParts& page, const FlatPlacement& placement);

} // namespace hds
