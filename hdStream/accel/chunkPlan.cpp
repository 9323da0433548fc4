// SPDX-License-Identifier: Apache-2.0
#include "hdStream/accel/chunkPlan.h"

#include "hdStream/accel/primitiveGroupGrid.h"
#include "hdStream/base/error.h"

#include <glm/common.hpp>
#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <array>
#include <limits>

namespace hds {
namespace {

/// Cells a chunk should have: more cells cut better and cost more.
constexpr std::size_t kCellsPerChunk = 512;

using Cells = std::vector<GridCell>;
using CellRange = std::pair<Cells::iterator, Cells::iterator>;

/// Where to cut a range of cells.
struct Cut {
    int axis = -1; ///< -1: nowhere
    std::uint32_t plane = 0;
};

/// A box of cells, in cells.
struct CellBox {
    std::array<std::uint32_t, 3> low;
    std::array<std::uint32_t, 3> high;

    CellBox() {
        low.fill(std::numeric_limits<std::uint32_t>::max());
        high.fill(0);
    }
    void Grow(const CellBox& other) {
        for (int axis = 0; axis < 3; ++axis) {
            low[axis] = std::min(low[axis], other.low[axis]);
            high[axis] = std::max(high[axis], other.high[axis]);
        }
    }
    void Grow(const GridCell& cell) {
        for (int axis = 0; axis < 3; ++axis) {
            low[axis] = std::min<std::uint32_t>(low[axis], cell.at[axis]);
            high[axis] = std::max<std::uint32_t>(high[axis], cell.at[axis]);
        }
    }
    double HalfArea(const glm::dvec3& cellSize) const {
        if (low[0] > high[0]) {
            return 0.0;
        }
        glm::dvec3 size;
        for (int axis = 0; axis < 3; ++axis) {
            size[axis] = (high[axis] - low[axis] + 1.0) * cellSize[axis];
        }
        return size.x * size.y + size.y * size.z + size.z * size.x;
    }
};

/// Cuts the groups of one grid.
class Planner {
public:
    Planner(const PrimitiveGroups& source, std::uint32_t maxTriangles, ChunkPlan* plan)
        : _source(source), _maxTriangles(maxTriangles), _plan(*plan) {}

    /// Appends the chunks of `groups`, which lie in `bounds` and have `numTriangles`.
    void Plan(std::vector<std::uint32_t> groups, const Bounds& bounds, std::uint64_t numTriangles) {
        Cells cells;
        std::vector<std::size_t> ends;
        std::vector<std::uint32_t> ordered;
        {
            const PrimitiveGroupGrid grid(_source, std::move(groups), bounds,
                                          kCellsPerChunk * (numTriangles / _maxTriangles + 1));
            if (grid.Cells().size() == 1) {
                CutByOrder(grid.Groups()); // all centres are at about one place
                return;
            }
            cells = grid.Cells();
            CutCells(cells, 0, cells.size(), grid.CellSize(), &ends);
            ordered = grid.OrderGroups(cells);
        } // the grid takes as much as the chunks that are made now
        std::vector<Part> parts;
        parts.reserve(ends.size());
        std::size_t group = 0;
        std::size_t cell = 0;
        for (const std::size_t end : ends) {
            Part part;
            part.groups = ordered.data() + group;
            const bool isOneCell = end - cell == 1;
            for (; cell < end; ++cell) {
                part.numGroups += cells[cell].numGroups;
                part.numTriangles += cells[cell].numTriangles;
                part.bounds.min = glm::min(part.bounds.min, cells[cell].bounds.min);
                part.bounds.max = glm::max(part.bounds.max, cells[cell].bounds.max);
            }
            part.isTooLarge = isOneCell && part.numTriangles > _maxTriangles && part.numGroups > 1;
            group += part.numGroups;
            parts.push_back(part);
        }
        AddParts(parts);
    }

private:
    /// Groups that lie in some cells.
    struct Part {
        const std::uint32_t* groups = nullptr;
        std::size_t numGroups = 0;
        Bounds bounds;
        std::uint64_t numTriangles = 0;
        bool isTooLarge = false; ///< for a chunk: a cell that is planned by itself
    };

    /// Appends chunks of parts, so many parts at a time: plans of large ones are made side by side.
    void AddParts(const std::vector<Part>& parts) {
        constexpr std::size_t kAtOnce = 256;
        std::vector<ChunkPlan> plans(std::min(parts.size(), kAtOnce));
        for (std::size_t begin = 0; begin < parts.size(); begin += kAtOnce) {
            const std::size_t end = std::min(begin + kAtOnce, parts.size());
            tbb::parallel_for(begin, end, [&](std::size_t i) {
                const Part& part = parts[i];
                if (part.isTooLarge) {
                    ChunkPlan& plan = plans[i - begin];
                    plan = {};
                    // A thread that waits inside takes no other part meanwhile: each has a grid.
                    tbb::this_task_arena::isolate([&] {
                        Planner(_source, _maxTriangles, &plan)
                            .Plan({part.groups, part.groups + part.numGroups}, part.bounds,
                                  part.numTriangles);
                    });
                }
            });
            for (std::size_t i = begin; i < end; ++i) {
                const Part& part = parts[i];
                if (part.isTooLarge) {
                    Append(plans[i - begin]);
                } else {
                    AddChunk(part.groups, part.numGroups, part.bounds, part.numTriangles);
                }
            }
        }
    }

    /// The chunks of another plan come next. \pre it has no end of its last one yet.
    void Append(const ChunkPlan& plan) {
        const auto first = static_cast<std::uint32_t>(_plan.groups.size());
        for (const std::uint32_t begin : plan.begin) {
            _plan.begin.push_back(first + begin);
        }
        _plan.groups.insert(_plan.groups.end(), plan.groups.begin(), plan.groups.end());
        _plan.bounds.insert(_plan.bounds.end(), plan.bounds.begin(), plan.bounds.end());
        _plan.counts.insert(_plan.counts.end(), plan.counts.begin(), plan.counts.end());
    }

    void AddChunk(const std::uint32_t* groups, std::size_t count, const Bounds& bounds,
                  std::uint64_t numTriangles) {
        _plan.begin.push_back(static_cast<std::uint32_t>(_plan.groups.size()));
        _plan.groups.insert(_plan.groups.end(), groups, groups + count);
        _plan.bounds.push_back(bounds);
        _plan.counts.push_back(static_cast<std::uint32_t>(numTriangles));
    }

    void CutByOrder(const std::vector<std::uint32_t>& groups) {
        std::size_t first = 0;
        std::uint64_t numTriangles = 0;
        Bounds box;
        for (std::size_t i = 0; i < groups.size(); ++i) {
            const std::uint32_t added = _source.GroupTriangles(groups[i]);
            if (i > first && numTriangles + added > _maxTriangles) {
                AddChunk(groups.data() + first, i - first, box, numTriangles);
                first = i;
                numTriangles = 0;
                box = {};
            }
            const Bounds bounds = _source.GroupBounds(groups[i]);
            box.min = glm::min(box.min, bounds.min);
            box.max = glm::max(box.max, bounds.max);
            numTriangles += added;
        }
        AddChunk(groups.data() + first, groups.size() - first, box, numTriangles);
    }

    /// Reorders cells[begin, end) so that chunks are contiguous; appends where they end.
    void CutCells(Cells& cells, std::size_t begin, std::size_t end, const glm::dvec3& cellSize,
                  std::vector<std::size_t>* ends) {
        std::uint64_t weight = 0;
        for (std::size_t i = begin; i < end; ++i) {
            weight += cells[i].numTriangles;
        }
        if (weight <= _maxTriangles || end - begin == 1) {
            ends->push_back(end);
            return;
        }
        const auto first = cells.begin() + static_cast<std::ptrdiff_t>(begin);
        const auto last = cells.begin() + static_cast<std::ptrdiff_t>(end);
        const Cut cut = FindCut({first, last}, weight, cellSize);
        const auto middle = std::stable_partition(
            first, last, [&](const GridCell& cell) { return cell.at[cut.axis] < cut.plane; });
        const auto split = static_cast<std::size_t>(middle - cells.begin());
        CutCells(cells, begin, split, cellSize, ends);
        CutCells(cells, split, end, cellSize, ends);
    }

    /// The plane between slices of cells with the least sum of weight times area; a side with less
    /// than a quarter of a chunk is avoided where it can be.
    Cut FindCut(CellRange range, std::uint64_t weight, const glm::dvec3& cellSize) const {
        CellBox all;
        for (auto cell = range.first; cell != range.second; ++cell) {
            all.Grow(*cell);
        }
        Cut best;
        double bestCost = std::numeric_limits<double>::infinity();
        for (int axis = 0; axis < 3; ++axis) {
            const std::uint32_t low = all.low[axis];
            const std::size_t numSlices = all.high[axis] - low + 1;
            std::vector<std::uint64_t> weights(numSlices, 0);
            std::vector<CellBox> boxes(numSlices);
            for (auto cell = range.first; cell != range.second; ++cell) {
                weights[cell->at[axis] - low] += cell->numTriangles;
                boxes[cell->at[axis] - low].Grow(*cell);
            }
            std::vector<double> rightAreas(numSlices);
            CellBox right;
            for (std::size_t i = numSlices; i-- > 1;) {
                right.Grow(boxes[i]);
                rightAreas[i] = right.HalfArea(cellSize);
            }
            CellBox left;
            std::uint64_t leftWeight = 0;
            for (std::size_t i = 1; i < numSlices; ++i) {
                left.Grow(boxes[i - 1]);
                leftWeight += weights[i - 1];
                const std::uint64_t rightWeight = weight - leftWeight;
                double cost = static_cast<double>(leftWeight) * left.HalfArea(cellSize) +
                              static_cast<double>(rightWeight) * rightAreas[i];
                if (std::min(leftWeight, rightWeight) < _maxTriangles / 4) {
                    cost +=
                        kSmallSidePenalty * static_cast<double>(weight) * all.HalfArea(cellSize);
                }
                if (cost < bestCost) {
                    bestCost = cost;
                    best = {axis, low + static_cast<std::uint32_t>(i)};
                }
            }
        }
        return best;
    }

    /// Above any sum of weight times area.
    static constexpr double kSmallSidePenalty = 4.0;

    const PrimitiveGroups& _source;
    std::uint32_t _maxTriangles;
    ChunkPlan& _plan;
};

std::vector<std::uint32_t> DrawnGroups(const PrimitiveGroups& source) {
    std::vector<std::uint32_t> groups;
    groups.reserve(source.NumPrimitiveGroups());
    for (std::uint32_t group = 0; group < source.NumPrimitiveGroups(); ++group) {
        if (source.GroupTriangles(group) > 0) {
            groups.push_back(group);
        }
    }
    return groups;
}

} // namespace

ChunkPlan PlanChunks(const PrimitiveGroups& source, std::uint32_t maxTriangles,
                     std::uint32_t maxVertices) {
    HDS_VERIFY(maxTriangles > 0 && maxVertices >= 3, std::to_string(maxTriangles));
    if (source.NumVertices() > maxVertices) {
        maxTriangles = std::min(maxTriangles, maxVertices / 3);
    }
    ChunkPlan plan;
    std::vector<std::uint32_t> groups = DrawnGroups(source);
    if (groups.empty()) {
        return plan;
    }
    if (source.NumTriangles() <= maxTriangles) {
        plan.begin = {0};
        plan.bounds = {source.AllBounds()};
        plan.counts = {static_cast<std::uint32_t>(source.NumTriangles())};
        plan.groups = std::move(groups);
    } else {
        plan.groups.reserve(groups.size());
        Planner(source, maxTriangles, &plan)
            .Plan(std::move(groups), source.AllBounds(), source.NumTriangles());
    }
    plan.begin.push_back(static_cast<std::uint32_t>(plan.groups.size()));
    return plan;
}

} // namespace hds
