// SPDX-License-Identifier: Apache-2.0
// A mesh description interpreted once: validated, triangulated, with normals and primvars ready to
// be cut into chunks. Immutable after Triangulate; any number of threads may read it. Explained in
// docs/geometry.md.
#pragma once

#include "hdStream/base/log.h"
#include "hdStream/geometry/meshDescription.h"

#include <glm/vec3.hpp>

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

namespace hds {

/// Axis-aligned box; empty when min > max.
struct Bounds {
    glm::vec3 min{1e30F};
    glm::vec3 max{-1e30F};
};

/// A primvar after validation. `corner` values are addressed by face-vertex index, `vertex` by
/// point.
struct MeshAttribute {
    std::string name;
    Interpolation interpolation = Interpolation::Constant; ///< Varying has become Vertex
    std::uint32_t numComponents = 1;
    SharedSpan<float> values;
    SharedSpan<std::int32_t> indices; ///< empty: direct
};

/// Triangles in the order of (authored face, sub-triangle); the index of a triangle is its primId.
struct TriangleMesh {
    glm::dvec3 origin{0.0};            ///< object-space point that `positions` are relative to
    std::vector<glm::vec3> positions;  ///< [numPoints], relative to origin
    std::vector<glm::uvec3> triangles; ///< [numTriangles] point indices, authored winding
    std::vector<std::uint32_t> faces;  ///< [numTriangles] authored face
    std::vector<glm::uvec3> corners;   ///< [numTriangles] face-vertex indices
    std::vector<std::uint32_t>
        materialEntries;                   ///< [numTriangles] 0 = prim, 1 + subset; empty: all 0
    std::vector<MeshAttribute> attributes; ///< user primvars, in the order of their names
    MeshAttribute normals; ///< authored or computed (Vertex, Uniform or FaceVarying), already
                           ///< flipped for left-handed meshes; values empty: flat
    bool leftHanded = false;
    Bounds bounds; ///< relative to origin
};

/// Validates and triangulates. Bad content warns with `primPath`, is counted and dropped:
/// out-of-range indices, NaN or infinite points, faces with fewer than 3 vertices, zero-area
/// triangles, primvars of wrong length. Never throws on content; an unusable mesh has no triangles.
/// \param refineLevel above 0, catmullClark, loop and bilinear meshes are subdivided so many times
/// (at most 8), with points and normals of the limit surface; 0 draws the cage. `faces` stay
/// authored faces. Cost: O(face vertices), ear clipping for concave faces.
std::shared_ptr<const TriangleMesh> Triangulate(const MeshDescription& mesh,
                                                const std::string& primPath, Warnings& warnings,
                                                int refineLevel = 0);

/// A chunk's geometry: a subset of a mesh's triangles with local vertices.
struct ChunkGeometry {
    std::vector<glm::vec3> positions;   ///< local vertices
    std::vector<glm::uvec3> triangles;  ///< local vertex indices
    std::vector<std::uint32_t> primIds; ///< [numTriangles] index into TriangleMesh::triangles
    std::vector<std::uint32_t> points;  ///< [numLocalVertices] point index of a local vertex
};

/// Where a chunk's triangles come from: an immutable snapshot. Today a triangulated mesh; part 3
/// adds subdivision and displacement behind the same interface. Thread-safe.
class ChunkSource {
public:
    explicit ChunkSource(std::shared_ptr<const TriangleMesh> mesh) : _mesh(std::move(mesh)) {}
    const TriangleMesh& Mesh() const { return *_mesh; }
    /// Gathers the triangles `primIds` (any order is kept).
    ChunkGeometry Gather(const std::uint32_t* primIds, std::size_t count) const;

private:
    std::shared_ptr<const TriangleMesh> _mesh;
};

/// The attribute page (kernels/shared/geometry.h) of a chunk whose triangles are in final order.
std::vector<std::uint8_t> BuildAttributePage(const TriangleMesh& mesh, const ChunkGeometry& chunk);

/// Upper bound of the bytes a triangle adds to both pages, used to plan chunks.
std::size_t EstimateBytesPerTriangle(const TriangleMesh& mesh);

} // namespace hds
