// SPDX-License-Identifier: Apache-2.0
// What a streaming pool does for the whole of a render: it counts what is used, and becomes
// resident when it holds everything.
#include "hdStream/base/error.h"
#include "hdStream/stream/streamingPool.h"

#include <algorithm>

namespace hds {

void StreamingPool::BeginStatistics() {
    _statistics = {};
    _peakUsedBytes = _ranges.UsedBytes(_bytes);
    for (PageState& page : _pages) {
        page.wasLoaded = false;
        page.wasUsed = false;
    }
    if (_useTable.IsValid()) {
        BeginEpoch();
        _firstEpoch = _epoch;
    }
}

void StreamingPool::CountUsed() {
    ReadUses();
    for (std::uint32_t page = 0; page < _pages.size(); ++page) {
        if (WasUsed(page)) {
            CountGroup(page);
        }
    }
}

/// Whether a page is resident and was used since BeginStatistics, as far as uses have been read.
bool StreamingPool::WasUsed(std::uint32_t page) const {
    return IsResident(page) && _uses[page] >= _firstEpoch;
}

/// Counts the group of a page that is used, once.
void StreamingPool::CountGroup(std::uint32_t page) {
    PageState& first = _pages[page / kGroupPages * kGroupPages];
    _statistics.chunksUsed += first.wasUsed ? 0 : 1;
    first.wasUsed = true;
}

std::uint64_t StreamingPool::MissingBytes() const {
    std::uint64_t bytes = 0;
    for (std::uint32_t page = 0; page < _pages.size(); ++page) {
        bytes += IsResident(page) ? 0 : _provider->PageBytes(page);
    }
    return bytes;
}

bool StreamingPool::HasRoomForAll() const {
    std::uint64_t bytes = 0;
    for (std::uint32_t page = 0; page < _pages.size(); ++page) {
        bytes += _provider->PageBytes(page);
    }
    return bytes <= _bytes;
}

bool StreamingPool::LoadMissing(std::uint64_t bytes) {
    std::vector<std::uint32_t> batch;
    for (std::uint32_t page = 0; page < _pages.size() && bytes > 0; ++page) {
        if (!IsResident(page) && _provider->PageBytes(page) > 0) {
            batch.push_back(page);
            bytes -= std::min(bytes, _provider->PageBytes(page));
        }
    }
    Prepare(batch);
    ReadUses();
    bool hasRoom = true;
    for (const std::uint32_t page : batch) {
        PageState& state = _pages[page];
        hasRoom = hasRoom && _ranges.Allocate(state.bytes, state.isPinned, &state.range);
        if (hasRoom) {
            _uses[page] = 0; // who asked for it has it
            _queued.push_back(page);
        }
    }
    LoadQueued(false);
    PublishUses();
    return hasRoom;
}

void StreamingPool::Settle() {
    HDS_VERIFY(MissingBytes() == 0, _label);
    BeginCast(); // no word says "done"
    for (std::uint32_t page = 0; page < _pages.size(); ++page) {
        _provider->Drop(page);
    }
}

} // namespace hds
