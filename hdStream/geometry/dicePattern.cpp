// SPDX-License-Identifier: Apache-2.0
#include "hdStream/geometry/dicePattern.h"

#include <glm/common.hpp>

#include <algorithm>

namespace hds {

DicePattern::DicePattern(FaceShape shape, std::uint32_t numEdges, const std::uint8_t* levels)
    : _shape(shape), _numEdges(numEdges), _levels(levels) {
    _firstInside = numEdges;
    std::uint32_t highest = 1;
    _firstOnEdge.reserve(numEdges);
    for (std::uint32_t edge = 0; edge < numEdges; ++edge) {
        _firstOnEdge.push_back(_firstInside);
        _firstInside += Rate(edge) - 1;
        highest = std::max(highest, Rate(edge));
    }
    std::uint32_t numCells = 0;
    std::uint32_t numInside = 0;
    switch (shape) {
    case FaceShape::Quad:
        _rate = {std::max(Rate(0), Rate(2)), std::max(Rate(1), Rate(3))};
        numCells = _rate.x * _rate.y;
        numInside = (_rate.x - 1) * (_rate.y - 1);
        break;
    case FaceShape::Triangle:
        _rate = glm::uvec2(highest);
        numCells = highest * (highest + 1) / 2;
        numInside = highest < 3 ? 0 : (highest - 1) * (highest - 2) / 2;
        break;
    case FaceShape::SubQuads:
        _rate = glm::uvec2(std::max(1U, highest / 2));
        numCells = numEdges * _rate.x * _rate.x;
        // A triangle with nothing to join stays one triangle.
        numInside = numEdges == 3 && highest == 1 ? 0 : numEdges * _rate.x * (_rate.x - 1) + 1;
        break;
    }
    _numVertices = _firstInside + numInside;
    _isOneTile = numCells <= kTileCells * kTileCells;
    if (!_isOneTile) {
        _numTiles = (_rate + kTileCells - 1U) / kTileCells;
    }
}

std::uint32_t DicePattern::InnerRate(std::uint32_t edge) const {
    switch (_shape) {
    case FaceShape::Quad:
        return edge % 2 == 0 ? _rate.x : _rate.y;
    case FaceShape::Triangle:
        return _rate.x;
    case FaceShape::SubQuads:
        break;
    }
    return 2 * _rate.x;
}

std::uint32_t DicePattern::NumTiles() const {
    if (_isOneTile) {
        return 1;
    }
    if (_shape == FaceShape::Triangle) {
        return _numTiles.x * (_numTiles.x + 1) / 2;
    }
    return (_shape == FaceShape::SubQuads ? _numEdges : 1) * _numTiles.x * _numTiles.y;
}

std::uint32_t DicePattern::CountTriangles() const {
    std::uint32_t numOuter = 0;
    for (std::uint32_t edge = 0; edge < _numEdges; ++edge) {
        numOuter += Rate(edge);
    }
    const std::uint32_t rate = _rate.x;
    switch (_shape) {
    case FaceShape::Quad:
        if (rate == 1 || _rate.y == 1) {
            return rate == 1 ? Rate(1) + Rate(3) : Rate(0) + Rate(2);
        }
        // Strips have the segments of their edge and of the grid's side; then the grid's cells.
        return numOuter + 2 * (rate - 2) + 2 * (_rate.y - 2) + 2 * (rate - 2) * (_rate.y - 2);
    case FaceShape::Triangle:
        return rate < 4 ? numOuter - 2 : numOuter + 3 * (rate - 3) + (rate - 3) * (rate - 3);
    case FaceShape::SubQuads:
        break;
    }
    return _numVertices == 3
               ? 1
               : numOuter + _numEdges * (2 * rate - 2) + _numEdges * 2 * (rate - 1) * (rate - 1);
}

DicePattern::TileCells DicePattern::CellsOf(std::uint32_t tile) const {
    glm::uvec2 at(0);
    std::uint32_t subFace = 0;
    if (_shape == FaceShape::Triangle) {
        std::uint32_t row = _numTiles.x;
        for (; tile >= row; --row, ++at.y) {
            tile -= row;
        }
        at.x = tile;
    } else {
        const std::uint32_t numInSubFace = _numTiles.x * _numTiles.y;
        subFace = tile / numInSubFace;
        at = {tile % numInSubFace % _numTiles.x, tile % numInSubFace / _numTiles.x};
    }
    const glm::uvec2 low = at * kTileCells;
    return {subFace, low, glm::min(low + kTileCells, _rate)};
}

bool DicePattern::IsInTile(std::uint32_t tile, const Cell& cell) const {
    if (_isOneTile) {
        return true;
    }
    const TileCells cells = CellsOf(tile);
    return cell.subFace == cells.subFace && cell.x >= cells.low.x && cell.x < cells.high.x &&
           cell.y >= cells.low.y && cell.y < cells.high.y;
}

std::uint32_t DicePattern::TileTriangles(std::uint32_t tile) const {
    if (_isOneTile) {
        return CountTriangles();
    }
    const TileCells cells = CellsOf(tile);
    if (_shape != FaceShape::Triangle) {
        return 2 * (cells.high.x - cells.low.x) * (cells.high.y - cells.low.y);
    }
    std::uint32_t numCells = 0;
    for (std::uint32_t y = cells.low.y; y < cells.high.y; ++y) {
        const std::uint32_t end = std::min(cells.high.x, _rate.x - y);
        numCells += end > cells.low.x ? end - cells.low.x : 0;
    }
    return 2 * numCells;
}

PatternBox DicePattern::TileBox(std::uint32_t tile) const {
    PatternBox box;
    if (_isOneTile || _shape != FaceShape::Quad) {
        return box;
    }
    const TileCells cells = CellsOf(tile);
    for (int axis = 0; axis < 2; ++axis) {
        const double cell = 1.0 / double(_rate[axis]);
        box.low[axis] = double(cells.low[axis]) * cell;
        box.high[axis] = double(cells.high[axis]) * cell;
        // Strips to a coarser edge reach half a segment of it, and a cell, beyond their cells.
        if (cells.low[1 - axis] == 0 || cells.high[1 - axis] == _rate[1 - axis]) {
            const std::uint32_t coarser =
                std::min(Rate(std::uint32_t(axis)), Rate(std::uint32_t(axis) + 2));
            const double margin = 0.5 / double(coarser) + cell;
            box.low[axis] = std::max(0.0, box.low[axis] - margin);
            box.high[axis] = std::min(1.0, box.high[axis] + margin);
        }
    }
    return box;
}

void DicePattern::AddTile(std::uint32_t tile, std::vector<glm::uvec3>& triangles) const {
    if (_shape == FaceShape::Triangle && _rate.x < 4) {
        AddSmall(triangles);
    } else if (_shape == FaceShape::SubQuads && _numVertices == 3) {
        triangles.emplace_back(0, 1, 2);
    } else if (_shape == FaceShape::Quad && (_rate.x == 1 || _rate.y == 1)) {
        AddBand(tile, triangles);
    } else {
        if (_shape == FaceShape::SubQuads && !_isOneTile) { // two strips reach a sub-quad
            const std::uint32_t subFace = CellsOf(tile).subFace;
            AddStrip(tile, (subFace + _numEdges - 1) % _numEdges, triangles);
            AddStrip(tile, subFace, triangles);
        } else {
            for (std::uint32_t edge = 0; edge < _numEdges; ++edge) {
                AddStrip(tile, edge, triangles);
            }
        }
        AddInside(tile, triangles);
    }
}

/// A loop face whose edges have rates 1 and 2: no vertex lies inside.
void DicePattern::AddSmall(std::vector<glm::uvec3>& triangles) const {
    // The corners between two split edges are cut off; what is left is a fan.
    std::vector<std::uint32_t> left;
    for (std::uint32_t corner = 0; corner < 3; ++corner) {
        const std::uint32_t before = (corner + 2) % 3;
        if (Rate(corner) == 2 && Rate(before) == 2) {
            triangles.emplace_back(corner, OuterVertex(corner, 1), OuterVertex(before, 1));
        } else {
            left.push_back(corner);
        }
        if (Rate(corner) == 2) {
            left.push_back(OuterVertex(corner, 1));
        }
    }
    // With one split edge the fan must start at its middle: no triangle may be flat.
    const auto first = std::find_if(left.begin(), left.end(), [](auto v) { return v >= 3; });
    if (first != left.end()) {
        std::rotate(left.begin(), first, left.end());
    }
    for (std::size_t i = 1; i + 1 < left.size(); ++i) {
        triangles.emplace_back(left[0], left[i], left[i + 1]);
    }
}

/// A quad with one segment across: two opposite edges are joined.
void DicePattern::AddBand(std::uint32_t tile, std::vector<glm::uvec3>& triangles) const {
    const std::uint32_t edge = _rate.x == 1 ? 1 : 0;
    const std::uint32_t opposite = edge + 2;
    const std::uint32_t rate = InnerRate(edge);
    const std::uint32_t near = Rate(edge);
    const std::uint32_t far = Rate(opposite);
    std::uint32_t a = 0; // vertices of the near edge passed, and of the far edge from its end
    std::uint32_t b = 0;
    while (a < near || b < far) {
        const bool isNear = b == far || (a < near && (2 * a + 1) * far <= (2 * b + 1) * near);
        const std::uint32_t cell =
            isNear ? (2 * a + 1) * rate / (2 * near) : (2 * b + 1) * rate / (2 * far);
        if (IsInTile(tile, EdgeCell(edge, cell))) {
            const std::uint32_t p = OuterVertex(edge, a);
            const std::uint32_t q = OuterVertex(opposite, far - b);
            triangles.emplace_back(
                p, isNear ? OuterVertex(edge, a + 1) : OuterVertex(opposite, far - b - 1), q);
        }
        isNear ? ++a : ++b;
    }
}

/// The cells between an edge and the first row of the inside.
void DicePattern::AddStrip(std::uint32_t tile, std::uint32_t edge,
                           std::vector<glm::uvec3>& triangles) const {
    const std::uint32_t rate = Rate(edge);
    const std::uint32_t inner = InnerRate(edge);
    // Inner vertices 1 .. last lie at (k + shift / 2) / inner of the edge.
    const std::uint32_t shift = _shape == FaceShape::Triangle ? 1 : 0;
    const std::uint32_t last = inner - 1 - shift;
    std::uint32_t a = 0;
    std::uint32_t b = 1;
    while (a < rate || b < last) {
        const bool isOuter =
            b == last || (a < rate && (2 * a + 1) * inner <= (2 * b + 1 + shift) * rate);
        const std::uint32_t cell = isOuter ? (2 * a + 1) * inner / (2 * rate) : b;
        if (IsInTile(tile, EdgeCell(edge, cell))) {
            triangles.emplace_back(OuterVertex(edge, a),
                                   isOuter ? OuterVertex(edge, a + 1) : InnerVertex(edge, b + 1),
                                   InnerVertex(edge, b));
        }
        isOuter ? ++a : ++b;
    }
}

void DicePattern::AddInside(std::uint32_t tile, std::vector<glm::uvec3>& triangles) const {
    TileCells cells{0, glm::uvec2(0), _rate};
    std::uint32_t endSubFace = _shape == FaceShape::SubQuads ? _numEdges : 1;
    if (!_isOneTile) {
        cells = CellsOf(tile);
        endSubFace = cells.subFace + 1;
    }
    for (std::uint32_t subFace = cells.subFace; subFace < endSubFace; ++subFace) {
        const glm::uvec2 low = glm::max(cells.low, glm::uvec2(1));
        // Sub-quads have no strips along the lines to the centre.
        const std::uint32_t border = _shape == FaceShape::SubQuads ? 0 : 1;
        const glm::uvec2 high = glm::min(cells.high, _rate - border);
        for (std::uint32_t y = low.y; y < high.y; ++y) {
            for (std::uint32_t x = low.x; x < high.x; ++x) {
                const auto at = [&](std::uint32_t dx, std::uint32_t dy) {
                    return InsideVertex(subFace, x + dx, y + dy);
                };
                if (_shape != FaceShape::Triangle) {
                    triangles.emplace_back(at(0, 0), at(1, 0), at(1, 1));
                    triangles.emplace_back(at(0, 0), at(1, 1), at(0, 1));
                    continue;
                }
                if (x + y + 1 < _rate.x) {
                    triangles.emplace_back(at(0, 0), at(1, 0), at(0, 1));
                }
                if (x + y + 2 < _rate.x) {
                    triangles.emplace_back(at(1, 0), at(1, 1), at(0, 1));
                }
            }
        }
    }
}

/// The cell beside segment `cell` of an edge, in the inside's rate.
DicePattern::Cell DicePattern::EdgeCell(std::uint32_t edge, std::uint32_t cell) const {
    const std::uint32_t back = InnerRate(edge) - 1 - cell;
    if (_shape == FaceShape::SubQuads) {
        return cell < _rate.x ? Cell{edge, cell, 0} : Cell{(edge + 1) % _numEdges, 0, back};
    }
    if (_shape == FaceShape::Triangle) {
        return edge == 0 ? Cell{0, cell, 0} : edge == 1 ? Cell{0, back, cell} : Cell{0, 0, back};
    }
    switch (edge) {
    case 0:
        return {0, cell, 0};
    case 1:
        return {0, _rate.x - 1, cell};
    case 2:
        return {0, back, _rate.y - 1};
    default:
        return {0, 0, back};
    }
}

/// Vertex `step` of 0 .. rate along an edge.
std::uint32_t DicePattern::OuterVertex(std::uint32_t edge, std::uint32_t step) const {
    if (step == 0 || step == Rate(edge)) {
        return step == 0 ? edge : (edge + 1) % _numEdges;
    }
    return _firstOnEdge[edge] + step - 1;
}

/// Vertex `step` of the row beside an edge; steps are those of the inside's rate.
std::uint32_t DicePattern::InnerVertex(std::uint32_t edge, std::uint32_t step) const {
    const std::uint32_t inner = InnerRate(edge);
    if (_shape == FaceShape::SubQuads) {
        return step <= _rate.x ? InsideVertex(edge, step, 1)
                               : InsideVertex((edge + 1) % _numEdges, 1, inner - step);
    }
    if (_shape == FaceShape::Triangle) {
        return edge == 0   ? InsideVertex(0, step, 1)
               : edge == 1 ? InsideVertex(0, inner - 1 - step, step)
                           : InsideVertex(0, 1, inner - 1 - step);
    }
    switch (edge) {
    case 0:
        return InsideVertex(0, step, 1);
    case 1:
        return InsideVertex(0, _rate.x - 1, step);
    case 2:
        return InsideVertex(0, inner - step, _rate.y - 1);
    default:
        return InsideVertex(0, 1, inner - step);
    }
}

/// Grid vertex (x, y) of a sub-face, from 1 on; in sub-quads up to the rate.
std::uint32_t DicePattern::InsideVertex(std::uint32_t subFace, std::uint32_t x,
                                        std::uint32_t y) const {
    const std::uint32_t rate = _rate.x;
    switch (_shape) {
    case FaceShape::Quad:
        return _firstInside + (y - 1) * (rate - 1) + x - 1;
    case FaceShape::Triangle: // rows of rate - 2, rate - 3, ...
        return _firstInside + (y - 1) * (rate - 1) - y * (y - 1) / 2 + x - 1;
    case FaceShape::SubQuads:
        break;
    }
    if (y == rate) { // the line to the centre, which the sub-quad before has as its last column
        if (x == rate) {
            return _firstInside + _numEdges * rate * (rate - 1);
        }
        subFace = (subFace + _numEdges - 1) % _numEdges;
        std::swap(x, y);
    }
    return _firstInside + subFace * rate * (rate - 1) + (y - 1) * rate + x - 1;
}

PatternVertex DicePattern::LocateInside(std::uint32_t index) const {
    const std::uint32_t rate = _rate.x;
    PatternVertex vertex;
    glm::uvec2 at(0);
    if (_shape == FaceShape::Quad) {
        at = {index % (rate - 1) + 1, index / (rate - 1) + 1};
    } else if (_shape == FaceShape::Triangle) {
        at.y = 1;
        for (std::uint32_t row = rate - 2; index >= row; --row, ++at.y) {
            index -= row;
        }
        at.x = index + 1;
    } else if (index == _numEdges * rate * (rate - 1)) {
        at = _rate;
    } else {
        const std::uint32_t numInSubFace = rate * (rate - 1);
        vertex.at.subFace = static_cast<int>(index / numInSubFace);
        at = {index % numInSubFace % rate + 1, index % numInSubFace / rate + 1};
    }
    vertex.at.uv = glm::dvec2(at) / glm::dvec2(_rate);
    return vertex;
}

FacePoint EdgePoint(FaceShape shape, std::uint32_t numEdges, std::uint32_t edge, double t) {
    const auto subFace = static_cast<int>(edge);
    if (shape == FaceShape::SubQuads) {
        return t <= 0.5
                   ? FacePoint{subFace, {2.0 * t, 0.0}}
                   : FacePoint{(subFace + 1) % static_cast<int>(numEdges), {0.0, 2.0 - 2.0 * t}};
    }
    if (shape == FaceShape::Triangle) {
        return {0, edge == 0   ? glm::dvec2(t, 0.0)
                   : edge == 1 ? glm::dvec2(1.0 - t, t)
                               : glm::dvec2(0.0, 1.0 - t)};
    }
    return {0, edge == 0   ? glm::dvec2(t, 0.0)
               : edge == 1 ? glm::dvec2(1.0, t)
               : edge == 2 ? glm::dvec2(1.0 - t, 1.0)
                           : glm::dvec2(0.0, 1.0 - t)};
}

PatternVertex DicePattern::Locate(std::uint32_t vertex) const {
    if (vertex >= _firstInside) {
        return LocateInside(vertex - _firstInside);
    }
    PatternVertex result;
    result.kind = PatternVertex::Kind::Corner;
    result.index = vertex;
    if (vertex >= _numEdges) {
        result.kind = PatternVertex::Kind::Edge;
        // The last edge that starts at or before the vertex has it: edges without any share their
        // start with the next.
        const auto next = std::upper_bound(_firstOnEdge.begin(), _firstOnEdge.end(), vertex);
        result.index = static_cast<std::uint32_t>(next - _firstOnEdge.begin()) - 1;
        result.step = vertex - _firstOnEdge[result.index] + 1;
    }
    const double t = double(result.step) / double(Rate(result.index));
    result.at = EdgePoint(_shape, _numEdges, result.index, t);
    return result;
}

} // namespace hds
