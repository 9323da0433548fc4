// SPDX-License-Identifier: Apache-2.0
// The flat hierarchy (kernels/shared/flatBvh.h): built over the triangles of placed meshes, from
// the tables of a scene whose pages are all there. Hits do not depend on it.
// Explained in docs/accel.md.
#pragma once

#include "hdStream/base/hugePages.h"
#include "kernels/shared/flatBvh.h"
#include "kernels/shared/geometry.h"

#include <cstdint>
#include <functional>
#include <limits>
#include <vector>

namespace hds {

/// What a flat hierarchy is made of. Positions are relative to the scene centre.
struct FlatSource {
    const shared::HdsBvhNode* topNodes = nullptr;
    const shared::HdsInstance* instances = nullptr;
    const std::vector<shared::HdsObject>* objects = nullptr; ///< 0: the TLAS
    /// The bytes of a chunk's geometry page, which stay where they are.
    std::function<const std::uint8_t*(std::uint32_t chunk)> page;
    /// Records of some groups lie in pages, and hits name them (HDS_FEATURE_INSTANCE_CHUNKS).
    bool hasInstanceChunks = false;
};

/// A finished flat hierarchy.
struct FlatBvh {
    HugeVector<std::uint8_t> buffer; ///< empty: there is nothing, or it would be too deep
    /// That it holds: flattened ones as often as they are placed, those of copies once.
    std::uint64_t numTriangles = 0;
    std::uint64_t numCopies = 0; ///< placements of meshes that have trees of their own
    bool hasInstances = false;   ///< some instances of the TLAS are not in it
};

/// About what a flat hierarchy takes.
constexpr std::uint64_t kFlatBytesATriangle = 80;

/// How much is flattened.
struct FlatAmount {
    std::uint64_t maxTriangles = 0; ///< that the hierarchy holds
    /// Of what an instance of the TLAS places: flattened copies of meshes that fit the caches of a
    /// CPU push each other out of them (docs/accel.md).
    double maxCopies = 4.0;
    /// Of all that is placed at least so much is flattened or a copy, or nothing.
    double minShare = 0.5;
    double manyTriangles = 1.5e6; ///< up to which maxCopies does not count
    /// That it may take: meshes of few triangles take more than kFlatBytesATriangle for each.
    double maxBytes = std::numeric_limits<double>::infinity();
};

/// Flattens instances of the TLAS, those of objects that are placed least often first; meshes that
/// are placed too often for that have trees of their own. Instances stay curves and points, what
/// moves, meshes below more than HDS_FLAT_MAX_RECORDS instances, and instances that are sheared so
/// strongly that boxes in world space could not be padded for it. Uses all cores; the result does
/// not depend on their number. Memory on the way, beside the result: about 50 bytes a triangle.
FlatBvh BuildFlatBvh(const FlatSource& source, const FlatAmount& amount);

} // namespace hds
