// SPDX-License-Identifier: Apache-2.0
#include "hdStream/scene/gridBounds.h"

#include <glm/common.hpp>
#include <glm/vector_relational.hpp>

#include <algorithm>
#include <cstddef>
#include <limits>

namespace hds {

namespace {

/// Where a range spans more cells than these along an axis, tiles are looked at.
constexpr int kMaxCells = 4;

/// What any tile around the voxels [first, last] has at most; of what it has at least tiles with
/// cells say nothing.
GridRange RangeOfTiles(const GridDescription& grid, glm::ivec3 first, glm::ivec3 last) {
    const shared::HdsGrid& record = grid.record;
    const glm::ivec3 origin(record.origin[0], record.origin[1], record.origin[2]);
    const glm::ivec3 size(record.tiles[0], record.tiles[1], record.tiles[2]);
    const glm::ivec3 begin = glm::max((first - origin) >> HDS_TILE_VOXELS_LOG2, glm::ivec3(0));
    const glm::ivec3 end = glm::min((last - origin) >> HDS_TILE_VOXELS_LOG2, size - 1);
    GridRange range;
    for (glm::ivec3 at = begin; at.z <= end.z; ++at.z) {
        for (at.y = begin.y; at.y <= end.y; ++at.y) {
            for (at.x = begin.x; at.x <= end.x; ++at.x) {
                const auto& tile = grid.tiles[(std::size_t(at.z) * size.y + at.y) * size.x + at.x];
                range.greatest = std::max(range.greatest, double(tile.greatest));
            }
        }
    }
    return range;
}

} // namespace

shared::HdsGridCell GridCellAt(const GridDescription& grid, glm::ivec3 voxel) {
    const shared::HdsGrid& record = grid.record;
    const glm::ivec3 at = voxel - glm::ivec3(record.origin[0], record.origin[1], record.origin[2]);
    const glm::ivec3 tile = at >> HDS_TILE_VOXELS_LOG2;
    const glm::ivec3 size(record.tiles[0], record.tiles[1], record.tiles[2]);
    if (glm::any(glm::lessThan(at, glm::ivec3(0))) || glm::any(glm::greaterThanEqual(tile, size))) {
        return {HDS_NONE, 0.0F, 0.0F, 0.0F};
    }
    const std::size_t number = (std::size_t(tile.z) * size.y + tile.y) * size.x + tile.x;
    const shared::HdsGridTile& above = grid.tiles[number];
    if (above.firstCell == HDS_NONE) {
        return {HDS_NONE, above.value, above.greatest, above.least};
    }
    const glm::ivec3 cell = (at >> HDS_BRICK_VOXELS_LOG2) & (HDS_TILE_CELLS - 1);
    return grid.cells[above.firstCell +
                      (std::size_t(cell.z) * HDS_TILE_CELLS + cell.y) * HDS_TILE_CELLS + cell.x];
}

GridRange RangeBetween(const GridDescription& grid, glm::dvec3 first, glm::dvec3 last) {
    const glm::ivec3 lower(glm::floor(first));
    const glm::ivec3 upper(glm::floor(last));
    const glm::ivec3 begin = lower >> HDS_BRICK_VOXELS_LOG2;
    const glm::ivec3 end = upper >> HDS_BRICK_VOXELS_LOG2;
    if (glm::any(glm::greaterThanEqual(end - begin, glm::ivec3(kMaxCells)))) {
        return RangeOfTiles(grid, lower, upper);
    }
    GridRange range{std::numeric_limits<double>::infinity(), 0.0};
    for (glm::ivec3 at = begin; at.z <= end.z; ++at.z) {
        for (at.y = begin.y; at.y <= end.y; ++at.y) {
            for (at.x = begin.x; at.x <= end.x; ++at.x) {
                const shared::HdsGridCell cell = GridCellAt(grid, at * HDS_BRICK_VOXELS);
                range.least = std::min(range.least, double(cell.least));
                range.greatest = std::max(range.greatest, double(cell.greatest));
            }
        }
    }
    return range;
}

} // namespace hds
