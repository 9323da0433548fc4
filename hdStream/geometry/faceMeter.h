// SPDX-License-Identifier: Apache-2.0
// Measures a cage face's limit surface: a box that holds it and the levels its edges ask for.
// Internal to geometry. Explained in docs/geometry.md.
#pragma once

#include "hdStream/geometry/dicing.h"
#include "hdStream/geometry/faceSurface.h"

#include <cstdint>
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

    /// The level that each edge asks for. \param bump how much displacement varies over the face,
    /// object space. \param levels [edges of the face]
    void RequestLevels(const DicingOptions& options, double bump, std::uint8_t* levels) const;

private:
    bool IsBent() const;
    ExactBox HullBox() const;
    void AddSquare(const PatternBox& part, const PatternBox& square, int depth,
                   ExactBox& box) const;
    std::vector<glm::dvec3> SamplePoints(int n) const;
    bool IsBezier() const { return _shape == FaceShape::Quad && _surface.IsRegular(); }

    const SubdivModel& _model;
    int _face;
    FaceShape _shape;
    FaceSurface _surface;
    std::vector<glm::dvec3> _net; ///< of a regular quad: Bezier points [v][u]
};

} // namespace hds
