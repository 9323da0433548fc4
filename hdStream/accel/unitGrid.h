// SPDX-License-Identifier: Apache-2.0
// The units of a mesh, sorted into the cells of a regular grid by the centres of their boxes.
// Private to the layer. Explained in docs/accel.md.
#pragma once

#include "hdStream/geometry/chunkSource.h"

#include <array>
#include <cstdint>
#include <vector>

namespace hds {

/// A cell that has units.
struct GridCell {
    std::array<std::uint16_t, 3> at{}; ///< along x, y, z
    std::uint32_t index = 0;           ///< in the grid
    std::uint32_t numUnits = 0;
    std::uint64_t numTriangles = 0; ///< of the units, upper bounds
    Bounds bounds;                  ///< holds the units
};

/// Sorts units by counting, in one pass; the result does not depend on the number of threads.
class UnitGrid {
public:
    /// \param bounds holds the units. \param numCells about how many cells with units to aim at,
    /// where there are so many units.
    UnitGrid(const ChunkSource& source, std::vector<std::uint32_t> units, const Bounds& bounds,
             std::size_t numCells);

    /// Those that have units, in the order of their indices.
    const std::vector<GridCell>& Cells() const { return _cells; }
    /// Object-space size of a cell.
    const glm::dvec3& CellSize() const { return _cellSize; }
    /// As given.
    const std::vector<std::uint32_t>& Units() const { return _units; }
    /// The units cell by cell, in the order of `cells`; inside a cell in the order given.
    std::vector<std::uint32_t> OrderUnits(const std::vector<GridCell>& cells) const;

private:
    /// What the units of a block come to in a cell.
    struct CellCount {
        std::uint32_t numUnits = 0;
        std::uint32_t numTriangles = 0;
        Bounds bounds;
    };

    void ChooseCells(const Bounds& bounds, std::size_t numCells);
    std::uint32_t CellOf(const Bounds& unit) const;
    void CollectCells(const std::vector<CellCount>& counts);

    std::vector<std::uint32_t> _units;
    std::vector<std::uint32_t> _cellByUnit; ///< [units]
    std::vector<GridCell> _cells;
    glm::vec3 _low{0.0F};
    glm::vec3 _cellsPerLength{0.0F};
    glm::dvec3 _cellSize{0.0};
    std::array<std::uint32_t, 3> _size{1, 1, 1};
    std::size_t _numGridCells = 1;
    std::size_t _blockSize = 0;
    std::size_t _numBlocks = 0;
    std::vector<std::uint32_t> _counts; ///< [blocks][grid cells] units
};

} // namespace hds
