// SPDX-License-Identifier: Apache-2.0
// Which instances a flat hierarchy takes, and where their meshes are. Private to the layer.
// Explained in docs/accel.md.
#pragma once

#include "hdStream/accel/flatBvh.h"
#include "hdStream/geometry/chunkSource.h"

#include <glm/mat4x4.hpp>

#include <array>
#include <cstdint>
#include <vector>

namespace hds {

/// A mesh in one place.
struct FlatPlacement {
    std::uint32_t object = 0;
    glm::dmat4 worldFromObject{1.0};
    bool isInPlace = false; ///< worldFromObject is the identity
    /// On the way, from the TLAS inwards.
    std::array<std::uint32_t, HDS_FLAT_MAX_RECORDS> records{};
    std::uint32_t numRecords = 0;
    /// Boxes are widened by 2^this of their largest coordinate (docs/accel.md, "Padding").
    int marginExponent = 0;
    bool isCopy = false; ///< of a mesh with a tree of its own
};

/// A place whose mesh has a tree of its own.
struct FlatCopy {
    std::uint32_t place = 0;
    Bounds bounds; ///< in world space, widened
};

/// An instance of the TLAS that stays one.
struct FlatInstance {
    std::uint32_t record = 0; ///< its number
    Bounds bounds;            ///< widened
};

/// What a flat hierarchy is built over.
struct FlatPlaces {
    std::vector<shared::HdsFlatPlace> places;
    std::vector<FlatPlacement> placements; ///< [places.size()]
    std::vector<FlatCopy> copies;
    std::vector<FlatPlacement> meshes; ///< of copies, each once, in its own space
    std::vector<shared::HdsFlatTransform> transforms;
    std::vector<FlatInstance> instances;
};

FlatPlaces FindFlatPlaces(const FlatSource& source, const FlatAmount& amount);

/// Widens a box by 2^exponent of its largest coordinate, and rounds it outwards.
Bounds WidenForFlat(const glm::dvec3& lo, const glm::dvec3& hi, int exponent);

/// Triangles of a geometry page, or primitives of another kind.
std::uint32_t NumPrimitivesOfPage(const std::uint8_t* page);

} // namespace hds
