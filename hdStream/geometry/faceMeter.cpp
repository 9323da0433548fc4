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
/// Of a moved face, a side: how long and how near it is, before lines are taken.
constexpr int kMovedSamples = 3;
/// Displacement that reaches farther than this part of the distance from the eye is sampled for how
/// near it comes.
constexpr double kNearPart = 1.0 / 8.0;

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

/// Samples per grid [v][u] or, of a triangle, row by row.
std::vector<glm::dvec3> FaceMeter::SamplePoints(int n, const PositionAt& positionAt) const {
    std::vector<glm::dvec3> points;
    const std::uint32_t numGrids =
        _shape == FaceShape::SubQuads ? std::uint32_t(_model.Cage().counts[_face]) : 1;
    for (std::uint32_t grid = 0; grid < numGrids; ++grid) {
        for (int y = 0; y < n; ++y) {
            for (int x = 0; x < (_shape == FaceShape::Triangle ? n - y : n); ++x) {
                points.push_back(positionAt({int(grid), glm::dvec2(x, y) / double(n - 1)}));
            }
        }
    }
    return points;
}

FaceMeter::Net FaceMeter::MakeNet(const SurfaceMove& move) const {
    const bool isMoved = move.IsEven() && move.range.low != 0.0;
    if (IsBezier() && !isMoved) {
        return {_net, 4, true};
    }
    const int numCells = (IsBent() ? 16 : 4) / (_shape == FaceShape::SubQuads ? 2 : 1);
    const auto positionAt = [&](const FacePoint& at) {
        if (!isMoved) {
            return _surface.Point(at);
        }
        const SurfaceFrame frame = _surface.Frame(at);
        return frame.point + move.range.low * _surface.Normal(at, frame);
    };
    return {SamplePoints(numCells + 1, positionAt), std::size_t(numCells) + 1, false};
}

/// \param points camera space. Both parameters have the demand of all, unless the face is a quad.
GridDemand FaceMeter::Measure(const std::vector<glm::dvec3>& points, std::size_t n,
                              bool isBezier) const {
    if (_shape == FaceShape::Quad) {
        return isBezier ? MeasureBezier(points.data()) : MeasureSamples(points.data(), n, false);
    }
    EdgeDemand all;
    if (_shape == FaceShape::Triangle) {
        all = MeasureTriangle(points.data(), n);
    }
    for (std::size_t begin = 0; _shape == FaceShape::SubQuads && begin < points.size();
         begin += n * n) {
        const GridDemand demand = MeasureSamples(points.data() + begin, n, true);
        all.Add(demand.u);
        all.Add(demand.v);
    }
    return {all, all};
}

/// Some lines of the moved surface; of a triangle its medians, for both parameters.
/// \param numCells of a line along a whole edge, at least.
void FaceMeter::TakeLines(const SurfaceMove& move, std::size_t numCells,
                          MovedSamples* moved) const {
    const bool isHalf = _shape == FaceShape::SubQuads;
    const std::size_t cells = isHalf ? std::max<std::size_t>(numCells / 2, 1) : numCells;
    if (!moved->lines.empty() && moved->lines.front().size() > cells) {
        return;
    }
    moved->lines.clear();
    const auto take = [&](int subFace, const glm::dvec2& from, const glm::dvec2& to) {
        std::vector<glm::dvec3>& line = moved->lines.emplace_back(cells + 1);
        for (std::size_t i = 0; i <= cells; ++i) {
            line[i] = move.positionAt({subFace, glm::mix(from, to, double(i) / double(cells))});
        }
    };
    if (_shape == FaceShape::Triangle) {
        take(0, {0.0, 0.0}, {0.5, 0.5});
        take(0, {1.0, 0.0}, {0.0, 0.5});
        take(0, {0.0, 1.0}, {0.5, 0.0});
        return;
    }
    const int numGrids = isHalf ? _model.Cage().counts[_face] : 1;
    for (int grid = 0; grid < numGrids; ++grid) {
        for (const double at : kMovedLines) {
            take(grid, {0.0, at}, {1.0, at});
            take(grid, {at, 0.0}, {at, 1.0});
        }
    }
}

/// What lines of the moved surface ask for. \param isNear displacement may bring it much nearer to
/// the eye. \param most level. \param pixels of a unit length: at first as near as it may be, then,
/// if `isNear`, as near as samples are.
void FaceMeter::AddMoved(const SurfaceMove& move, const Screen& screen, bool isNear,
                         std::uint32_t most, MovedSamples* moved, GridDemand* demand,
                         double* pixels) const {
    const double longest = std::max(demand->u.length, demand->v.length);
    const double turn = std::max(demand->u.turn, demand->v.turn);
    const double reach = move.Reach() * screen.Stretch();
    if ((longest + (turn + 2.0) * reach) * *pixels <= 1.0) {
        return; // below a pixel, wherever it is moved to
    }
    if (moved->grid.empty()) {
        moved->grid = SamplePoints(kMovedSamples, move.positionAt);
    }
    const auto toCamera = [&](std::vector<glm::dvec3> points) {
        std::transform(points.begin(), points.end(), points.begin(),
                       [&](const glm::dvec3& point) { return screen.ToCamera(point); });
        return points;
    };
    const auto nearestOf = [&](const std::vector<glm::dvec3>& points) {
        return screen.Nearest(points.data(), points.size(), 1);
    };
    const std::vector<glm::dvec3> grid = toCamera(moved->grid);
    const GridDemand ofGrid = Measure(grid, kMovedSamples, false);
    double nearest = nearestOf(grid);
    if (isNear) {
        *pixels = screen.PixelsAt(nearest);
    }
    const std::size_t numCells =
        CellsOf(std::max({longest, ofGrid.u.length, ofGrid.v.length}) * *pixels, most);
    if (numCells < 2) {
        return;
    }
    TakeLines(move, numCells, moved);
    for (std::size_t i = 0; i < moved->lines.size(); ++i) {
        const std::vector<glm::dvec3> line = toCamera(moved->lines[i]);
        nearest = std::min(nearest, nearestOf(line));
        const EdgeDemand ofLine = MeasureLine(line, _shape == FaceShape::SubQuads);
        if (i % 2 == 0 || _shape == FaceShape::Triangle) {
            demand->u.Add(ofLine);
        } else {
            demand->v.Add(ofLine);
        }
    }
    if (isNear) {
        *pixels = screen.PixelsAt(nearest);
    }
}

/// Raises the levels to what one place asks for. \param most level.
void FaceMeter::RaiseLevels(const DicingOptions& options, const SurfaceMove& move,
                            const Screen& screen, const Net& net, std::uint32_t most,
                            MovedSamples* moved, std::uint8_t* levels) const {
    std::vector<glm::dvec3> points = net.points;
    for (glm::dvec3& point : points) {
        point = screen.ToCamera(point);
    }
    const double reach = move.IsEven() ? 0.0 : move.Reach() * screen.Stretch();
    const double bump = move.IsEven() ? 0.0 : (move.range.high - move.range.low) * screen.Stretch();
    const double nearest = screen.Nearest(points.data(), points.size(), 1);
    const bool isNear = move.positionAt && reach > kNearPart * nearest;
    double pixels = screen.PixelsAt(nearest - reach);
    GridDemand demand = Measure(points, net.n, net.isBezier);
    if (move.positionAt) {
        AddMoved(move, screen, isNear, most, moved, &demand, &pixels);
    }
    const auto raise = [](std::uint8_t level, std::uint8_t* to) { *to = std::max(*to, level); };
    if (_shape != FaceShape::Quad) {
        demand.u.Add(demand.v);
        const std::uint8_t level = LevelOf(demand.u, pixels, bump, options, most);
        std::for_each(levels, levels + _model.Cage().counts[_face],
                      [&](std::uint8_t& edge) { raise(level, &edge); });
        return;
    }
    const std::size_t n = net.n;
    const std::size_t first[] = {0, n - 1, n * (n - 1), 0};
    const std::size_t stride[] = {1, n, 1, n};
    for (std::size_t edge = 0; edge < 4; ++edge) {
        const double own =
            isNear ? pixels
                   : screen.PixelsAt(screen.Nearest(points.data() + first[edge], n, stride[edge]) -
                                     reach);
        raise(LevelOf(edge % 2 == 0 ? demand.u : demand.v, own, bump, options, most),
              &levels[edge]);
    }
}

void FaceMeter::RequestLevels(const DicingOptions& options, const SurfaceMove& move,
                              std::uint8_t* levels) const {
    const Net net = MakeNet(move);
    const std::size_t numPlaces = 1 + options.view.otherPlaces.size();
    std::uint32_t sidesBeyond = options.view.isOnlyInstance ? ~0U : 0;
    for (std::size_t place = 0; place < numPlaces && sidesBeyond != 0; ++place) {
        const Screen screen(options.view, place);
        std::vector<glm::dvec3> points = net.points;
        for (glm::dvec3& point : points) {
            point = screen.ToCamera(point);
        }
        const double reach = move.IsEven() ? 0.0 : move.Reach() * screen.Stretch();
        sidesBeyond &= screen.SidesBeyond(points, reach);
    }
    const std::uint32_t most =
        sidesBeyond != 0 ? std::min(options.level, options.offScreenLevel) : options.level;
    std::fill(levels, levels + _model.Cage().counts[_face], std::uint8_t{0});
    MovedSamples moved;
    for (std::size_t place = 0; place < numPlaces; ++place) {
        RaiseLevels(options, move, Screen(options.view, place), net, most, &moved, levels);
    }
}

} // namespace hds
