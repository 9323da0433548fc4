// SPDX-License-Identifier: Apache-2.0
#include "hdStream/geometry/curveSegments.h"

#include "kernels/shared/geometry.h"

#include <glm/geometric.hpp>
#include <glm/vec3.hpp>

#include <algorithm>
#include <cmath>

namespace hds {

CurveBasis::CurveBasis(const CurveForm& form, bool isRibbon, bool hasLinearWidths, PrimLog& log) {
    if (form.type != "linear" && form.type != "cubic") {
        log.Warn("unknown curve type \"" + form.type + "\", drawn as linear");
    }
    _primitives = HDS_PRIMITIVE_LINEAR;
    if (form.type == "cubic") {
        if (form.basis == "bspline") {
            _primitives = HDS_PRIMITIVE_BSPLINE;
        } else if (form.basis == "catmullRom" || form.basis == "centripetalCatmullRom") {
            _primitives = HDS_PRIMITIVE_CATMULL_ROM;
        } else {
            _primitives = HDS_PRIMITIVE_BEZIER;
            _step = 3;
        }
        if (_step == 3 && form.basis != "bezier") {
            log.Warn("unknown curve basis \"" + form.basis + "\", drawn as bezier");
        }
        if (form.basis == "centripetalCatmullRom") {
            log.Warn("basis centripetalCatmullRom is drawn as catmullRom");
        }
    }
    _isPeriodic = form.wrap == "periodic";
    _isSegmented = form.wrap == "segmented";
    // Bezier curves and straight ones end at their points anyhow.
    _isPinned = form.wrap == "pinned" && _step == 1 && _primitives != HDS_PRIMITIVE_LINEAR;
    if (!_isPeriodic && !_isSegmented && form.wrap != "pinned" && form.wrap != "nonperiodic") {
        log.Warn("unknown curve wrap \"" + form.wrap + "\", drawn as nonperiodic");
    }
    // Linear radii of a Bezier segment are Bezier points.
    const bool isSpline =
        _primitives == HDS_PRIMITIVE_BSPLINE || _primitives == HDS_PRIMITIVE_CATMULL_ROM;
    _primitives |= isRibbon ? HDS_PRIMITIVE_RIBBON : 0U;
    _primitives |= hasLinearWidths && isSpline ? HDS_PRIMITIVE_LINEAR_WIDTHS : 0U;
}

std::uint32_t CurveBasis::NumSegments(std::uint32_t numVertices, std::uint32_t* numUnused) const {
    *numUnused = 0;
    if (_step == 3) {
        const std::uint32_t used = _isPeriodic ? 0U : 1U;
        if (numVertices < 3 + used) {
            return 0;
        }
        *numUnused = (numVertices - used) % 3;
        return (numVertices - used) / 3;
    }
    const bool isLinear = (_primitives & HDS_PRIMITIVE_BASIS) == HDS_PRIMITIVE_LINEAR;
    if (_isPeriodic) {
        return numVertices >= 3 ? numVertices : 0;
    }
    const std::uint32_t fewer = isLinear || _isPinned ? 1U : 3U;
    return numVertices > fewer ? numVertices - fewer : 0;
}

std::vector<std::uint32_t> CurveBasis::VerticesWithTail(std::uint32_t first,
                                                        std::uint32_t next) const {
    switch (_primitives & HDS_PRIMITIVE_BASIS) {
    case HDS_PRIMITIVE_LINEAR: // its last vertex is its neighbour's
        return {first, first + 1, first + 2, next + 2};
    case HDS_PRIMITIVE_BEZIER:
        return {first, first + 1, first + 2, first + 3, next + 1, next + 2, next + 3};
    default:
        return {first, first + 1, first + 2, first + 3, next + 3};
    }
}

RunVertex CurveBasis::VertexOf(std::uint32_t run, std::uint32_t numVertices) const {
    const bool isLinear = (_primitives & HDS_PRIMITIVE_BASIS) == HDS_PRIMITIVE_LINEAR;
    if (!isLinear && !_isPinned) {
        // A closed Bezier curve returns to its first vertex from the last one that is used.
        const std::uint32_t numUnused = _isPeriodic ? numVertices % _step : 0U;
        return {run % (numVertices - numUnused), 0, false};
    }
    if (_isPeriodic) {
        return {(run + numVertices - 1) % numVertices, 0, false};
    }
    if (run > 0 && run <= numVertices) {
        return {run - 1, 0, false};
    }
    const std::uint32_t last = numVertices - 1;
    return run == 0 ? RunVertex{0, 1, _isPinned} : RunVertex{last, last - 1, _isPinned};
}

std::uint32_t CurveBasis::JointOf(std::uint32_t run, std::uint32_t numSegments) const {
    const std::uint32_t joint = _step == 3 ? run / 3 : std::max(run, 1U) - 1;
    return _isPeriodic ? joint % numSegments : std::min(joint, numSegments);
}

std::array<double, 4> CurveBasis::JointWeights(int joint) const {
    const bool isSpline = (_primitives & HDS_PRIMITIVE_BASIS) == HDS_PRIMITIVE_BSPLINE;
    if (isSpline) {
        return joint == 0 ? std::array{1.0 / 6.0, 4.0 / 6.0, 1.0 / 6.0, 0.0}
                          : std::array{0.0, 1.0 / 6.0, 4.0 / 6.0, 1.0 / 6.0};
    }
    std::array<double, 4> weights{};
    weights[static_cast<std::size_t>(Joints()[joint])] = 1.0;
    return weights;
}

std::array<glm::dvec4, 4> CurveBasis::Bezier(const std::array<glm::dvec4, 4>& v) const {
    std::array<glm::dvec4, 4> result;
    switch (_primitives & HDS_PRIMITIVE_BASIS) {
    case HDS_PRIMITIVE_BEZIER:
        result = v;
        break;
    case HDS_PRIMITIVE_BSPLINE:
        result = {(v[0] + 4.0 * v[1] + v[2]) / 6.0, (2.0 * v[1] + v[2]) / 3.0,
                  (v[1] + 2.0 * v[2]) / 3.0, (v[1] + 4.0 * v[2] + v[3]) / 6.0};
        break;
    case HDS_PRIMITIVE_CATMULL_ROM:
        result = {v[1], v[1] + (v[2] - v[0]) / 6.0, v[2] - (v[3] - v[1]) / 6.0, v[2]};
        break;
    default:
        result = {v[1], (2.0 * v[1] + v[2]) / 3.0, (v[1] + 2.0 * v[2]) / 3.0, v[2]};
        break;
    }
    if ((_primitives & HDS_PRIMITIVE_LINEAR_WIDTHS) != 0) {
        for (int k = 0; k < 4; ++k) {
            result[k].w = (v[1].w * (3 - k) + v[2].w * k) / 3.0;
        }
    }
    return result;
}

namespace {

/// The blossom of a cubic: its value where all arguments are equal.
glm::dvec4 Blossom(const std::array<glm::dvec4, 4>& points, double a, double b, double c) {
    std::array<glm::dvec4, 4> left = points;
    const double arguments[] = {a, b, c};
    for (int level = 0; level < 3; ++level) {
        for (int i = 0; i < 3 - level; ++i) {
            left[i] = left[i] * (1.0 - arguments[level]) + left[i + 1] * arguments[level];
        }
    }
    return left[0];
}

} // namespace

std::array<glm::dvec4, 4> PartOfBezier(const std::array<glm::dvec4, 4>& points, double begin,
                                       double end) {
    return {Blossom(points, begin, begin, begin), Blossom(points, begin, begin, end),
            Blossom(points, begin, end, end), Blossom(points, end, end, end)};
}

double TurnOfBezier(const std::array<glm::dvec4, 4>& points) {
    double turn = 0.0;
    glm::dvec3 before(0.0);
    for (int i = 0; i < 3; ++i) {
        const glm::dvec3 leg = glm::dvec3(points[i + 1] - points[i]);
        const double lengths = glm::length(leg) * glm::length(before);
        if (lengths > 0.0) {
            turn += std::acos(std::clamp(glm::dot(leg, before) / lengths, -1.0, 1.0));
        }
        if (glm::length(leg) > 0.0) {
            before = leg;
        }
    }
    return turn;
}

} // namespace hds
