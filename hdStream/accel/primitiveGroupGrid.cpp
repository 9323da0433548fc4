// SPDX-License-Identifier: Apache-2.0
#include "hdStream/accel/primitiveGroupGrid.h"

#include <glm/common.hpp>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>

namespace hds {
namespace {

/// Cells of the whole grid; surfaces leave most of them empty.
constexpr double kMaxGridCells = 1U << 17U;
/// Grid cells for each one that is to have groups: a surface meets about the square of the cells
/// along an axis out of their cube.
constexpr double kGridExponent = 1.5;
/// Fewest groups of the geometry for each grid cell.
constexpr std::size_t kGroupsPerCell = 4;
/// Blocks of groups are counted apart from each other, by different threads.
constexpr std::size_t kMinBlockSize = 1U << 14U;
constexpr std::size_t kMaxBlocks = 8;

void Grow(Bounds* bounds, const Bounds& other) {
    bounds->min = glm::min(bounds->min, other.min);
    bounds->max = glm::max(bounds->max, other.max);
}

} // namespace

PrimitiveGroupGrid::PrimitiveGroupGrid(const PrimitiveGroups& source,
                                       std::vector<std::uint32_t> groups, const Bounds& bounds,
                                       std::size_t numCells)
    : _groups(std::move(groups)),
      _blockSize(std::max(kMinBlockSize, (_groups.size() + kMaxBlocks - 1) / kMaxBlocks)),
      _numBlocks((_groups.size() + _blockSize - 1) / _blockSize) {
    ChooseCells(bounds, numCells);
    _cellByGroup.resize(_groups.size());
    std::vector<CellCount> counts(_numBlocks * _numGridCells);
    tbb::parallel_for(std::size_t{0}, _numBlocks, [&](std::size_t block) {
        CellCount* const ofBlock = counts.data() + block * _numGridCells;
        const std::size_t end = std::min((block + 1) * _blockSize, _groups.size());
        for (std::size_t i = block * _blockSize; i < end; ++i) {
            const Bounds group = source.GroupBounds(_groups[i]);
            _cellByGroup[i] = CellOf(group);
            CellCount& cell = ofBlock[_cellByGroup[i]];
            ++cell.numGroups;
            cell.numTriangles += source.GroupTriangles(_groups[i]);
            Grow(&cell.bounds, group);
        }
    });
    CollectCells(counts);
}

void PrimitiveGroupGrid::CollectCells(const std::vector<CellCount>& counts) {
    _counts.resize(counts.size());
    for (std::uint32_t index = 0; index < _numGridCells; ++index) {
        GridCell cell;
        for (std::size_t block = 0; block < _numBlocks; ++block) {
            const CellCount& count = counts[block * _numGridCells + index];
            _counts[block * _numGridCells + index] = count.numGroups;
            cell.numGroups += count.numGroups;
            cell.numTriangles += count.numTriangles;
            Grow(&cell.bounds, count.bounds);
        }
        if (cell.numGroups > 0) {
            cell.index = index;
            cell.at = {static_cast<std::uint16_t>(index % _size[0]),
                       static_cast<std::uint16_t>(index / _size[0] % _size[1]),
                       static_cast<std::uint16_t>(index / _size[0] / _size[1])};
            _cells.push_back(cell);
        }
    }
}

/// Cells are about cubes; an axis along which all groups agree has one.
void PrimitiveGroupGrid::ChooseCells(const Bounds& bounds, std::size_t numCells) {
    _low = bounds.min;
    const glm::dvec3 extent = glm::dvec3(bounds.max) - glm::dvec3(bounds.min);
    // Empty cells cost as much as full ones.
    const double wanted =
        std::min({kMaxGridCells, static_cast<double>(_groups.size() / kGroupsPerCell + 1),
                  std::pow(static_cast<double>(numCells), kGridExponent)});
    // The side of a cube of which `wanted` fill the box, flat axes left out.
    double volume = 1.0;
    int numAxes = 0;
    const double longest = std::max({extent.x, extent.y, extent.z});
    for (int axis = 0; axis < 3; ++axis) {
        if (extent[axis] * wanted > longest) {
            volume *= extent[axis] / longest;
            ++numAxes;
        }
    }
    const double side = numAxes > 0 ? longest * std::pow(volume / wanted, 1.0 / numAxes) : 1.0;
    for (int axis = 0; axis < 3; ++axis) {
        const double cells = side > 0.0 ? std::floor(extent[axis] / side) : 0.0;
        _size[axis] = static_cast<std::uint32_t>(std::clamp(cells, 1.0, 65535.0));
        _cellSize[axis] = extent[axis] / _size[axis];
        _cellsPerLength[axis] =
            extent[axis] > 0.0 ? static_cast<float>(_size[axis] / extent[axis]) : 0.0F;
        if (!std::isfinite(_cellsPerLength[axis])) {
            _cellsPerLength[axis] = 0.0F; // an extent that is denormal
        }
    }
    _numGridCells = std::size_t{_size[0]} * _size[1] * _size[2];
}

/// By the centre of its box.
std::uint32_t PrimitiveGroupGrid::CellOf(const Bounds& group) const {
    std::uint32_t at[3];
    for (int axis = 0; axis < 3; ++axis) {
        const float centre = 0.5F * group.min[axis] + 0.5F * group.max[axis]; // cannot overflow
        const float cell = std::max(0.0F, (centre - _low[axis]) * _cellsPerLength[axis]);
        at[axis] = std::min(static_cast<std::uint32_t>(cell), _size[axis] - 1);
    }
    return (at[2] * _size[1] + at[1]) * _size[0] + at[0];
}

std::vector<std::uint32_t>
PrimitiveGroupGrid::OrderGroups(const std::vector<GridCell>& cells) const {
    // Where the groups of each block begin inside each cell.
    std::vector<std::uint32_t> begins(_counts.size());
    std::uint32_t begin = 0;
    for (const GridCell& cell : cells) {
        for (std::size_t block = 0; block < _numBlocks; ++block) {
            begins[block * _numGridCells + cell.index] = begin;
            begin += _counts[block * _numGridCells + cell.index];
        }
    }
    std::vector<std::uint32_t> ordered(_groups.size());
    tbb::parallel_for(std::size_t{0}, _numBlocks, [&](std::size_t block) {
        const std::size_t end = std::min((block + 1) * _blockSize, _groups.size());
        for (std::size_t i = block * _blockSize; i < end; ++i) {
            ordered[begins[block * _numGridCells + _cellByGroup[i]]++] = _groups[i];
        }
    });
    return ordered;
}

} // namespace hds
