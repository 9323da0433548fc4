// SPDX-License-Identifier: Apache-2.0
#include "hdStream/stream/poolRanges.h"

#include "hdStream/base/error.h"

#include <string>

namespace hds {

void PoolRanges::SetApart(std::uint64_t bytes) {
    HDS_VERIFY(_apart.bytes == 0, "a part is set apart already");
    if (bytes == 0) {
        return;
    }
    HDS_VERIFY(_ranges.Allocate(bytes, &_apart), std::to_string(bytes) + " bytes");
    _apartAddress = _apart.Address();
    _apartUnits = static_cast<std::uint32_t>(bytes / HDS_POOL_UNIT_BYTES);
    _pinned.AddBuffer(bytes);
}

bool PoolRanges::Allocate(std::uint64_t bytes, bool isPinned, PoolRange* range) {
    if (isPinned && _pinned.Allocate(bytes, range)) {
        range->buffer = _apart.buffer;
        range->offset += _apart.offset;
        return true;
    }
    return _ranges.Allocate(bytes, range);
}

void PoolRanges::Free(const PoolRange& range) {
    if (IsPinned(range.Address())) {
        _pinned.Free({0, range.offset - _apart.offset, range.bytes});
    } else {
        _ranges.Free(range);
    }
}

} // namespace hds
