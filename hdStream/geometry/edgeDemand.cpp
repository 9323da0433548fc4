// SPDX-License-Identifier: Apache-2.0
#include "hdStream/geometry/edgeDemand.h"

#include <glm/common.hpp>
#include <glm/geometric.hpp>

#include <algorithm>
#include <array>
#include <cmath>

namespace hds {
namespace {

constexpr double kRadians = 3.14159265358979323846 / 180.0;
/// Turns matter on segments of more pixels than this.
constexpr double kTurnPixels = 2.0;

/// Points on a line of constant parameter.
struct Line {
    const glm::dvec3* points;
    std::size_t count;
    std::size_t stride;
    double first;
    double second;
};

EdgeDemand Measure(const Line& line) {
    EdgeDemand demand;
    const auto at = [&](std::size_t i) { return line.points[i * line.stride]; };
    const glm::dvec3 whole = at(line.count - 1) - at(0);
    const double square = glm::dot(whole, whole);
    double shortest = 1e300;
    double across = 0.0;
    for (std::size_t i = 0; i + 1 < line.count; ++i) {
        const double length = glm::length(at(i + 1) - at(i));
        demand.length += length;
        shortest = std::min(shortest, length);
        if (i > 0) {
            const glm::dvec3 bend = at(i + 1) - 2.0 * at(i) + at(i - 1);
            demand.error = std::max(demand.error, glm::length(bend));
            const double along = square > 0.0 ? glm::dot(bend, whole) / square : 0.0;
            across = std::max(across, glm::length(bend - along * whole));
        }
    }
    // The distance of a curve from its chord is at most an eighth of its second derivative.
    demand.error *= line.second / 8.0;
    demand.turn = shortest > 0.0 ? line.second * across / (line.first * shortest) : 0.0;
    demand.length *= line.first / double(line.count - 1);
    return demand;
}

} // namespace

Screen::Screen(const DicingView& view) : _view(view) {
    const glm::dvec2 size = view.windowMax - view.windowMin;
    _pixels = std::max(view.imageSize.x / size.x, view.imageSize.y / size.y);
}

glm::dvec3 Screen::ToCamera(const glm::dvec3& point) const {
    return glm::dvec3(_view.cameraFromObject * glm::dvec4(point, 1.0));
}

double Screen::PixelsPerUnit(const glm::dvec3* points, std::size_t count,
                             std::size_t stride) const {
    if (_view.isOrthographic) {
        return _pixels;
    }
    double nearest = 1e300;
    for (std::size_t i = 0; i < count; ++i) {
        nearest = std::min(nearest, -points[i * stride].z);
    }
    return _pixels / std::max(nearest, _view.nearClip);
}

bool Screen::IsOutside(const std::vector<glm::dvec3>& points) const {
    bool isBeyond[5] = {true, true, true, true, true};
    for (const glm::dvec3& p : points) {
        const double scale = _view.isOrthographic ? 1.0 : -p.z;
        isBeyond[0] = isBeyond[0] && p.x < _view.windowMin.x * scale;
        isBeyond[1] = isBeyond[1] && p.x > _view.windowMax.x * scale;
        isBeyond[2] = isBeyond[2] && p.y < _view.windowMin.y * scale;
        isBeyond[3] = isBeyond[3] && p.y > _view.windowMax.y * scale;
        isBeyond[4] = isBeyond[4] && p.z > 0.0;
    }
    return std::any_of(isBeyond, isBeyond + 5, [](bool beyond) { return beyond; });
}

void EdgeDemand::Add(const EdgeDemand& other) {
    error = std::max(error, other.error);
    turn = std::max(turn, other.turn);
    length = std::max(length, other.length);
}

GridDemand MeasureGrid(const glm::dvec3* net, std::size_t n, double first, double second) {
    GridDemand demand;
    for (std::size_t i = 0; i < n; ++i) {
        demand.u.Add(Measure({net + n * i, n, 1, first, second}));
        demand.v.Add(Measure({net + i, n, n, first, second}));
    }
    // A twisted quad bends along its diagonal.
    const double cells = first * first / double((n - 1) * (n - 1));
    const double twist =
        glm::length(net[0] - net[n - 1] - net[n * (n - 1)] + net[n * n - 1]) * cells / 4.0;
    demand.u.error = std::max(demand.u.error, twist);
    demand.v.error = std::max(demand.v.error, twist);
    return demand;
}

EdgeDemand MeasureTriangle(const glm::dvec3* net) {
    const auto index = [](std::size_t x, std::size_t y) { return 5 * y - y * (y - 1) / 2 + x; };
    EdgeDemand demand;
    std::array<glm::dvec3, 5> line;
    const auto add = [&](std::size_t count) {
        if (count > 1) {
            // `whole` of a short line is its own: lengths are per parameter, so none is too long.
            demand.Add(Measure({line.data(), count, 1, 4.0, 16.0}));
        }
    };
    for (std::size_t row = 0; row < 4; ++row) {
        const std::size_t count = 5 - row;
        for (std::size_t i = 0; i < count; ++i) {
            line[i] = net[index(i, row)];
        }
        add(count);
        for (std::size_t i = 0; i < count; ++i) {
            line[i] = net[index(row, i)];
        }
        add(count);
        for (std::size_t i = 0; i < count; ++i) {
            line[i] = net[index(count - 1 - i, i)];
        }
        add(count);
    }
    return demand;
}

std::uint8_t LevelOf(const EdgeDemand& demand, double pixels, double bump,
                     const DicingOptions& options) {
    const double length = demand.length * pixels;
    const double turn = demand.turn / (options.maxTurnDegrees * kRadians);
    double rate = std::sqrt(demand.error * pixels / options.maxErrorPixels);
    rate = std::max(rate, std::min(turn, length / kTurnPixels));
    rate = std::max(rate, length / options.maxEdgePixels);
    if (bump * pixels > options.maxErrorPixels) {
        rate = std::max(rate, length / options.maxBumpPixels);
    }
    if (!(rate > 1.0)) { // also NaN
        return 0;
    }
    const double bound = std::min(options.level, kMaxDicingLevel);
    return static_cast<std::uint8_t>(std::min(std::ceil(std::log2(rate)), bound));
}

} // namespace hds
