// SPDX-License-Identifier: Apache-2.0
// Measures a cage face's limit surface: a box that holds it and the levels its edges ask for.
// Internal to geometry. Explained in docs/geometry.md.
#pragma once

#include "hdStream/geometry/dicing.h"
#include "hdStream/geometry/displacement.h"
#include "hdStream/geometry/edgeDemand.h"
#include "hdStream/geometry/faceSurface.h"

#include <algorithm>
#include <cmath>
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

/// How a surface is moved.
struct SurfaceMove {
    /// Of the amounts over the mesh, object space; of vectors from minus the greatest length to it.
    AmountRange range;
    /// Where a point of the face is moved to; empty: all of it by the same along the normals.
    std::function<glm::dvec3(const FacePoint&)> positionAt;

    bool IsEven() const { return range.low == range.high; }
    /// How far from where it was a point is, at most.
    double Reach() const { return std::max(std::fabs(range.low), std::fabs(range.high)); }
};

/// Samples of a moved face in object space, taken when they are first asked for.
struct MovedSamples {
    std::vector<glm::dvec3> grid;
    std::vector<std::vector<glm::dvec3>> lines; ///< along the parameters u and v in turn
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
    /// moved one do, from where that is, in the place of the view that needs most.
    /// \param levels [edges of the face]
    void RequestLevels(const DicingOptions& options, const SurfaceMove& move,
                       std::uint8_t* levels) const;

private:
    bool IsBent() const;
    ExactBox HullBox() const;
    void AddSquare(const PatternBox& part, const PatternBox& square, int depth,
                   ExactBox& box) const;
    /// What is measured of the face, where the same amount moves all of it: there.
    struct Net {
        std::vector<glm::dvec3> points; ///< object space
        std::size_t n = 0;
        bool isBezier = false;
    };
    using PositionAt = std::function<glm::dvec3(const FacePoint&)>;
    std::vector<glm::dvec3> SamplePoints(int n, const PositionAt& positionAt) const;
    Net MakeNet(const SurfaceMove& move) const;
    GridDemand Measure(const std::vector<glm::dvec3>& points, std::size_t n, bool isBezier) const;
    void TakeLines(const SurfaceMove& move, std::size_t numCells, MovedSamples* moved) const;
    void AddMoved(const SurfaceMove& move, const Screen& screen, bool isNear, std::uint32_t most,
                  MovedSamples* moved, GridDemand* demand, double* pixels) const;
    void RaiseLevels(const DicingOptions& options, const SurfaceMove& move, const Screen& screen,
                     const Net& net, std::uint32_t most, MovedSamples* moved,
                     std::uint8_t* levels) const;
    bool IsBezier() const { return _shape == FaceShape::Quad && _surface.IsRegular(); }

    const SubdivModel& _model;
    int _face;
    FaceShape _shape;
    FaceSurface _surface;
    std::vector<glm::dvec3> _net; ///< of a regular quad: Bezier points [v][u]
};

} // namespace hds
