// SPDX-License-Identifier: Apache-2.0
// The tiles and cells of a grid. Explained in docs/volumes.md, section "Grids".
#pragma once

#include "kernels/shared/grid.h"

#include <glm/vec3.hpp>

#include <functional>
#include <vector>

namespace hds {

/// What of a grid is always resident.
struct GridTiles {
    shared::HdsGrid record{}; ///< texture and places among those of the scene are yet to be said
    std::vector<shared::HdsGridTile> tiles;
    std::vector<shared::HdsGridCell> cells;
};

/// Tiles that hold the voxels [first, last], on all cores; those whose cells are all alike have no
/// cells. \param cellAt of the first voxel of a cell. Thread-safe.
GridTiles MakeGridTiles(glm::ivec3 first, glm::ivec3 last,
                        const std::function<shared::HdsGridCell(glm::ivec3)>& cellAt);

} // namespace hds
