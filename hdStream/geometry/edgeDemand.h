// SPDX-License-Identifier: Apache-2.0
// What an edge asks of its dicing: bend, turn and length of a surface in front of a camera.
// Internal to geometry. Explained in docs/geometry.md.
#pragma once

#include "hdStream/geometry/dicing.h"

#include <glm/vec3.hpp>

#include <array>
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
    double _pixels;            ///< of a unit length at distance 1
    double _leastCosine = 1.0; ///< of the angle between the view and a corner of the image
};

/// What the curves along an edge ask for.
struct EdgeDemand {
    /// Distance of the curve from 2^level chords.
    std::array<double, kMaxDicingLevel + 1> errors{};
    double turn = 0.0; ///< radians per unit parameter, where it is largest
    double length = 0.0;
    void Add(const EdgeDemand& other);
};

/// Of the lines along both parameters of a face.
struct GridDemand {
    EdgeDemand u;
    EdgeDemand v;
};

/// \param net [4][4] Bezier points of a whole face.
GridDemand MeasureBezier(const glm::dvec3* net);

/// \param net [n][n] samples, n - 1 a power of two. \param isHalf they cover half of each edge.
GridDemand MeasureSamples(const glm::dvec3* net, std::size_t n, bool isHalf);

/// \param net rows of n, n - 1, ... 1 samples, n - 1 a power of two.
EdgeDemand MeasureTriangle(const glm::dvec3* net, std::size_t n);

/// \param line points from end to end of a face, one more than a power of two. \param isHalf the
/// line is half as long as an edge.
EdgeDemand MeasureLine(const std::vector<glm::dvec3>& line, bool isHalf);

/// Level of an edge whose segments are within the bounds. \param pixels of a unit length.
/// \param bump how much displacement varies.
std::uint8_t LevelOf(const EdgeDemand& demand, double pixels, double bump,
                     const DicingOptions& options);

} // namespace hds
