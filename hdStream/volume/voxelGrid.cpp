// SPDX-License-Identifier: Apache-2.0
#include "hdStream/volume/voxelGrid.h"

#include <glm/common.hpp>

#include <cmath>
#include <limits>
#include <stdexcept>

namespace hds {

namespace {

/// 512 MiB of cells, a box of 2^35 voxels.
constexpr double kMaxCells = 1U << 26U;
/// Where floats still tell voxels, and points between them, apart.
constexpr double kFarthestVoxel = 1U << 20U;

constexpr int kCellMask = HDS_BRICK_VOXELS - 1;

} // namespace

VoxelGrid::VoxelGrid(glm::dvec3 firstVoxel, glm::dvec3 boxSize, const glm::dmat4& placement)
    : first(0), size(0), firstCell(0), numCells(0), objectFromIndex(placement) {
    const glm::dvec3 farthest = glm::max(glm::abs(firstVoxel), glm::abs(firstVoxel + boxSize));
    if (!(boxSize.x >= 1.0 && boxSize.y >= 1.0 && boxSize.z >= 1.0)) {
        throw std::runtime_error("the grid has no voxels");
    }
    if (!(farthest.x < kFarthestVoxel && farthest.y < kFarthestVoxel &&
          farthest.z < kFarthestVoxel)) {
        throw std::runtime_error("the grid has voxels beyond 2^20");
    }
    first = glm::ivec3(firstVoxel);
    size = glm::ivec3(boxSize);
    firstCell = first >> HDS_BRICK_VOXELS_LOG2;
    numCells = ((first + size - 1) >> HDS_BRICK_VOXELS_LOG2) - firstCell + 1;
    const glm::dvec3 count(numCells);
    if (count.x * count.y * count.z > kMaxCells) {
        throw std::runtime_error("the box around its active voxels has more than 2^35 of them");
    }
    cells.resize(static_cast<std::size_t>(count.x * count.y * count.z));
}

std::size_t VoxelGrid::CellOf(glm::ivec3 voxel) const {
    const glm::ivec3 cell = (voxel >> HDS_BRICK_VOXELS_LOG2) - firstCell;
    return (std::size_t(cell.z) * numCells.y + cell.y) * numCells.x + cell.x;
}

VoxelBrick* VoxelGrid::AddBrick(std::size_t cell) {
    cells[cell].brick = static_cast<std::uint32_t>(bricks.size());
    return &bricks.emplace_back(VoxelBrick{});
}

float VoxelGrid::ValueAt(glm::ivec3 voxel) const {
    const glm::ivec3 at = voxel - first;
    if (at.x < 0 || at.y < 0 || at.z < 0 || at.x >= size.x || at.y >= size.y || at.z >= size.z) {
        return 0.0F;
    }
    const VoxelCell& cell = cells[CellOf(voxel)];
    if (cell.brick == HDS_NONE) {
        return cell.value;
    }
    const glm::ivec3 inside = voxel & kCellMask;
    return bricks[cell.brick]
                 [(inside.z * HDS_BRICK_VOXELS + inside.y) * HDS_BRICK_VOXELS + inside.x];
}

float VoxelValue(double value) {
    const bool isGood = value > 0.0 && value <= std::numeric_limits<float>::max();
    return isGood ? static_cast<float>(value) : 0.0F;
}

VoxelGrid MakeVoxelGrid(const float* values, glm::ivec3 first, glm::ivec3 size,
                        const glm::dmat4& objectFromIndex) {
    VoxelGrid grid(first, size, objectFromIndex);
    for (int z = 0; z < size.z; ++z) {
        for (int y = 0; y < size.y; ++y) {
            for (int x = 0; x < size.x; ++x) {
                const float value = VoxelValue(*values++);
                const glm::ivec3 voxel = first + glm::ivec3(x, y, z);
                const std::size_t cell = grid.CellOf(voxel);
                if (value == 0.0F) {
                    continue;
                }
                VoxelBrick* brick = grid.cells[cell].brick == HDS_NONE
                                        ? grid.AddBrick(cell)
                                        : &grid.bricks[grid.cells[cell].brick];
                const glm::ivec3 inside = voxel & kCellMask;
                (*brick)[(inside.z * HDS_BRICK_VOXELS + inside.y) * HDS_BRICK_VOXELS + inside.x] =
                    value;
            }
        }
    }
    return grid;
}

} // namespace hds
