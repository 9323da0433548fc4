// SPDX-License-Identifier: Apache-2.0
// Bounds of a grid whose voxels move while the shutter is open. Explained in docs/volumes.md,
// section "Motion".
#pragma once

#include "hdStream/volume/gridPreparer.h"
#include "hdStream/volume/gridTiles.h"

#include <glm/mat3x3.hpp>
#include <glm/vec3.hpp>

namespace hds {

/// The velocity of a volume: what a point of its lattice has, in seconds from the frame on.
struct GridVelocity {
    PreparedGrids grids;    ///< HDS_VELOCITY_GRIDS; empty: at rest
    bool isAligned = false; ///< with the voxels of the lattice
    glm::dmat3 latticeFromVelocity{1.0};
    double openSeconds = 0.0;
    double closeSeconds = 0.0;
};

/// How far a point is moved before it is looked up, in voxels: the least and the most.
struct VoxelShift {
    glm::dvec3 least{0.0};
    glm::dvec3 most{0.0};
};

/// Of all points of the lattice.
VoxelShift ShiftOf(const GridVelocity& velocity);

/// Tiles and cells of a grid whose `greatest` holds at any time of the shutter. Cells have the
/// values and bricks of the grid's own. \pre the velocity has grids.
GridTiles SpreadGrid(const GridDescription& grid, const GridVelocity& velocity);

} // namespace hds
