// SPDX-License-Identifier: Apache-2.0
#include "hdStream/stream/rangeAllocator.h"

#include "hdStream/base/error.h"

#include <algorithm>
#include <string>

namespace hds {

void RangeAllocator::FreeRanges::Insert(std::uint64_t offset, std::uint64_t bytes) {
    byOffset[offset] = bytes;
    bySize.emplace(bytes, offset);
}

void RangeAllocator::FreeRanges::Erase(std::uint64_t offset, std::uint64_t bytes) {
    byOffset.erase(offset);
    bySize.erase({bytes, offset});
}

void RangeAllocator::AddBuffer(std::uint64_t bytes) {
    HDS_VERIFY(_numBuffers < kMaxPoolBuffers && bytes <= kMaxPoolBufferBytes,
               std::to_string(bytes) + " bytes");
    if (bytes > 0) {
        _free[_numBuffers].Insert(0, bytes);
    }
    ++_numBuffers;
    _freeBytes += bytes;
}

bool RangeAllocator::Allocate(std::uint64_t bytes, PoolRange* range) {
    for (std::uint32_t buffer = 0; buffer < _numBuffers; ++buffer) {
        FreeRanges& ranges = _free[buffer];
        const auto found = ranges.bySize.lower_bound({bytes, 0});
        if (found == ranges.bySize.end()) {
            continue;
        }
        const auto [length, offset] = *found;
        ranges.Erase(offset, length);
        if (length > bytes) {
            ranges.Insert(offset + bytes, length - bytes);
        }
        *range = {buffer, offset, bytes};
        _freeBytes -= bytes;
        return true;
    }
    return false;
}

void RangeAllocator::Free(const PoolRange& range) {
    FreeRanges& ranges = _free[range.buffer];
    std::uint64_t begin = range.offset;
    std::uint64_t end = range.offset + range.bytes;
    const auto next = ranges.byOffset.lower_bound(begin);
    if (next != ranges.byOffset.begin()) {
        const auto [offset, bytes] = *std::prev(next);
        if (offset + bytes == begin) {
            begin = offset;
            ranges.Erase(offset, bytes);
        }
    }
    const auto after = ranges.byOffset.find(end);
    if (after != ranges.byOffset.end()) {
        const auto [offset, bytes] = *after;
        end += bytes;
        ranges.Erase(offset, bytes);
    }
    ranges.Insert(begin, end - begin);
    _freeBytes += range.bytes;
}

std::uint64_t RangeAllocator::LargestFreeRange() const {
    std::uint64_t largest = 0;
    for (const FreeRanges& ranges : _free) {
        if (!ranges.bySize.empty()) {
            largest = std::max(largest, ranges.bySize.rbegin()->first);
        }
    }
    return largest;
}

} // namespace hds
