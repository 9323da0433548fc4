// SPDX-License-Identifier: Apache-2.0
// Points of a diced limit surface: displaced positions and normals. What faces share is evaluated
// on one of them, the lowest that is drawn, so that it has the same bits everywhere. Internal to
// geometry. Explained in docs/geometry.md.
#pragma once

#include "hdStream/geometry/displacement.h"
#include "hdStream/geometry/faceSurface.h"

#include <array>
#include <vector>

namespace hds {

/// The displacement of a subdivided mesh. Immutable.
struct SubdivDisplacement {
    Displacement owner;               ///< of what `amounts` point to
    std::vector<BoundAmount> amounts; ///< by material entry; empty: not displaced
    AmountRange range;
    bool hasVectors = false;
    bool IsActive() const { return range.low != 0.0 || range.high != 0.0; }
    /// The same everywhere: normals stay.
    bool IsConstant() const { return range.low == range.high; }
};

/// A cage face and a point of it.
struct FaceLocation {
    int face = -1;
    FacePoint at;
};

/// Object-space position and unit normal towards the authored front.
struct SurfacePoint {
    glm::dvec3 position{0.0};
    glm::dvec3 normal{0.0};
    glm::dvec3 movedBy{0.0};    ///< from where it lies undisplaced
    glm::dvec3 restNormal{0.0}; ///< unit, undisplaced
};

/// Evaluates points for one piece of work. Externally synchronised.
class SubdivPoints {
public:
    /// \param entries material entry by authored face; empty: all 0.
    SubdivPoints(const SubdivModel& model, const SubdivDisplacement& displacement,
                 const std::vector<std::uint32_t>& entries)
        : _model(model), _displacement(displacement), _entries(entries), _surfaces(model) {}

    /// Where shared points are evaluated. \param t from the first vertex that OpenSubdiv has of it.
    FaceLocation OnEdge(int edge, double t) const;
    FaceLocation AtVertex(int vertex) const;

    SurfacePoint Inside(const FaceLocation& location);
    SurfacePoint Edge(int edge, double t);
    SurfacePoint Vertex(int vertex);
    /// Displaced along the face's own normal and by vectors, whatever other faces say.
    glm::dvec3 OwnPosition(const FaceLocation& location);
    /// The normal that a face has at a point of a sharp edge, or of a sharp vertex: the mean of the
    /// faces on the same side of the sharp edges there.
    glm::dvec3 EdgeSideNormal(const FaceLocation& location);
    glm::dvec3 VertexSideNormal(int vertex, int face);
    /// Of the undisplaced surface of a face.
    glm::dvec3 RestNormal(const FaceLocation& location);

    FaceSurface& Surface(int face) { return _surfaces.At(face); }

private:
    FaceLocation EdgeIn(int face, int edge, double t) const;
    FaceLocation VertexIn(int face, int vertex) const;
    SurfacePoint Shared(const std::vector<FaceLocation>& locations, bool isSharp);
    /// The amount's place in _point.
    void FindPoint(const BoundAmount& bound, const FaceLocation& location);
    double Amount(const FaceLocation& location);
    glm::dvec3 Vector(const FaceLocation& location);
    CoordinateFrame FrameAt(const FaceLocation& location, std::size_t coordinates);
    std::array<double, 4> PrimvarAt(std::size_t attribute, const FaceLocation& location);
    glm::dvec3 Normal(const FaceLocation& location);
    glm::dvec3 DisplacedNormal(const FaceLocation& location);

    const SubdivModel& _model;
    const SubdivDisplacement& _displacement;
    const std::vector<std::uint32_t>& _entries;
    FaceSurfaces _surfaces;
    std::vector<FaceLocation> _locations;
    std::vector<double> _row;
    AmountPoint _point;
};

} // namespace hds
