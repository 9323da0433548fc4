// SPDX-License-Identifier: Apache-2.0
#include "hdStream/geometry/edgeDemand.h"

#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <glm/matrix.hpp>

#include <algorithm>
#include <cmath>

namespace hds {
namespace {

constexpr double kRadians = 3.14159265358979323846 / 180.0;
/// Turns matter on segments of more pixels than this.
constexpr double kTurnPixels = 1.0;

/// Points on a line of constant parameter.
struct Line {
    const glm::dvec3* points;
    std::size_t count;
    std::size_t stride;
    const glm::dvec3& operator[](std::size_t i) const { return points[i * stride]; }
};

/// Turn and length, and the largest second difference.
/// \param first, second what makes derivatives of first and second differences.
double MeasureShape(const Line& line, double first, double second, EdgeDemand& demand) {
    const glm::dvec3 whole = line[line.count - 1] - line[0];
    const double square = glm::dot(whole, whole);
    double shortest = 1e300;
    double across = 0.0;
    double largest = 0.0;
    for (std::size_t i = 0; i + 1 < line.count; ++i) {
        const double length = glm::length(line[i + 1] - line[i]);
        demand.length += length;
        shortest = std::min(shortest, length);
        if (i > 0) {
            const glm::dvec3 bend = line[i + 1] - 2.0 * line[i] + line[i - 1];
            largest = std::max(largest, glm::length(bend));
            const double along = square > 0.0 ? glm::dot(bend, whole) / square : 0.0;
            across = std::max(across, glm::length(bend - along * whole));
        }
    }
    demand.length *= first / double(line.count - 1);
    demand.turn = shortest > 0.0 ? second * across / (first * shortest) : 0.0;
    return largest;
}

/// The distance of a curve from its chord is at most an eighth of its second derivative.
EdgeDemand MeasureCubic(const Line& line) {
    EdgeDemand demand;
    double error = MeasureShape(line, 3.0, 6.0, demand) * 6.0 / 8.0;
    for (double& e : demand.errors) {
        e = error;
        error /= 4.0;
    }
    return demand;
}

/// Distances of the samples from chords between some of them; beyond, as for a cubic between
/// neighbours. A line of half an edge has its levels one below. \param fullCells of the longest
/// line of the face, a power of two.
EdgeDemand MeasureSampled(const Line& line, std::size_t fullCells, bool isHalf) {
    EdgeDemand demand;
    const std::size_t numCells = line.count - 1;
    const double cells = double(fullCells) * (isHalf ? 2.0 : 1.0);
    double error = MeasureShape(line, cells, cells * cells, demand) / 8.0;
    std::size_t level = isHalf ? 1 : 0;
    for (std::size_t step = fullCells; step > 1 && level < demand.errors.size(); step /= 2) {
        for (std::size_t i = 0; i < numCells; ++i) {
            const std::size_t begin = i / step * step;
            // The last chord of a row of a triangle may be shorter.
            const std::size_t end = std::min(begin + step, numCells);
            const double t = double(i - begin) / double(end - begin);
            const glm::dvec3 chord = line[begin] + t * (line[end] - line[begin]);
            demand.errors[level] = std::max(demand.errors[level], glm::length(line[i] - chord));
        }
        ++level;
    }
    for (; level < demand.errors.size(); ++level) {
        demand.errors[level] = error;
        error /= 4.0;
    }
    if (isHalf) {
        demand.errors[0] = 4.0 * demand.errors[1];
    }
    return demand;
}

/// A twisted quad bends along its diagonal.
void AddTwist(const glm::dvec3* net, std::size_t n, double cells, GridDemand& demand) {
    double error =
        cells * glm::length(net[0] - net[n - 1] - net[n * (n - 1)] + net[n * n - 1]) / 4.0;
    for (std::size_t level = 0; level < demand.u.errors.size(); ++level) {
        demand.u.errors[level] = std::max(demand.u.errors[level], error);
        demand.v.errors[level] = std::max(demand.v.errors[level], error);
        error /= 4.0;
    }
}

} // namespace

Screen::Screen(const DicingView& view, std::size_t place)
    : _view(view),
      _cameraFromObject(place == 0 ? view.cameraFromObject : view.otherPlaces[place - 1]) {
    const glm::dvec2 size = view.windowMax - view.windowMin;
    _pixels = std::max(view.imageSize.x / size.x, view.imageSize.y / size.y);
    const glm::dvec2 far = glm::max(glm::abs(view.windowMin), glm::abs(view.windowMax));
    _leastCosine = view.isPanoramic ? 1.0 : 1.0 / std::sqrt(1.0 + glm::dot(far, far));
}

glm::dvec3 Screen::ToCamera(const glm::dvec3& point) const {
    return glm::dvec3(_cameraFromObject * glm::dvec4(point, 1.0));
}

double Screen::Stretch() const {
    // The square of the norm is the largest eigenvalue of M^T M, which no row's sum is below.
    const glm::dmat3 linear(_cameraFromObject);
    const glm::dmat3 squares = glm::transpose(linear) * linear;
    double largest = 0.0;
    for (int row = 0; row < 3; ++row) {
        const glm::dvec3 sizes = glm::abs(squares[row]); // it is symmetric
        largest = std::max(largest, sizes.x + sizes.y + sizes.z);
    }
    return std::sqrt(largest);
}

double Screen::Nearest(const glm::dvec3* points, std::size_t count, std::size_t stride) const {
    double nearest = 1e300;
    for (std::size_t i = 0; i < count && !_view.isOrthographic; ++i) {
        // Depth; what other instances, or a camera that turns, may bring on screen is not nearer
        // than its distance lets it be.
        const glm::dvec3& p = points[i * stride];
        const bool isByDepth = _view.isOnlyInstance && !_view.isPanoramic;
        nearest = std::min(nearest, isByDepth ? -p.z : glm::length(p) * _leastCosine);
    }
    return nearest;
}

double Screen::PixelsAt(double nearest) const {
    return _view.isOrthographic ? _pixels : _pixels / std::max(nearest, _view.nearClip);
}

std::uint32_t Screen::SidesBeyond(const std::vector<glm::dvec3>& points, double reach) const {
    if (_view.isPanoramic) {
        return 0;
    }
    // Borders are planes through the eye, unless orthographic.
    const auto along = [&](double border) {
        return _view.isOrthographic ? reach : reach * std::sqrt(1.0 + border * border);
    };
    const double left = along(_view.windowMin.x);
    const double right = along(_view.windowMax.x);
    const double bottom = along(_view.windowMin.y);
    const double top = along(_view.windowMax.y);
    std::uint32_t sides = 31;
    for (const glm::dvec3& p : points) {
        const double scale = _view.isOrthographic ? 1.0 : -p.z;
        const auto keepIf = [&](std::uint32_t side, bool isBeyond) {
            sides &= isBeyond ? ~0U : ~side;
        };
        keepIf(1, p.x < _view.windowMin.x * scale - left);
        keepIf(2, p.x > _view.windowMax.x * scale + right);
        keepIf(4, p.y < _view.windowMin.y * scale - bottom);
        keepIf(8, p.y > _view.windowMax.y * scale + top);
        keepIf(16, p.z > reach);
    }
    return sides;
}

void EdgeDemand::Add(const EdgeDemand& other) {
    for (std::size_t level = 0; level < errors.size(); ++level) {
        errors[level] = std::max(errors[level], other.errors[level]);
    }
    turn = std::max(turn, other.turn);
    length = std::max(length, other.length);
}

GridDemand MeasureBezier(const glm::dvec3* net) {
    GridDemand demand;
    for (std::size_t i = 0; i < 4; ++i) {
        demand.u.Add(MeasureCubic({net + 4 * i, 4, 1}));
        demand.v.Add(MeasureCubic({net + i, 4, 4}));
    }
    AddTwist(net, 4, 1.0, demand);
    return demand;
}

GridDemand MeasureSamples(const glm::dvec3* net, std::size_t n, bool isHalf) {
    GridDemand demand;
    for (std::size_t i = 0; i < n; ++i) {
        demand.u.Add(MeasureSampled({net + n * i, n, 1}, n - 1, isHalf));
        demand.v.Add(MeasureSampled({net + i, n, n}, n - 1, isHalf));
    }
    AddTwist(net, n, isHalf ? 4.0 : 1.0, demand);
    return demand;
}

EdgeDemand MeasureTriangle(const glm::dvec3* net, std::size_t n) {
    const auto at = [&](std::size_t x, std::size_t y) { return net[n * y - y * (y - 1) / 2 + x]; };
    EdgeDemand demand;
    std::vector<glm::dvec3> lines[3];
    for (std::size_t row = 0; row + 1 < n; ++row) {
        const std::size_t count = n - row;
        for (std::vector<glm::dvec3>& line : lines) {
            line.clear();
        }
        for (std::size_t i = 0; i < count; ++i) {
            lines[0].push_back(at(i, row));
            lines[1].push_back(at(row, i));
            lines[2].push_back(at(count - 1 - i, i));
        }
        for (const std::vector<glm::dvec3>& line : lines) {
            demand.Add(MeasureSampled({line.data(), count, 1}, n - 1, false));
        }
    }
    return demand;
}

EdgeDemand MeasureLine(const std::vector<glm::dvec3>& line, bool isHalf) {
    return MeasureSampled({line.data(), line.size(), 1}, line.size() - 1, isHalf);
}

std::uint8_t LevelOf(const EdgeDemand& demand, double pixels, double bump,
                     const DicingOptions& options, std::uint32_t most) {
    const double length = demand.length * pixels;
    const double turn = demand.turn / (options.maxTurnDegrees * kRadians);
    double rate = std::min(turn, length / kTurnPixels);
    rate = std::max(rate, length / options.maxEdgePixels);
    if (bump * pixels > options.maxErrorPixels) {
        rate = std::max(rate, length / options.maxBumpPixels);
    }
    const std::uint32_t bound = std::min(most, kMaxDicingLevel);
    std::uint32_t level = 0;
    // Not a number asks for nothing.
    while (level < bound &&
           (double(1U << level) < rate || demand.errors[level] * pixels > options.maxErrorPixels)) {
        ++level;
    }
    return static_cast<std::uint8_t>(level);
}

} // namespace hds
