// SPDX-License-Identifier: Apache-2.0
// A sparse grid of voxels in memory. Explained in docs/volumes.md, section "Grids".
#pragma once

#include "kernels/shared/grid.h"

#include <glm/mat4x4.hpp>
#include <glm/vec3.hpp>

#include <array>
#include <cstdint>
#include <vector>

namespace hds {

/// The voxels of a cell: x is fastest, then y, then z.
using VoxelBrick = std::array<float, HDS_BRICK_VOXELS * HDS_BRICK_VOXELS * HDS_BRICK_VOXELS>;

/// A cell of HDS_BRICK_VOXELS^3 voxels.
struct VoxelCell {
    std::uint32_t brick = HDS_NONE; ///< its voxels; HDS_NONE: every voxel has `value`
    float value = 0.0F;
};

/// Voxels of a box, as floats. Voxel (i, j, k) is at the point (i, j, k) of index space; between
/// voxels the grid is their linear interpolation, and outside of the box it is 0. Values are finite
/// and no less than 0. Immutable once it is shared.
struct VoxelGrid {
    /// Zeros. \throws std::runtime_error when the box is empty or its cells are too many.
    VoxelGrid(glm::dvec3 firstVoxel, glm::dvec3 boxSize, const glm::dmat4& placement);

    /// The cell of a voxel that is in the box.
    std::size_t CellOf(glm::ivec3 voxel) const;
    /// Makes a cell have voxels of its own, that are zeros.
    VoxelBrick* AddBrick(std::size_t cell);
    float ValueAt(glm::ivec3 voxel) const;

    glm::ivec3 first;     ///< the least voxel
    glm::ivec3 size;      ///< voxels along each axis
    glm::ivec3 firstCell; ///< that holds `first`, in cells from voxel 0
    glm::ivec3 numCells;
    glm::dmat4 objectFromIndex;   ///< affine
    std::vector<VoxelCell> cells; ///< [numCells.z][numCells.y][numCells.x]
    std::vector<VoxelBrick> bricks;
};

/// What counts of a value: NaN, infinities and what is below 0 are 0.
float VoxelValue(double value);

/// A grid of all voxels of a box. \param values [size.z][size.y][size.x]. \throws as VoxelGrid.
VoxelGrid MakeVoxelGrid(const float* values, glm::ivec3 first, glm::ivec3 size,
                        const glm::dmat4& objectFromIndex);

} // namespace hds
