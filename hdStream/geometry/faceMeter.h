// SPDX-License-Identifier: Apache-2.0
// Measures a cage face's limit surface: a box that holds it and the levels its edges ask for.
// Internal to geometry. Explained in docs/geometry.md.
#pragma once

#include "hdStream/geometry/dicing.h"
#include "hdStream/geometry/edgeDemand.h"
#include "hdStream/geometry/faceSurface.h"

#include <cstdint>
#include <functional>
#include <vector>

namespace hds {

/// A box in double, relative to nothing; empty when min > max.
struct ExactBox {
    glm::dvec3 min{1e300};
    glm::dvec3 max{-1e300};
    void Add(const glm::dvec3& point);
    void Add(const ExactBox& other);
    /// On all sides, by a part of its diagonal.
    void Grow(double part);
};

/// How far a surface is moved.
struct SurfaceMove {
    double range = 0.0; ///< by how much amounts differ over the mesh, object space
    /// Where a point of the face is moved to; empty: all of it by the same.
    std::function<glm::dvec3(const FacePoint&)> positionAt;
};

/// Measures one face. Externally synchronised.
class FaceMeter {
public:
    FaceMeter(const SubdivModel& model, int face);

    /// Holds the limit surface of the face. Regular quads: the hull of its Bezier points. Others:
    /// the hull of the cage's points, a little enlarged, because OpenSubdiv approximates
    /// extraordinary corners.
    ExactBox Box() const;
    /// Of a part of the face, unless it is no quad or has semi-sharp edges: then of all of it.
    ExactBox BoxOver(const PatternBox& part) const;

    /// The level that each edge asks for: what the limit surface needs, and what lines of the
    /// moved one do. \param levels [edges of the face]
    void RequestLevels(const DicingOptions& options, const SurfaceMove& move,
                       std::uint8_t* levels) const;

private:
    bool IsBent() const;
    ExactBox HullBox() const;
    void AddSquare(const PatternBox& part, const PatternBox& square, int depth,
                   ExactBox& box) const;
    std::vector<glm::dvec3> SamplePoints(int n) const;
    void AddMoved(const SurfaceMove& move, const Screen& screen, std::size_t numCells,
                  GridDemand* demand) const;
    bool IsBezier() const { return _shape == FaceShape::Quad && _surface.IsRegular(); }

    const SubdivModel& _model;
    int _face;
    FaceShape _shape;
    FaceSurface _surface;
    std::vector<glm::dvec3> _net; ///< of a regular quad: Bezier points [v][u]
};

} // namespace hds
