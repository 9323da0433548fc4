// SPDX-License-Identifier: Apache-2.0
// Where pages lie in the buffers of a pool: free ranges, best fit.
#pragma once

#include "kernels/shared/residency.h"

#include <array>
#include <cstdint>
#include <map>
#include <set>
#include <utility>

namespace hds {

/// Most pool buffers in a kernel's signature, and the most bytes of one.
constexpr std::uint32_t kMaxPoolBuffers = HDS_POOL_MAX_BUFFERS;
constexpr std::uint64_t kMaxPoolBufferBytes = std::uint64_t{HDS_POOL_UNIT_BYTES}
                                              << HDS_POOL_BUFFER_SHIFT;

/// A range of one of the buffers, in bytes.
struct PoolRange {
    std::uint32_t buffer = 0;
    std::uint64_t offset = 0;
    std::uint64_t bytes = 0;

    /// Its word in the residency table.
    std::uint32_t Address() const {
        return (buffer << HDS_POOL_BUFFER_SHIFT) |
               static_cast<std::uint32_t>(offset / HDS_POOL_UNIT_BYTES);
    }
};

/// Keeps the free ranges of up to kMaxPoolBuffers buffers. All sizes are multiples of
/// HDS_POOL_UNIT_BYTES. Externally synchronised.
class RangeAllocator {
public:
    /// Adds a buffer, all of it free. Precondition: there are fewer than kMaxPoolBuffers.
    void AddBuffer(std::uint64_t bytes);
    std::uint32_t NumBuffers() const { return _numBuffers; }

    /// The shortest free range of the first buffer that has one large enough; O(log ranges).
    /// \return false when there is none.
    bool Allocate(std::uint64_t bytes, PoolRange* range);
    /// Gives a range back; neighbours become one.
    void Free(const PoolRange& range);

    std::uint64_t FreeBytes() const { return _freeBytes; }
    /// The longest free range; with FreeBytes it tells how scattered the pool is.
    std::uint64_t LargestFreeRange() const;

private:
    /// Free ranges of a buffer, twice.
    struct FreeRanges {
        std::map<std::uint64_t, std::uint64_t> byOffset;          ///< offset -> bytes
        std::set<std::pair<std::uint64_t, std::uint64_t>> bySize; ///< (bytes, offset)

        void Insert(std::uint64_t offset, std::uint64_t bytes);
        void Erase(std::uint64_t offset, std::uint64_t bytes);
    };

    std::array<FreeRanges, kMaxPoolBuffers> _free;
    std::uint32_t _numBuffers = 0;
    std::uint64_t _freeBytes = 0;
};

} // namespace hds
