// SPDX-License-Identifier: Apache-2.0
#include "hdStream/scene/movingGrid.h"

#include "kernels/shared/volume.h"

#include <glm/common.hpp>
#include <glm/vector_relational.hpp>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cstddef>

namespace hds {

namespace {

constexpr std::size_t kTileCells = std::size_t{HDS_TILE_CELLS} * HDS_TILE_CELLS * HDS_TILE_CELLS;
/// Rounding on the device must not lead to a voxel that a bound does not know.
constexpr double kSlack = 1e-3;
/// Where a cell's points come from more cells than these along an axis, bounds of tiles do.
constexpr int kMaxCells = 4;

/// A cell of a grid, or its tile's value.
shared::HdsGridCell CellAt(const GridDescription& grid, glm::ivec3 voxel) {
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

/// The greatest value that any tile around the voxels [first, last] has.
float GreatestOfTiles(const GridDescription& grid, glm::ivec3 first, glm::ivec3 last) {
    const shared::HdsGrid& record = grid.record;
    const glm::ivec3 origin(record.origin[0], record.origin[1], record.origin[2]);
    const glm::ivec3 size(record.tiles[0], record.tiles[1], record.tiles[2]);
    const glm::ivec3 begin = glm::max((first - origin) >> HDS_TILE_VOXELS_LOG2, glm::ivec3(0));
    const glm::ivec3 end = glm::min((last - origin) >> HDS_TILE_VOXELS_LOG2, size - 1);
    float greatest = 0.0F;
    for (glm::ivec3 at = begin; at.z <= end.z; ++at.z) {
        for (at.y = begin.y; at.y <= end.y; ++at.y) {
            for (at.x = begin.x; at.x <= end.x; ++at.x) {
                greatest = std::max(
                    greatest,
                    grid.tiles[(std::size_t(at.z) * size.y + at.y) * size.x + at.x].greatest);
            }
        }
    }
    return greatest;
}

/// The greatest value that interpolation between the points `first` and `last` can have.
float GreatestBetween(const GridDescription& grid, glm::dvec3 first, glm::dvec3 last) {
    const glm::ivec3 least(glm::floor(first));
    const glm::ivec3 most(glm::floor(last));
    const glm::ivec3 begin = least >> HDS_BRICK_VOXELS_LOG2;
    const glm::ivec3 end = most >> HDS_BRICK_VOXELS_LOG2;
    if (glm::any(glm::greaterThanEqual(end - begin, glm::ivec3(kMaxCells)))) {
        return GreatestOfTiles(grid, least, most);
    }
    float greatest = 0.0F;
    for (glm::ivec3 at = begin; at.z <= end.z; ++at.z) {
        for (at.y = begin.y; at.y <= end.y; ++at.y) {
            for (at.x = begin.x; at.x <= end.x; ++at.x) {
                greatest = std::max(greatest, CellAt(grid, at * HDS_BRICK_VOXELS).greatest);
            }
        }
    }
    return greatest;
}

/// \param greatest of each grid of the velocity.
VoxelShift ShiftOf(const GridVelocity& velocity, const float* greatest) {
    VoxelShift shift;
    for (int row = 0; row < 3; ++row) {
        double least = 0.0; // voxels a second
        double most = 0.0;
        for (int axis = 0; axis < 3; ++axis) {
            const double factor = velocity.latticeFromVelocity[axis][row];
            const double up = factor * greatest[axis];
            const double down = -factor * greatest[axis + 3];
            least += std::min({up, down, 0.0});
            most += std::max({up, down, 0.0});
        }
        for (const double seconds : {velocity.openSeconds, velocity.closeSeconds}) {
            shift.least[row] = std::min({shift.least[row], -seconds * least, -seconds * most});
            shift.most[row] = std::max({shift.most[row], -seconds * least, -seconds * most});
        }
    }
    return shift;
}

struct TileBuild {
    shared::HdsGridTile tile{HDS_NONE, 0.0F, 0.0F, 0.0F};
    std::vector<shared::HdsGridCell> cells; ///< empty: all alike
};

TileBuild MakeTile(const GridDescription& grid, const GridVelocity& velocity, VoxelShift most,
                   glm::ivec3 first) {
    TileBuild build;
    bool isAlike = true;
    for (std::size_t i = 0; i < kTileCells; ++i) {
        const auto n = static_cast<int>(i);
        const glm::ivec3 at =
            first + HDS_BRICK_VOXELS * glm::ivec3(n % HDS_TILE_CELLS,
                                                  n / HDS_TILE_CELLS % HDS_TILE_CELLS,
                                                  n / HDS_TILE_CELLS / HDS_TILE_CELLS);
        VoxelShift shift = most;
        if (velocity.isAligned) {
            float greatest[HDS_VELOCITY_GRIDS];
            for (std::size_t k = 0; k < HDS_VELOCITY_GRIDS; ++k) {
                greatest[k] = CellAt(velocity.grids[k]->description, at).greatest;
            }
            shift = ShiftOf(velocity, greatest);
        }
        shared::HdsGridCell cell = CellAt(grid, at);
        const glm::dvec3 begin(at);
        cell.least = 0.0F; // of what moves in from elsewhere nothing is known
        cell.greatest = GreatestBetween(grid, begin + shift.least - kSlack,
                                        begin + double(HDS_BRICK_VOXELS) + shift.most + kSlack);
        const shared::HdsGridCell& head = build.cells.empty() ? cell : build.cells[0];
        isAlike = isAlike && cell.brick == HDS_NONE && cell.value == head.value &&
                  cell.greatest == head.greatest;
        build.tile.greatest = std::max(build.tile.greatest, cell.greatest);
        build.cells.push_back(cell);
    }
    build.tile.value = build.cells[0].value;
    if (isAlike) {
        build.cells.clear();
    }
    return build;
}

} // namespace

VoxelShift ShiftOf(const GridVelocity& velocity) {
    float greatest[HDS_VELOCITY_GRIDS];
    for (std::size_t k = 0; k < HDS_VELOCITY_GRIDS; ++k) {
        greatest[k] = velocity.grids[k]->description.record.greatest;
    }
    return ShiftOf(velocity, greatest);
}

MovingGrid SpreadGrid(const GridDescription& grid, const GridVelocity& velocity) {
    const VoxelShift shift = ShiftOf(velocity);
    // A point is seen where it has come to: opposite to where it is looked up.
    const glm::ivec3 first = glm::ivec3(glm::floor(glm::dvec3(grid.first - 1) - shift.most));
    const glm::ivec3 last = glm::ivec3(glm::ceil(glm::dvec3(grid.first + grid.size) - shift.least));
    const glm::ivec3 origin = (first >> HDS_TILE_VOXELS_LOG2) * HDS_TILE_VOXELS;
    const glm::ivec3 numTiles = ((last - origin) >> HDS_TILE_VOXELS_LOG2) + glm::ivec3(1);
    MovingGrid moving;
    moving.record = grid.record;
    for (int i = 0; i < 3; ++i) {
        moving.record.origin[i] = origin[i];
        moving.record.tiles[i] = static_cast<std::uint32_t>(numTiles[i]);
    }
    std::vector<TileBuild> tiles(std::size_t(numTiles.x) * numTiles.y * numTiles.z);
    tbb::parallel_for(std::size_t{0}, tiles.size(), [&](std::size_t i) {
        const auto n = static_cast<int>(i);
        const glm::ivec3 at(n % numTiles.x, n / numTiles.x % numTiles.y,
                            n / numTiles.x / numTiles.y);
        tiles[i] = MakeTile(grid, velocity, shift, origin + HDS_TILE_VOXELS * at);
    });
    for (TileBuild& tile : tiles) {
        if (!tile.cells.empty()) {
            tile.tile.firstCell = static_cast<std::uint32_t>(moving.cells.size());
        }
        moving.cells.insert(moving.cells.end(), tile.cells.begin(), tile.cells.end());
        moving.tiles.push_back(tile.tile);
    }
    return moving;
}

} // namespace hds
