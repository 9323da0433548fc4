// SPDX-License-Identifier: Apache-2.0
// A whole mesh interpreted at once: validated, triangulated, with normals and primvars. Immutable
// after Triangulate; any number of threads may read it. Explained in docs/geometry.md.
#pragma once

#include "hdStream/base/log.h"
#include "hdStream/geometry/chunkSource.h"

#include <glm/vec3.hpp>

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

namespace hds {

/// Triangles in the order of (authored face, sub-triangle); the index of a triangle is its primId.
struct TriangleMesh {
    glm::dvec3 origin{0.0};            ///< object-space point that `positions` are relative to
    std::vector<glm::vec3> positions;  ///< [numPoints], relative to origin
    std::vector<glm::uvec3> triangles; ///< [numTriangles] point indices, authored winding
    std::vector<std::uint32_t> faces;  ///< [numTriangles] authored face
    std::vector<glm::uvec3> corners;   ///< [numTriangles] face-vertex indices
    std::vector<std::uint32_t>
        materialEntries; ///< [numTriangles] 0 = prim, 1 + subset; empty: all 0
    std::vector<GeometryAttribute> attributes; ///< user primvars, in the order of their names
    GeometryAttribute normals; ///< authored or computed (Vertex, Uniform or FaceVarying), already
                               ///< flipped for left-handed meshes; values empty: flat
    bool leftHanded = false;
    Bounds bounds; ///< relative to origin
};

/// Validates and triangulates. Bad content warns with `primPath`, is counted and dropped:
/// out-of-range indices, NaN or infinite points, faces with fewer than 3 vertices, zero-area
/// triangles, primvars of wrong length. Never throws on content; an unusable mesh has no triangles.
/// Surfaces are drawn as their cages. Cost: O(face vertices), ear clipping for concave faces.
std::shared_ptr<const TriangleMesh> Triangulate(const GeometryDescription& mesh,
                                                const std::string& primPath, Warnings& warnings);

} // namespace hds
