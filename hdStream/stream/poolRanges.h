// SPDX-License-Identifier: Apache-2.0
// Where pages lie in the buffers of a pool of which a part is set apart for pinned pages, so that
// these never lie in the way of others. Explained in docs/streaming.md.
#pragma once

#include "hdStream/stream/rangeAllocator.h"

#include <cstdint>

namespace hds {

/// The free ranges of a pool's buffers. All sizes are multiples of HDS_POOL_UNIT_BYTES. Externally
/// synchronised.
class PoolRanges {
public:
    /// Adds a buffer, all of it free.
    void AddBuffer(std::uint64_t bytes) { _ranges.AddBuffer(bytes); }
    std::uint32_t NumBuffers() const { return _ranges.NumBuffers(); }

    /// Sets a part of the first buffer that has room apart; once, before anything is allocated.
    /// \pre a buffer has so many bytes.
    void SetApart(std::uint64_t bytes);
    /// Bytes of the part, and how many of them are allocated.
    std::uint64_t ApartBytes() const { return _apart.bytes; }
    std::uint64_t PinnedBytes() const { return _apart.bytes - _pinned.FreeBytes(); }
    /// Whether an address lies in the part.
    bool IsPinned(std::uint32_t address) const { return address - _apartAddress < _apartUnits; }

    /// \param isPinned in the part if there is room, else like all others.
    /// \return false when there is no room.
    bool Allocate(std::uint64_t bytes, bool isPinned, PoolRange* range);
    void Free(const PoolRange& range);

private:
    RangeAllocator _ranges;
    PoolRange _apart; ///< of _ranges
    std::uint32_t _apartAddress = 0;
    std::uint32_t _apartUnits = 0; ///< 0: nothing is set apart
    RangeAllocator _pinned;        ///< inside it
};

} // namespace hds
