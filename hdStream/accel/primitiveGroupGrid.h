// SPDX-License-Identifier: Apache-2.0
// The groups of geometry, sorted into the cells of a regular grid by the centres of their boxes.
// Private to the layer. Explained in docs/accel.md.
#pragma once

#include "hdStream/geometry/chunkSource.h"

#include <array>
#include <cstdint>
#include <vector>

namespace hds {

/// A cell that has groups.
struct GridCell {
    std::array<std::uint16_t, 3> at{}; ///< along x, y, z
    std::uint32_t index = 0;           ///< in the grid
    std::uint32_t numGroups = 0;
    std::uint64_t numTriangles = 0; ///< of the groups, upper bounds
    Bounds bounds;                  ///< holds the groups
};

/// Sorts groups by counting, in one pass; the result does not depend on the number of threads.
class PrimitiveGroupGrid {
public:
    /// \param bounds holds the groups. \param numCells about how many cells with groups to aim at,
    /// where there are so many groups.
    PrimitiveGroupGrid(const PrimitiveGroups& source, std::vector<std::uint32_t> groups,
                       const Bounds& bounds, std::size_t numCells);

    /// Those that have groups, in the order of their indices.
    const std::vector<GridCell>& Cells() const { return _cells; }
    /// Object-space size of a cell.
    const glm::dvec3& CellSize() const { return _cellSize; }
    /// As given.
    const std::vector<std::uint32_t>& Groups() const { return _groups; }
    /// The groups cell by cell, in the order of `cells`; inside a cell in the order given.
    std::vector<std::uint32_t> OrderGroups(const std::vector<GridCell>& cells) const;

private:
    /// What the groups of a block come to in a cell.
    struct CellCount {
        std::uint32_t numGroups = 0;
        std::uint32_t numTriangles = 0;
        Bounds bounds;
    };

    void ChooseCells(const Bounds& bounds, std::size_t numCells);
    std::uint32_t CellOf(const Bounds& group) const;
    void CollectCells(const std::vector<CellCount>& counts);

    std::vector<std::uint32_t> _groups;
    std::vector<std::uint32_t> _cellByGroup; ///< [groups]
    std::vector<GridCell> _cells;
    glm::vec3 _low{0.0F};
    glm::vec3 _cellsPerLength{0.0F};
    glm::dvec3 _cellSize{0.0};
    std::array<std::uint32_t, 3> _size{1, 1, 1};
    std::size_t _numGridCells = 1;
    std::size_t _blockSize = 0;
    std::size_t _numBlocks = 0;
    std::vector<std::uint32_t> _counts; ///< [blocks][grid cells] groups
};

} // namespace hds
