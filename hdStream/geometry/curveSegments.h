// SPDX-License-Identifier: Apache-2.0
// The segments of basis curves: which points each is made of, and its shape as Bezier points.
// Internal to geometry. Explained in docs/curves.md.
#pragma once

#include "hdStream/geometry/meshContent.h"

#include <glm/vec4.hpp>

#include <array>
#include <cstdint>
#include <vector>

namespace hds {

/// A vertex of a run: a point, or one beyond the end of a pinned curve: 2 point - next.
struct RunVertex {
    std::uint32_t point = 0; ///< place in the curve, 0 to count - 1
    std::uint32_t next = 0;
    bool isPhantom = false;
};

/// How vertices follow each other along a curve: a segment has four of the curve's *run*, which
/// repeats points of a periodic curve and adds points where a curve ends.
class CurveBasis {
public:
    CurveBasis(const CurveForm& form, bool isRibbon, bool hasLinearWidths, PrimLog& log);

    /// HDS_PRIMITIVE_* of kernels/shared/geometry.h.
    std::uint32_t Primitives() const { return _primitives; }
    bool IsPeriodic() const { return _isPeriodic; }
    bool IsSegmented() const { return _isSegmented; }
    /// Runs have vertices that are no points.
    bool HasPhantoms() const { return _isPinned; }
    /// Of a curve of so many vertices. \param[out] numUnused vertices after the last segment.
    std::uint32_t NumSegments(std::uint32_t numVertices, std::uint32_t* numUnused) const;
    /// Values of varying primvars of a curve.
    std::uint32_t NumJoints(std::uint32_t numSegments) const {
        return numSegments + (_isPeriodic ? 0 : 1);
    }
    /// The first vertex of a segment in the run.
    std::uint32_t FirstVertex(std::uint32_t segment) const { return segment * _step; }
    /// Vertices that a row of segments has, those that its neighbours are known by included.
    std::uint32_t NumVertices(std::uint32_t numSegments, bool isLast) const {
        return (numSegments - 1) * _step + 4 + (_step == 3 && !isLast ? 1 : 0);
    }
    /// How far behind a segment's first vertex lies the last of those that tell how the curve goes
    /// on where it stands still at the segment's end.
    std::uint32_t TailVertex() const { return _step == 3 ? 6 : 4; }
    /// All these of a segment where `next` is the next one, in their order; both by their first
    /// vertices.
    std::vector<std::uint32_t> VerticesWithTail(std::uint32_t first, std::uint32_t next) const;
    /// \param numVertices of the curve.
    RunVertex VertexOf(std::uint32_t run, std::uint32_t numVertices) const;
    /// The joint that varying values of a vertex of the run belong to.
    std::uint32_t JointOf(std::uint32_t run, std::uint32_t numSegments) const;
    /// The joints of a segment as vertices, counted from its first.
    std::array<int, 2> Joints() const { return _step == 3 ? std::array{0, 3} : std::array{1, 2}; }
    /// The weights of a segment's vertices at a joint (0: the first).
    std::array<double, 4> JointWeights(int joint) const;
    /// Bezier points of a segment with the radius as fourth coordinate.
    std::array<glm::dvec4, 4> Bezier(const std::array<glm::dvec4, 4>& vertices) const;

private:
    std::uint32_t _primitives;
    std::uint32_t _step = 1; ///< from segment to segment
    bool _isPeriodic = false;
    bool _isPinned = false;
    bool _isSegmented = false;
};

/// The part [begin, end] of a cubic as Bezier points of its own.
std::array<glm::dvec4, 4> PartOfBezier(const std::array<glm::dvec4, 4>& points, double begin,
                                       double end);

/// How much a cubic turns along its way, in radians: not less.
double TurnOfBezier(const std::array<glm::dvec4, 4>& points);

} // namespace hds
