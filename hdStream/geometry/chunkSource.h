// SPDX-License-Identifier: Apache-2.0
// Where the triangles (or points, or pieces of curves) of chunks come from: an immutable snapshot
// of a mesh, cut into groups that can be prepared apart from each other. What a plan needs (boxes,
// counts) is cheap; triangles are made when a chunk is. Explained in docs/geometry.md.
#pragma once

#include "hdStream/geometry/geometryDescription.h"

#include <glm/vec3.hpp>

#include <array>
#include <cstdint>
#include <string>
#include <vector>

namespace hds {

/// Axis-aligned box; empty when min > max.
struct Bounds {
    glm::vec3 min{1e30F};
    glm::vec3 max{-1e30F};
};

/// A primvar after validation. The interpolation says what an element is: a point (Vertex; on faces
/// Varying has become Vertex), an authored face or curve (Uniform), a face-vertex (FaceVarying),
/// the joint of two segments of a curve (Varying).
struct GeometryAttribute {
    std::string name;
    Interpolation interpolation = Interpolation::Constant;
    std::uint32_t numComponents = 1;
    SharedSpan<float> values;
    SharedSpan<std::int32_t> indices; ///< empty: direct
    std::uint32_t numTuples = 1;      ///< of numComponents each, that an element has

    /// Floats of an element.
    std::uint32_t NumFloats() const { return numComponents * numTuples; }
};

/// What the pages hold of a user primvar.
struct AttributeFormat {
    std::string name;
    std::uint32_t numComponents = 1;
};

/// Bytes that a triangle adds to each page of a chunk.
struct TriangleBytes {
    std::uint32_t geometry = 0; ///< nodes, indices, vertices
    std::uint32_t attributes = 0;
    std::uint32_t Both() const { return geometry + attributes; }
};

/// The ellipsoid of a Gaussian splat, as pages have it.
struct SplatShape {
    std::array<float, 4> turn{}; ///< unit quaternion: i, j, k, real
    /// The standard deviations along the turned axes where shapes move, else one over them.
    std::array<float, 3> sizes{};
    float cutoff = 0.0F; ///< squared distance, in standard deviations, where it ends
};

/// What of a chunk moves, at a time while the shutter is open.
struct ChunkKey {
    std::vector<glm::vec3> positions;    ///< [numVertices]
    SharedSpan<float> normals;           ///< of the elements of the chunk's; empty: those
    std::vector<float> radii;            ///< [numVertices] of curves and points
    std::vector<SplatShape> shapes;      ///< [numVertices] of splats whose shapes move
    std::vector<Bounds> primitiveBounds; ///< [numTriangles] of curves and points
};

/// A chunk's triangles, with all values that its pages hold.
struct ChunkGeometry {
    std::vector<glm::vec3> positions;  ///< [numVertices] relative to the source's origin
    std::vector<glm::uvec3> triangles; ///< [numTriangles] vertices, authored winding
    /// [numTriangles] unique in the geometry; ascending in (authored face, sub-triangle)
    std::vector<std::uint32_t> primIds;
    std::vector<std::uint32_t> faces;           ///< [numTriangles] authored face
    std::vector<std::uint32_t> materialEntries; ///< [numTriangles] 0 = prim, 1 + subset; empty: 0
    std::vector<std::uint32_t> points;          ///< [numVertices] element of Vertex attributes
    std::vector<glm::uvec3> corners; ///< [numTriangles] elements of FaceVarying attributes
    std::vector<GeometryAttribute> attributes; ///< as ChunkSource::Attributes
    GeometryAttribute normals; ///< object space, towards the authored front; values empty: flat
    /// After the opening of the shutter, where all else is, at equal steps of time; the last one
    /// when it closes. Empty: nothing moves. At most HDS_MAX_DEFORMATION_SEGMENTS.
    std::vector<ChunkKey> keys;

    /// HDS_PRIMITIVE_* (kernels/shared/geometry.h). Of curves and points an entry of `triangles` is
    /// the first vertex and the piece's bits above it; vertices stay in their order.
    std::uint32_t primitives = 0;
    std::vector<float> radii;            ///< [numVertices] of curves and points
    std::vector<glm::vec3> jointNormals; ///< [numVertices] of ribbons
    std::vector<SplatShape> shapes;      ///< [numVertices] of splats, whose radii are opacities
    std::vector<std::uint32_t> joints;   ///< [numVertices] element of Varying attributes
    std::vector<Bounds> primitiveBounds; ///< [numTriangles] of curves and points
};

/// Bytes of the elements of vectors.
template <typename... T>
std::uint64_t VectorBytes(const std::vector<T>&... vectors) {
    return (std::uint64_t{0} + ... + (vectors.size() * sizeof(T)));
}

/// What a plan of chunks needs to know: groups with boxes. Immutable, thread-safe.
class PrimitiveGroups {
public:
    virtual ~PrimitiveGroups() = default;

    /// Holds all groups; empty when nothing can be drawn.
    const Bounds& AllBounds() const { return _bounds; }
    std::uint32_t NumPrimitiveGroups() const { return _numGroups; }
    /// Upper bound; exact for polygons.
    std::uint64_t NumTriangles() const { return _numTriangles; }
    /// Upper bound of the different vertices of all triangles.
    std::uint64_t NumVertices() const { return _numVertices; }

    /// Upper bound; 0 for a group that is not drawn.
    virtual std::uint32_t GroupTriangles(std::uint32_t group) const = 0;
    /// Holds the group's triangles; empty for one that is not drawn.
    virtual Bounds GroupBounds(std::uint32_t group) const = 0;

protected:
    Bounds _bounds;
    std::uint32_t _numGroups = 0;
    std::uint64_t _numTriangles = 0;
    std::uint64_t _numVertices = 0;
};

/// Geometry ready to be cut into chunks. Immutable, thread-safe; results depend on nothing but what
/// the source was made of. Groups are numbered in the order of authored faces.
class ChunkSource : public PrimitiveGroups {
public:
    /// Object-space point that positions and boxes are relative to.
    const glm::dvec3& Origin() const { return _origin; }
    bool IsLeftHanded() const { return _isLeftHanded; }
    /// User primvars, in the order of their slots: sorted by name.
    const std::vector<AttributeFormat>& Attributes() const { return _attributes; }
    /// Upper bound of what a triangle adds to the pages of a chunk.
    const TriangleBytes& BoundBytes() const { return _boundBytes; }
    /// About what it adds where vertices are shared as they are on the mesh's average.
    const TriangleBytes& MeanBytes() const { return _meanBytes; }

    /// The triangles of some groups, in their order. Same groups, same bits, whatever was asked
    /// before.
    virtual ChunkGeometry Gather(const std::uint32_t* groups, std::size_t count) const = 0;

    /// About the host memory that it takes, without the arrays of the geometry.
    virtual std::uint64_t TableBytes() const { return 0; }

protected:
    glm::dvec3 _origin{0.0};
    bool _isLeftHanded = false;
    std::vector<AttributeFormat> _attributes;
    TriangleBytes _boundBytes;
    TriangleBytes _meanBytes;
};

} // namespace hds
