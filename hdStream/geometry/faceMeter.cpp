// SPDX-License-Identifier: Apache-2.0
#include "hdStream/geometry/faceMeter.h"

#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <opensubdiv/sdc/crease.h>

#include <algorithm>
#include <array>

namespace hds {
namespace {

/// How much of its size a hull of cage points grows by: end caps of OpenSubdiv may leave the hull.
constexpr double kHullMargin = 1.0 / 64.0;
/// The same for Bezier points, which are computed from derivatives.
constexpr double kCubicMargin = 1e-6;
/// Lines of a face along one parameter that are measured where displacement varies: their other
/// parameter.
constexpr double kMovedLines[] = {1.0 / 6.0, 1.0 / 2.0, 5.0 / 6.0};

/// Control points of the cubic patch over a part of a quad, [v][u], by its corners' derivatives.
std::vector<glm::dvec3> BezierPoints(const FaceSurface& surface, const PatternBox& part) {
    std::vector<glm::dvec3> net(16);
    const glm::dvec2 third = (part.high - part.low) / 3.0;
    for (int y = 0; y < 2; ++y) {
        for (int x = 0; x < 2; ++x) {
            const glm::dvec2 at(x == 0 ? part.low.x : part.high.x,
                                y == 0 ? part.low.y : part.high.y);
            const SurfaceFrame2 f = surface.Frame2({0, at});
            const double u = x == 0 ? third.x : -third.x;
            const double v = y == 0 ? third.y : -third.y;
            const auto to = [&](int dx, int dy) -> glm::dvec3& {
                return net[std::size_t(4 * (y == 0 ? dy : 3 - dy) + (x == 0 ? dx : 3 - dx))];
            };
            to(0, 0) = f.point;
            to(1, 0) = f.point + u * f.tangentU;
            to(0, 1) = f.point + v * f.tangentV;
            to(1, 1) = f.point + u * f.tangentU + v * f.tangentV + u * v * f.uv;
        }
    }
    return net;
}

/// The blossom of a cubic (de Casteljau with a parameter of its own in each step).
glm::dvec3 Blossom(const glm::dvec3* points, std::size_t stride, double t0, double t1, double t2) {
    const auto mix = [](const glm::dvec3& a, const glm::dvec3& b, double t) {
        return a + t * (b - a);
    };
    const glm::dvec3 a = mix(points[0], points[stride], t0);
    const glm::dvec3 b = mix(points[stride], points[2 * stride], t0);
    const glm::dvec3 c = mix(points[2 * stride], points[3 * stride], t0);
    return mix(mix(a, b, t1), mix(b, c, t1), t2);
}

/// Control points of a part of a patch.
std::array<glm::dvec3, 16> Restrict(const std::vector<glm::dvec3>& net, const PatternBox& part) {
    std::array<glm::dvec3, 16> rows;
    std::array<glm::dvec3, 16> result;
    const auto at = [&](int axis, std::size_t i, std::size_t step) {
        return step < i ? part.high[axis] : part.low[axis];
    };
    for (std::size_t line = 0; line < 4; ++line) {
        for (std::size_t i = 0; i < 4; ++i) {
            rows[4 * line + i] =
                Blossom(net.data() + 4 * line, 1, at(0, i, 0), at(0, i, 1), at(0, i, 2));
        }
    }
    for (std::size_t line = 0; line < 4; ++line) {
        for (std::size_t i = 0; i < 4; ++i) {
            result[4 * i + line] =
                Blossom(rows.data() + line, 4, at(1, i, 0), at(1, i, 1), at(1, i, 2));
        }
    }
    return result;
}

/// A power of two, one for each of so many pixels, at most 2^level.
std::size_t CellsOf(double pixels, std::uint32_t level) {
    std::size_t count = 1;
    while (double(count) < pixels && count < (std::size_t{1} << level)) {
        count *= 2;
    }
    return count;
}

} // namespace

void ExactBox::Add(const glm::dvec3& point) {
    min = glm::min(min, point);
    max = glm::max(max, point);
}

FaceMeter::FaceMeter(const SubdivModel& model, int face)
    : _model(model), _face(face), _shape(model.Shape(face)), _surface(model, face) {
    if (IsBezier()) {
        _net = BezierPoints(_surface, {});
    }
}

void ExactBox::Add(const ExactBox& other) {
    min = glm::min(min, other.min);
    max = glm::max(max, other.max);
}

void ExactBox::Grow(double part) {
    const double pad = part * glm::length(max - min);
    min -= pad;
    max += pad;
}

/// Of the cage's points.
ExactBox FaceMeter::HullBox() const {
    ExactBox box;
    std::vector<int> points;
    _surface.ControlPoints(points);
    for (const int point : points) {
        const float* p = _model.Mesh().points.data() + 3 * std::size_t(point);
        box.Add(glm::dvec3(p[0], p[1], p[2]));
    }
    box.Grow(kHullMargin);
    return box;
}

/// Adds the part of a dyadic square of an irregular quad. Away from the quad's corners squares are
/// regular patches: Catmull and Clark 1978 have extraordinary points at vertices only.
void FaceMeter::AddSquare(const PatternBox& part, const PatternBox& square, int depth,
                          ExactBox& box) const {
    const PatternBox common{glm::max(part.low, square.low), glm::min(part.high, square.high)};
    if (common.low.x >= common.high.x || common.low.y >= common.high.y) {
        return;
    }
    const bool isAtCorner = (square.low.x == 0.0 || square.high.x == 1.0) &&
                            (square.low.y == 0.0 || square.high.y == 1.0);
    if (isAtCorner && depth < kSmoothLevel) {
        const glm::dvec2 half = 0.5 * (square.high - square.low);
        for (int child = 0; child < 4; ++child) {
            const glm::dvec2 low = square.low + half * glm::dvec2(child % 2, child / 2);
            AddSquare(part, {low, low + half}, depth + 1, box);
        }
        return;
    }
    ExactBox own;
    for (const glm::dvec3& point : BezierPoints(_surface, common)) {
        own.Add(point);
    }
    // What is left at a corner is not cubic: twice its size, of 1/64 of the face.
    own.Grow(isAtCorner ? 1.0 : kCubicMargin);
    box.Add(own);
}

ExactBox FaceMeter::Box() const {
    return IsBezier() ? BoxOver({}) : HullBox();
}

ExactBox FaceMeter::BoxOver(const PatternBox& part) const {
    ExactBox box;
    if (IsBezier()) {
        for (const glm::dvec3& point : Restrict(_net, part)) {
            box.Add(point);
        }
        box.Grow(kCubicMargin);
        return box;
    }
    if (_shape != FaceShape::Quad || IsBent()) {
        return HullBox();
    }
    AddSquare(part, {}, 0, box);
    return box;
}

/// True beside semi-sharp edges and corners, which bend the surface within 2^-sharpness of their
/// length.
bool FaceMeter::IsBent() const {
    const auto& level = _model.Level();
    const auto isSemiSharp = [](float sharpness) {
        return sharpness > 0.0F && sharpness < OpenSubdiv::Sdc::Crease::SHARPNESS_INFINITE;
    };
    const auto vertices = level.GetFaceVertices(_face);
    bool isBent = false;
    for (int i = 0; i < vertices.size(); ++i) {
        isBent = isBent || isSemiSharp(level.GetVertexSharpness(vertices[i]));
        const auto edges = level.GetVertexEdges(vertices[i]);
        for (int e = 0; e < edges.size(); ++e) {
            isBent = isBent || isSemiSharp(level.GetEdgeSharpness(edges[e]));
        }
    }
    return isBent;
}

/// Samples of a surface that is not one patch, per grid [v][u] or, of a triangle, row by row.
std::vector<glm::dvec3> FaceMeter::SamplePoints(int n) const {
    std::vector<glm::dvec3> points;
    const std::uint32_t numGrids =
        _shape == FaceShape::SubQuads ? std::uint32_t(_model.Cage().counts[_face]) : 1;
    for (std::uint32_t grid = 0; grid < numGrids; ++grid) {
        for (int y = 0; y < n; ++y) {
            for (int x = 0; x < (_shape == FaceShape::Triangle ? n - y : n); ++x) {
                points.push_back(_surface.Point({int(grid), glm::dvec2(x, y) / double(n - 1)}));
            }
        }
    }
    return points;
}

/// What some lines of the moved surface ask for; of a triangle its medians, for both parameters.
/// \param numCells samples along an edge.
void FaceMeter::AddMoved(const SurfaceMove& move, const Screen& screen, std::size_t numCells,
                         GridDemand* demand) const {
    if (!move.positionAt || numCells < 2) {
        return;
    }
    const bool isHalf = _shape == FaceShape::SubQuads;
    const std::size_t cells = isHalf ? std::max<std::size_t>(numCells / 2, 1) : numCells;
    std::vector<glm::dvec3> line(cells + 1);
    const auto measure = [&](int subFace, const glm::dvec2& from, const glm::dvec2& to) {
        for (std::size_t i = 0; i <= cells; ++i) {
            const glm::dvec2 uv = glm::mix(from, to, double(i) / double(cells));
            line[i] = screen.ToCamera(move.positionAt({subFace, uv}));
        }
        return MeasureLine(line, isHalf);
    };
    if (_shape == FaceShape::Triangle) {
        demand->u.Add(measure(0, {0.0, 0.0}, {0.5, 0.5}));
        demand->u.Add(measure(0, {1.0, 0.0}, {0.0, 0.5}));
        demand->u.Add(measure(0, {0.0, 1.0}, {0.5, 0.0}));
        return;
    }
    const int numGrids = isHalf ? _model.Cage().counts[_face] : 1;
    for (int grid = 0; grid < numGrids; ++grid) {
        for (const double at : kMovedLines) {
            demand->u.Add(measure(grid, {0.0, at}, {1.0, at}));
            demand->v.Add(measure(grid, {at, 0.0}, {at, 1.0}));
        }
    }
}

void FaceMeter::RequestLevels(const DicingOptions& options, const SurfaceMove& move,
                              std::uint8_t* levels) const {
    const auto numEdges = static_cast<std::uint32_t>(_model.Cage().counts[_face]);
    const Screen screen(options.view);
    const int numCells = (IsBent() ? 16 : 4) / (_shape == FaceShape::SubQuads ? 2 : 1);
    const int numSamples = IsBezier() ? 4 : numCells + 1;
    std::vector<glm::dvec3> points = IsBezier() ? _net : SamplePoints(numSamples);
    for (glm::dvec3& point : points) {
        point = screen.ToCamera(point);
    }
    DicingOptions limits = options;
    if (options.view.isOnlyInstance && screen.IsOutside(points)) {
        limits.level = std::min(options.level, options.offScreenLevel);
    }
    const auto n = std::size_t(numSamples);
    const double pixelsPerUnit = screen.PixelsPerUnit(points.data(), points.size(), 1);
    const auto addMoved = [&](GridDemand* demand) {
        const double length = std::max(demand->u.length, demand->v.length) * pixelsPerUnit;
        AddMoved(move, screen, CellsOf(length, limits.level), demand);
    };
    if (_shape == FaceShape::Quad) {
        GridDemand demand =
            IsBezier() ? MeasureBezier(points.data()) : MeasureSamples(points.data(), n, false);
        addMoved(&demand);
        const std::size_t first[] = {0, n - 1, n * (n - 1), 0};
        const std::size_t stride[] = {1, n, 1, n};
        for (std::uint32_t edge = 0; edge < 4; ++edge) {
            const double pixels =
                screen.PixelsPerUnit(points.data() + first[edge], n, stride[edge]);
            levels[edge] = LevelOf(edge % 2 == 0 ? demand.u : demand.v, pixels, move.range, limits);
        }
        return;
    }
    EdgeDemand all;
    if (_shape == FaceShape::Triangle) {
        all = MeasureTriangle(points.data(), n);
    } else {
        for (std::uint32_t grid = 0; grid < numEdges; ++grid) {
            const GridDemand demand = MeasureSamples(points.data() + n * n * grid, n, true);
            all.Add(demand.u);
            all.Add(demand.v);
        }
    }
    GridDemand both{all, all};
    addMoved(&both);
    both.u.Add(both.v);
    std::fill(levels, levels + numEdges, LevelOf(both.u, pixelsPerUnit, move.range, limits));
}

} // namespace hds
