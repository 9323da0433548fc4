// SPDX-License-Identifier: Apache-2.0
// Shading normals: smooth ones computed from the triangles, and the repair of unusable authored
// ones. All normals point to the authored front: for a right-handed mesh that is the side from
// which the winding is counter-clockwise, along cross(p1 - p0, p2 - p0); for a left-handed one the
// other side. Internal to geometry. Explained in docs/geometry.md.
#pragma once

#include "hdStream/geometry/primvars.h"
#include "hdStream/geometry/triangleMesh.h"

#include <glm/vec3.hpp>

#include <cstddef>

namespace hds {

/// Unit normal of a triangle towards the authored front, in double.
glm::dvec3 FaceNormal(const TriangleMesh& mesh, std::size_t triangle);

/// Vertex normals of the triangles around each point, weighted by the sine of the corner's angle
/// over the lengths of its sides (Max 1999, "Weights for Computing Vertex Normals from Facet
/// Normals", Journal of Graphics Tools 4(2)): exact for points on a sphere. Points without a
/// direction of their own take their first triangle's normal. Parallel; the sums are in order of
/// triangles. Memory while it runs: 12 bytes per triangle and 8 per point.
GeometryAttribute ComputeSmoothNormals(const TriangleMesh& mesh);

/// Replaces normals that are zero or not finite, and used by a triangle, by the normal of the first
/// triangle that uses them. Copies the values only when there are any.
/// \return number of elements replaced. Precondition: 3 components, not Constant.
std::size_t RepairNormals(const TriangleMesh& mesh, const TopologySize& size,
                          GeometryAttribute& normals);

/// Whether any value is a normal that cannot be used.
bool HasUnusableNormals(const GeometryAttribute& normals);

/// False for a direction that is zero or not finite.
bool IsUsableNormal(const float* normal);

} // namespace hds
