// SPDX-License-Identifier: Apache-2.0
// Checks primvars against a mesh's topology and reads their values. No array is copied.
// Explained in docs/geometry.md.
#pragma once

#include "hdStream/geometry/triangleMesh.h"

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>

namespace hds {

/// Sizes of the authored topology that primvars must agree with.
struct TopologySize {
    std::size_t numPoints = 0;
    std::size_t numFaces = 0;
    std::size_t numCorners = 0; ///< sum of faceVertexCounts
    std::size_t numJoints = 0;  ///< of curves: ends of segments
    bool hasJoints = false;     ///< Varying means joints, else points
};

/// Number of values that an interpolation asks for.
std::size_t NumElements(Interpolation interpolation, const TopologySize& size);

/// The primvar as an attribute; nothing, and one warning, when it cannot be used. Varying becomes
/// Vertex where there are no joints. Values that are not finite are kept.
std::optional<GeometryAttribute> ValidatePrimvar(const Primvar& primvar, const TopologySize& size,
                                                 const std::string& primPath, Warnings& warnings);

/// One warning with the number of values that are not finite, if there are any. Reads all values.
void WarnNotFinite(const GeometryAttribute& attribute, const std::string& primPath,
                   Warnings& warnings);

/// Index of the value tuple of an element (point, face or face-vertex; 0 for Constant).
inline std::size_t ValueIndex(const GeometryAttribute& attribute, std::size_t element) {
    return attribute.indices.empty() ? element
                                     : static_cast<std::size_t>(attribute.indices[element]);
}

/// The value tuple of an element.
inline const float* ValueOf(const GeometryAttribute& attribute, std::size_t element) {
    return attribute.values.data() + ValueIndex(attribute, element) * attribute.NumFloats();
}

} // namespace hds
