// SPDX-License-Identifier: Apache-2.0
// The attribute page of a chunk (kernels/shared/geometry.h), and how large a chunk's pages may
// become. Explained in docs/geometry.md.
#pragma once

#include "hdStream/geometry/chunkSource.h"

#include <cstdint>
#include <optional>
#include <vector>

namespace hds {

/// The page of a chunk whose triangles and vertices are in final order.
std::vector<std::uint8_t> BuildAttributePage(const ChunkGeometry& chunk);

/// Vertices that a triangle of a chunk adds about, when a mesh has so many of both: those at the
/// chunk's border count again.
double VerticesPerTriangle(std::size_t numPoints, std::size_t numTriangles);

/// Upper bound. \param normals how normals are stored, if they are. \param moves vertices, normals
/// and nodes are there twice.
TriangleBytes BoundTriangleBytes(const std::vector<GeometryAttribute>& attributes,
                                 std::optional<Interpolation> normals, bool hasMaterials,
                                 bool moves);

/// About what it is where a triangle adds `verticesPerTriangle`.
TriangleBytes MeanTriangleBytes(const std::vector<GeometryAttribute>& attributes,
                                std::optional<Interpolation> normals, bool hasMaterials, bool moves,
                                double verticesPerTriangle);

/// What a primitive of curves or points adds, whose chunks have so many vertices a primitive.
/// \param vertexBytes of both ends, where they move. \param mean about what it is, else an upper
/// bound.
TriangleBytes SolidBytes(const std::vector<GeometryAttribute>& attributes,
                         double verticesPerPrimitive, std::size_t vertexBytes, bool moves,
                         bool mean);

} // namespace hds
