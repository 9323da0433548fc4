// SPDX-License-Identifier: Apache-2.0
// What an edge asks of its dicing: bend, turn and length of a surface in front of a camera.
// Internal to geometry. Explained in docs/geometry.md.
#pragma once

#include "hdStream/geometry/dicing.h"

#include <glm/vec3.hpp>

#include <cstddef>
#include <cstdint>
#include <vector>

namespace hds {

/// A view's projection.
class Screen {
public:
    explicit Screen(const DicingView& view);

    glm::dvec3 ToCamera(const glm::dvec3& point) const;
    /// Pixels of a unit length at the nearest of some points in camera space, seen from the front.
    double PixelsPerUnit(const glm::dvec3* points, std::size_t count, std::size_t stride) const;
    /// True when all points (camera space) lie beyond one side of the image.
    bool IsOutside(const std::vector<glm::dvec3>& points) const;

private:
    const DicingView& _view;
    double _pixels; ///< of a unit length at distance 1
};

/// Of a curve of unit parameter length, if it is drawn as one segment.
struct EdgeDemand {
    double error = 0.0; ///< distance from the chord
    double turn = 0.0;  ///< radians
    double length = 0.0;
    void Add(const EdgeDemand& other);
};

/// Of the lines along both parameters of a face.
struct GridDemand {
    EdgeDemand u;
    EdgeDemand v;
};

/// \param net [n][n] points: samples, or control points of a polynomial patch.
/// \param first, second what makes derivatives of first and second differences.
GridDemand MeasureGrid(const glm::dvec3* net, std::size_t n, double first, double second);

/// \param net rows of 5, 4, 3, 2 and 1 samples.
EdgeDemand MeasureTriangle(const glm::dvec3* net);

/// Level of an edge whose segments are within the bounds. \param pixels of a unit length.
/// \param bump how much displacement varies.
std::uint8_t LevelOf(const EdgeDemand& demand, double pixels, double bump,
                     const DicingOptions& options);

} // namespace hds
