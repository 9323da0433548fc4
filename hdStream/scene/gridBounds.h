// SPDX-License-Identifier: Apache-2.0
// Between which values a grid is in a part of space. Explained in docs/volumes.md.
#pragma once

#include "hdStream/volume/preparedGrid.h"

#include <glm/vec3.hpp>

namespace hds {

/// Rounding on the device must not lead to a voxel that a bound does not know: so much further
/// points may be, in voxels.
constexpr double kGridSlack = 1e-3;

/// Between these the interpolation of a grid is.
struct GridRange {
    double least = 0.0;
    double greatest = 0.0;
};

/// The cell around a voxel, or the value of its tile; 0 outside of the grid.
shared::HdsGridCell GridCellAt(const GridDescription& grid, glm::ivec3 voxel);

/// Between two points, the lesser and the greater along each axis. Where that is much more than a
/// cell it is what tiles know.
GridRange RangeBetween(const GridDescription& grid, glm::dvec3 first, glm::dvec3 last);

} // namespace hds
