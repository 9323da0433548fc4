// SPDX-License-Identifier: Apache-2.0
// The BVH builder: one 8-wide compressed BVH over any boxes (triangles, chunks, instances).
// Deterministic: the result does not depend on the thread count.
// Explained in docs/accel.md.
#pragma once

#include "hdStream/geometry/chunkSource.h"
#include "kernels/shared/geometry.h"

#include <cstdint>
#include <vector>

namespace hds {

/// An 8-wide BVH. Items are referenced in leaf order: slot i of the order holds item `order[i]`.
struct Bvh {
    std::vector<shared::HdsBvhNode> nodes; ///< root first; empty when there are no items
    /// Of boxes that move: as many as `nodes` for each of the later keys, one after the other; they
    /// differ in origin, exponents and planes only. Else empty.
    std::vector<shared::HdsBvhNode> laterNodes;
    std::vector<std::uint32_t> order; ///< permutation of the items
    Bounds bounds;                    ///< at all times
};

/// Options of a build.
struct BvhOptions {
    std::uint32_t maxLeafItems = HDS_BVH_MAX_LEAF_ITEMS; ///< 1 to 3
    float traversalCost = 1.0F;                          ///< of a node, relative to...
    float itemCost = 0.3F;                               ///< ...the cost of testing one item
    /// Boxes that move take about twice the time and bytes of others: they are made where boxes
    /// at rest, which hold both ends, have more than this times their area.
    float restingArea = 2.0F;
    /// Not null: the items of a leaf are of one unit, and are tested together at the cost of one.
    const std::uint32_t* unitOfItem = nullptr;
    /// Beside unitOfItem: how many of maxLeafItems each item is.
    const std::uint8_t* sizeOfItem = nullptr;
};

/// Builds with the surface area heuristic (binned; Wald 2007) and collapses to 8-wide optimally
/// (Ylitie 2017, section 3.1). Uses all cores. Any finite box is allowed, also flat, equal or empty
/// ones (min > max: never hit, kept as a point). At most HDS_BVH_MAX_DEPTH nodes lie on a path.
/// Memory on the way, beside the items and the result: 72 bytes an item.
Bvh BuildBvh(const std::vector<Bounds>& items, const BvhOptions& options);
/// The same, of many items that nobody needs any more: frees them before anything else is built.
Bvh BuildBvh(std::vector<Bounds>&& items, const BvhOptions& options);

/// The same for boxes that go straight from key to key while the shutter is open, with boxes that
/// move or, where they do not go far, with boxes at rest. \param keys boxes of the items at equal
/// steps of time: at least when it opens and when it closes.
Bvh BuildMovingBvh(const std::vector<std::vector<Bounds>>& keys, const BvhOptions& options);

/// A finished geometry page (kernels/shared/geometry.h).
struct GeometryPage {
    std::vector<std::uint8_t> bytes;
    std::uint32_t numNodes = 0; ///< those of later keys not counted
    Bounds bounds;
};

/// Builds the chunk's BVH and page. Reorders the triangles of `chunk` into leaf order and its
/// vertices into order of first use. \pre at most HDS_MAX_CHUNK_VERTICES.
GeometryPage BuildGeometryPage(ChunkGeometry& chunk);

} // namespace hds
