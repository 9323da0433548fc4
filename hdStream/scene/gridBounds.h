// SPDX-License-Identifier: Apache-2.0
// Between which values a grid is in a part of space, and tables of cells that are made of such
// bounds. Explained in docs/volumes.md.
#pragma once

#include "hdStream/volume/preparedGrid.h"

#include <glm/vec3.hpp>

#include <functional>
#include <vector>

namespace hds {

/// Rounding on the device must not lead to a voxel that a bound does not know: so much further
/// points may be, in voxels.
constexpr double kGridSlack = 1e-3;

/// Tiles and cells for a grid of the scene, whose texture and places among all are yet to be said.
struct GridBounds {
    shared::HdsGrid record{};
    std::vector<shared::HdsGridTile> tiles;
    std::vector<shared::HdsGridCell> cells;
};

/// Between these the interpolation of a grid is.
struct ValueRange {
    double least = 0.0;
    double greatest = 0.0;
};

/// The cell around a voxel, or the value of its tile; 0 outside of the grid.
shared::HdsGridCell GridCellAt(const GridDescription& grid, glm::ivec3 voxel);

/// Between two points, the lesser and the greater along each axis. Where that is much more than a
/// cell it is what tiles know.
ValueRange RangeBetween(const GridDescription& grid, glm::dvec3 first, glm::dvec3 last);

/// Tiles that hold the voxels [first, last], on all cores. \param cellAt of the first voxel of a
/// cell. Thread-safe.
GridBounds MakeGridBounds(glm::ivec3 first, glm::ivec3 last,
                          const std::function<shared::HdsGridCell(glm::ivec3)>& cellAt);

} // namespace hds
