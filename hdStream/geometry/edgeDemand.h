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

/// A view's projection of an object in one of its places.
class Screen {
public:
    /// \param place 0: cameraFromObject, 1 + i: otherPlaces[i].
    Screen(const DicingView& view, std::size_t place);

    glm::dvec3 ToCamera(const glm::dvec3& point) const;
    /// By how much the place stretches lengths, at most.
    double Stretch() const;
    /// How near some points (camera space) come, as depth where that counts.
    double Nearest(const glm::dvec3* points, std::size_t count, std::size_t stride) const;
    /// Pixels of a unit length that is so near, seen from the front.
    double PixelsAt(double nearest) const;
    /// The sides of the image, as bits, that all points (camera space) lie beyond, with all that is
    /// within `reach` of them.
    std::uint32_t SidesBeyond(const std::vector<glm::dvec3>& points, double reach) const;

private:
    const DicingView& _view;
    const glm::dmat4& _cameraFromObject;
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
/// \param bump how much displacement varies. \param most level.
std::uint8_t LevelOf(const EdgeDemand& demand, double pixels, double bump,
                     const DicingOptions& options, std::uint32_t most);

} // namespace hds
