// SPDX-License-Identifier: Apache-2.0
#include "hdStream/volume/gridTiles.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cstddef>

namespace hds {

namespace {

constexpr std::size_t kTileCells = std::size_t{HDS_TILE_CELLS} * HDS_TILE_CELLS * HDS_TILE_CELLS;

/// A tile while it is made.
struct TileBuild {
    shared::HdsGridTile tile{HDS_NONE, 0.0F, 0.0F, 0.0F};
    std::vector<shared::HdsGridCell> cells; ///< empty: all alike
};

TileBuild MakeTile(glm::ivec3 first, const std::function<shared::HdsGridCell(glm::ivec3)>& cellAt) {
    TileBuild build;
    build.cells.reserve(kTileCells);
    bool isAlike = true;
    for (std::size_t i = 0; i < kTileCells; ++i) {
        const auto n = static_cast<int>(i);
        const shared::HdsGridCell cell =
            cellAt(first + HDS_BRICK_VOXELS * glm::ivec3(n % HDS_TILE_CELLS,
                                                         n / HDS_TILE_CELLS % HDS_TILE_CELLS,
                                                         n / HDS_TILE_CELLS / HDS_TILE_CELLS));
        const shared::HdsGridCell& head = build.cells.empty() ? cell : build.cells[0];
        isAlike = isAlike && cell.brick == HDS_NONE && cell.value == head.value &&
                  cell.greatest == head.greatest && cell.least == head.least;
        build.tile.greatest = std::max(build.tile.greatest, cell.greatest);
        build.cells.push_back(cell);
    }
    build.tile.value = build.cells[0].value;
    if (isAlike) {
        build.tile.least = build.cells[0].least;
        build.cells = {};
    }
    return build;
}

} // namespace

GridTiles MakeGridTiles(glm::ivec3 first, glm::ivec3 last,
                        const std::function<shared::HdsGridCell(glm::ivec3)>& cellAt) {
    const glm::ivec3 origin = (first >> HDS_TILE_VOXELS_LOG2) * HDS_TILE_VOXELS;
    const glm::ivec3 numTiles = ((last - origin) >> HDS_TILE_VOXELS_LOG2) + glm::ivec3(1);
    GridTiles made;
    for (int i = 0; i < 3; ++i) {
        made.record.origin[i] = origin[i];
        made.record.tiles[i] = static_cast<std::uint32_t>(numTiles[i]);
    }
    std::vector<TileBuild> builds(std::size_t(numTiles.x) * numTiles.y * numTiles.z);
    tbb::parallel_for(std::size_t{0}, builds.size(), [&](std::size_t i) {
        const auto n = static_cast<int>(i);
        const glm::ivec3 at(n % numTiles.x, n / numTiles.x % numTiles.y,
                            n / numTiles.x / numTiles.y);
        builds[i] = MakeTile(origin + HDS_TILE_VOXELS * at, cellAt);
    });
    for (TileBuild& build : builds) {
        if (!build.cells.empty()) {
            build.tile.firstCell = static_cast<std::uint32_t>(made.cells.size());
        }
        made.cells.insert(made.cells.end(), build.cells.begin(), build.cells.end());
        made.tiles.push_back(build.tile);
        made.record.greatest = std::max(made.record.greatest, build.tile.greatest);
    }
    return made;
}

} // namespace hds
