// SPDX-License-Identifier: Apache-2.0
#include "hdStream/scene/movingGrid.h"

#include "hdStream/scene/gridBounds.h"
#include "kernels/shared/volume.h"

#include <glm/common.hpp>

#include <algorithm>
#include <cstddef>

namespace hds {

namespace {

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

/// \param most of all points.
shared::HdsGridCell MovingCell(const GridDescription& grid, const GridVelocity& velocity,
                               const VoxelShift& most, glm::ivec3 first) {
    VoxelShift shift = most;
    if (velocity.isAligned) {
        float greatest[HDS_VELOCITY_GRIDS];
        for (std::size_t k = 0; k < HDS_VELOCITY_GRIDS; ++k) {
            greatest[k] = GridCellAt(velocity.grids[k]->description, first).greatest;
        }
        shift = ShiftOf(velocity, greatest);
    }
    shared::HdsGridCell cell = GridCellAt(grid, first);
    const glm::dvec3 begin(first);
    const GridRange range =
        RangeBetween(grid, begin + shift.least - kGridSlack,
                     begin + double(HDS_BRICK_VOXELS) + shift.most + kGridSlack);
    cell.least = 0.0F; // of what moves in from elsewhere nothing is known
    cell.greatest = static_cast<float>(range.greatest);
    return cell;
}

} // namespace

VoxelShift ShiftOf(const GridVelocity& velocity) {
    float greatest[HDS_VELOCITY_GRIDS];
    for (std::size_t k = 0; k < HDS_VELOCITY_GRIDS; ++k) {
        greatest[k] = velocity.grids[k]->description.record.greatest;
    }
    return ShiftOf(velocity, greatest);
}

GridTiles SpreadGrid(const GridDescription& grid, const GridVelocity& velocity) {
    const VoxelShift shift = ShiftOf(velocity);
    // A point is seen where it has come to: opposite to where it is looked up.
    const glm::ivec3 first = glm::ivec3(glm::floor(glm::dvec3(grid.first - 1) - shift.most));
    const glm::ivec3 last = glm::ivec3(glm::ceil(glm::dvec3(grid.first + grid.size) - shift.least));
    return MakeGridTiles(
        first, last, [&](glm::ivec3 voxel) { return MovingCell(grid, velocity, shift, voxel); });
}

} // namespace hds
