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

/// Upper bound. \param normals how normals are stored, if they are. \param numPoses that vertices,
/// normals and nodes are there in: 1 where nothing moves.
TriangleBytes BoundTriangleBytes(const std::vector<GeometryAttribute>& attributes,
                                 std::optional<Interpolation> normals, bool hasMaterials,
                                 std::size_t numPoses);

/// About what it is where a triangle adds `verticesPerTriangle`.
TriangleBytes MeanTriangleBytes(const std::vector<GeometryAttribute>& attributes,
                                std::optional<Interpolation> normals, bool hasMaterials,
                                std::size_t numPoses, double verticesPerTriangle);

/// What a primitive of curves or points adds, whose chunks have so many vertices a primitive.
/// \param vertexBytes of all poses. \param mean about what it is, else an upper
/// bound.
TriangleBytes SolidBytes(const std::vector<GeometryAttribute>& attributes,
                         double verticesPerPrimitive, std::size_t vertexBytes, std::size_t numPoses,
                         bool mean);

} // namespace hds
