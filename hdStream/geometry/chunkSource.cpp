// SPDX-License-Identifier: Apache-2.0
#include "hdStream/base/error.h"
#include "hdStream/geometry/triangleMesh.h"

#include <algorithm>

namespace hds {
namespace {

/// Gives points local numbers in order of first use. Open addressing with linear probing; a table
/// of at least twice the number of points, so that runs stay short.
class PointNumbering {
public:
    /// \param maxPoints upper bound of the number of different points.
    explicit PointNumbering(std::size_t maxPoints) {
        std::size_t size = 16;
        while (size < maxPoints * 2) {
            size *= 2;
        }
        _slots.assign(size, {kFree, 0});
    }

    /// The local number of a point; `points` receives the points in order.
    std::uint32_t Number(std::uint32_t point, std::vector<std::uint32_t>& points) {
        const std::size_t mask = _slots.size() - 1;
        // Fibonacci hashing: the high bits of the product are mixed best.
        std::size_t slot = ((point * 0x9e3779b97f4a7c15ULL) >> 32) & mask;
        while (_slots[slot].point != kFree) {
            if (_slots[slot].point == point) {
                return _slots[slot].number;
            }
            slot = (slot + 1) & mask;
        }
        const auto number = static_cast<std::uint32_t>(points.size());
        _slots[slot] = {point, number};
        points.push_back(point);
        return number;
    }

private:
    static constexpr std::uint32_t kFree = 0xffffffffU; ///< no point: they are below 2^31
    struct Slot {
        std::uint32_t point;
        std::uint32_t number;
    };
    std::vector<Slot> _slots;
};

} // namespace

ChunkGeometry ChunkSource::Gather(const std::uint32_t* primIds, std::size_t count) const {
    ChunkGeometry chunk;
    chunk.primIds.assign(primIds, primIds + count);
    chunk.triangles.resize(count);
    const std::size_t maxPoints = std::min(count * 3, _mesh->positions.size());
    chunk.points.reserve(maxPoints);
    PointNumbering numbering(maxPoints);
    for (std::size_t i = 0; i < count; ++i) {
        HDS_VERIFY(primIds[i] < _mesh->triangles.size(),
                   "triangle " + std::to_string(primIds[i]) + " of " +
                       std::to_string(_mesh->triangles.size()));
        const glm::uvec3 triangle = _mesh->triangles[primIds[i]];
        for (int k = 0; k < 3; ++k) {
            chunk.triangles[i][k] = numbering.Number(triangle[k], chunk.points);
        }
    }
    chunk.points.shrink_to_fit();
    chunk.positions.reserve(chunk.points.size());
    for (const std::uint32_t point : chunk.points) {
        chunk.positions.push_back(_mesh->positions[point]);
    }
    return chunk;
}

} // namespace hds
