// SPDX-License-Identifier: Apache-2.0
// Local numbers for the points of a chunk. Internal to geometry.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

namespace hds {

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

} // namespace hds
