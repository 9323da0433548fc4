// SPDX-License-Identifier: Apache-2.0
#include "hdStream/geometry/polygon.h"

#include <glm/common.hpp>
#include <glm/geometric.hpp>

#include <algorithm>
#include <cmath>

namespace hds {
namespace {

/// After so many ears that were cut without a clean one left, the face is known to be self-crossing
/// and the search for clean ears, O(count) each time, is given up.
constexpr int kMaxRecoveries = 64;

/// Twice the signed area of a triangle in the plane, positive when counter-clockwise.
double Orient(const glm::dvec2& a, const glm::dvec2& b, const glm::dvec2& c) {
    return (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x);
}

/// Twice the face's vector area (Newell's method), relative to the first point for accuracy.
glm::dvec3 NewellNormal(const glm::dvec3* points, std::uint32_t count) {
    glm::dvec3 sum(0.0);
    for (std::uint32_t i = 1; i + 1 < count; ++i) {
        sum += glm::cross(points[i] - points[0], points[i + 1] - points[0]);
    }
    return sum;
}

} // namespace

std::uint32_t PolygonSplitter::Split(const glm::dvec3* points, std::uint32_t count,
                                     glm::uvec3* out) {
    _points = points;
    _count = count;
    if (count == 3) {
        return Emit(0, 1, 2, out) ? 1 : 0;
    }
    return count == 4 ? SplitQuad(out) : SplitLarge(out);
}

bool PolygonSplitter::Emit(std::uint32_t a, std::uint32_t b, std::uint32_t c,
                           glm::uvec3* out) const {
    if (IsDegenerate(_points[a], _points[b], _points[c])) {
        return false;
    }
    *out = glm::uvec3(a, b, c);
    return true;
}

std::uint32_t PolygonSplitter::SplitQuad(glm::uvec3* out) const {
    const glm::dvec3* p = _points;
    const glm::dvec3 diagonal02 = p[2] - p[0];
    const glm::dvec3 diagonal13 = p[3] - p[1];
    const glm::dvec3 normal = glm::cross(diagonal02, diagonal13);
    const auto isFront = [&](const glm::dvec3& n) {
        return glm::dot(n, normal) > 0.0 && glm::vec3(n) != glm::vec3(0.0F);
    };
    if (isFront(glm::cross(p[1] - p[0], diagonal02)) &&
        isFront(glm::cross(diagonal02, p[3] - p[0]))) {
        out[0] = glm::uvec3(0, 1, 2);
        out[1] = glm::uvec3(0, 2, 3);
        return 2;
    }
    if (isFront(glm::cross(p[1] - p[0], p[3] - p[0])) &&
        isFront(glm::cross(p[2] - p[1], diagonal13))) {
        out[0] = glm::uvec3(0, 1, 3);
        out[1] = glm::uvec3(1, 2, 3);
        return 2;
    }
    return EmitFan(out);
}

std::uint32_t PolygonSplitter::EmitFan(glm::uvec3* out) const {
    std::uint32_t numWritten = 0;
    for (std::uint32_t i = 1; i + 1 < _count; ++i) {
        numWritten += Emit(0, i, i + 1, out + numWritten) ? 1 : 0;
    }
    return numWritten;
}

std::uint32_t PolygonSplitter::SplitLarge(glm::uvec3* out) {
    const glm::dvec3 normal = NewellNormal(_points, _count);
    if (normal == glm::dvec3(0.0)) {
        return EmitFan(out); // collapsed, or crosses itself so that its areas cancel
    }
    Project(normal);
    // A fan is valid when the face is star-shaped about vertex 0 and no triangle is flat.
    bool isFan = true;
    for (std::uint32_t i = 1; isFan && i + 1 < _count; ++i) {
        isFan = Orient(_flat[0], _flat[i], _flat[i + 1]) > 0.0;
    }
    return isFan ? EmitFan(out) : ClipEars(out);
}

void PolygonSplitter::Project(const glm::dvec3& normal) {
    const glm::dvec3 size = glm::abs(normal);
    const int axis = size.x >= size.y && size.x >= size.z ? 0 : (size.y >= size.z ? 1 : 2);
    // Dropping the largest axis is exact; the two that are left are ordered counter-clockwise.
    int s = (axis + 1) % 3;
    int t = (axis + 2) % 3;
    if (normal[axis] < 0.0) {
        std::swap(s, t);
    }
    _flat.resize(_count);
    for (std::uint32_t i = 0; i < _count; ++i) {
        _flat[i] = glm::dvec2(_points[i][s], _points[i][t]);
    }
}

double PolygonSplitter::Turn(std::uint32_t vertex) const {
    return Orient(_flat[_prev[vertex]], _flat[vertex], _flat[_next[vertex]]);
}

void PolygonSplitter::BuildGrid() {
    glm::dvec2 low = _flat[0];
    glm::dvec2 high = _flat[0];
    std::vector<std::uint32_t> blockers;
    for (std::uint32_t i = 0; i < _count; ++i) {
        low = glm::min(low, _flat[i]);
        high = glm::max(high, _flat[i]);
        if (!(Turn(i) > 0.0)) {
            blockers.push_back(i);
        }
    }
    _gridSize = std::max(1, static_cast<int>(std::sqrt(static_cast<double>(blockers.size()))));
    _gridMin = low;
    const glm::dvec2 extent = high - low;
    _cellsPerUnit.x = extent.x > 0.0 ? _gridSize / extent.x : 0.0;
    _cellsPerUnit.y = extent.y > 0.0 ? _gridSize / extent.y : 0.0;
    // Counting sort of the blockers by cell.
    const auto cellOf = [&](std::uint32_t vertex) {
        const glm::dvec2 cell = (_flat[vertex] - _gridMin) * _cellsPerUnit;
        const int x = std::min(static_cast<int>(cell.x), _gridSize - 1);
        const int y = std::min(static_cast<int>(cell.y), _gridSize - 1);
        return static_cast<std::size_t>(y) * _gridSize + x;
    };
    _cellBegin.assign(static_cast<std::size_t>(_gridSize) * _gridSize + 1, 0);
    for (const std::uint32_t vertex : blockers) {
        ++_cellBegin[cellOf(vertex) + 1];
    }
    for (std::size_t cell = 1; cell < _cellBegin.size(); ++cell) {
        _cellBegin[cell] += _cellBegin[cell - 1];
    }
    _cellVertices.resize(blockers.size());
    std::vector<std::uint32_t> cursor(_cellBegin.begin(), _cellBegin.end() - 1);
    for (const std::uint32_t vertex : blockers) {
        _cellVertices[cursor[cellOf(vertex)]++] = vertex;
    }
}

bool PolygonSplitter::IsBlocker(std::uint32_t vertex, std::uint32_t a, std::uint32_t b,
                                std::uint32_t c) const {
    if (_prev[vertex] == vertex || vertex == a || vertex == b || vertex == c) {
        return false;
    }
    const glm::dvec2 p = _flat[vertex];
    const bool isInside = Orient(_flat[a], _flat[b], p) >= 0.0 &&
                          Orient(_flat[b], _flat[c], p) >= 0.0 &&
                          Orient(_flat[c], _flat[a], p) >= 0.0;
    // Vertices that repeat a corner (bridges to holes) do not block: a boundary that enters the ear
    // from there has another vertex inside it.
    return isInside && p != _flat[a] && p != _flat[b] && p != _flat[c] && !(Turn(vertex) > 0.0);
}

bool PolygonSplitter::IsBlocked(std::uint32_t a, std::uint32_t b, std::uint32_t c) const {
    const glm::dvec2 low = glm::min(glm::min(_flat[a], _flat[b]), _flat[c]);
    const glm::dvec2 high = glm::max(glm::max(_flat[a], _flat[b]), _flat[c]);
    const glm::dvec2 first = (low - _gridMin) * _cellsPerUnit;
    const glm::dvec2 last = (high - _gridMin) * _cellsPerUnit;
    const int lastX = std::min(static_cast<int>(last.x), _gridSize - 1);
    const int lastY = std::min(static_cast<int>(last.y), _gridSize - 1);
    const int firstX = std::min(static_cast<int>(first.x), _gridSize - 1);
    for (int y = std::min(static_cast<int>(first.y), _gridSize - 1); y <= lastY; ++y) {
        const std::size_t row = static_cast<std::size_t>(y) * _gridSize;
        // Cells of a row lie one after the other, and so do their vertices.
        for (std::uint32_t i = _cellBegin[row + firstX]; i < _cellBegin[row + lastX + 1]; ++i) {
            if (IsBlocker(_cellVertices[i], a, b, c)) {
                return true;
            }
        }
    }
    return false;
}

bool PolygonSplitter::IsEar(std::uint32_t vertex, EarRule rule) const {
    if (rule == EarRule::Any) {
        return true;
    }
    if (!(Turn(vertex) > 0.0)) {
        return false;
    }
    return rule == EarRule::Convex || !IsBlocked(_prev[vertex], vertex, _next[vertex]);
}

std::uint32_t PolygonSplitter::ClipEars(glm::uvec3* out) {
    _next.resize(_count);
    _prev.resize(_count);
    for (std::uint32_t i = 0; i < _count; ++i) {
        _next[i] = i + 1 < _count ? i + 1 : 0;
        _prev[i] = i > 0 ? i - 1 : _count - 1;
    }
    BuildGrid();

    std::uint32_t numWritten = 0;
    std::uint32_t numLeft = _count;
    std::uint32_t numMisses = 0;
    std::uint32_t vertex = 0;
    int numRecoveries = 0;
    EarRule rule = EarRule::Clean;
    while (numLeft > 3) {
        const std::uint32_t next = _next[vertex];
        if (!IsEar(vertex, rule)) {
            vertex = next;
            if (++numMisses >= numLeft) {
                numMisses = 0;
                rule = rule == EarRule::Clean ? EarRule::Convex : EarRule::Any;
            }
            continue;
        }
        const std::uint32_t prev = _prev[vertex];
        numWritten += Emit(prev, vertex, next, out + numWritten) ? 1 : 0;
        _next[prev] = next;
        _prev[next] = prev;
        _prev[vertex] = vertex;
        --numLeft;
        numMisses = 0;
        if (rule != EarRule::Clean && ++numRecoveries <= kMaxRecoveries) {
            rule = EarRule::Clean;
        }
        // Skipping a vertex spreads the cuts around the face, which avoids slivers.
        vertex = _next[next];
    }
    return numWritten + (Emit(_prev[vertex], vertex, _next[vertex], out + numWritten) ? 1 : 0);
}

} // namespace hds
