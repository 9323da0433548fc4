// SPDX-License-Identifier: Apache-2.0
// What a streaming pool does for the whole of a render: it counts what is used, and becomes
// resident when it holds everything.
#include "hdStream/base/error.h"
#include "hdStream/stream/streamingPool.h"

#include <algorithm>

namespace hds {

void StreamingPool::BeginStatistics() {
    _counters.Begin();
    if (_useTable.IsValid()) {
        BeginEpoch();
        _uses.BeginStatistics();
    }
}

void StreamingPool::CountUsed() {
    ReadUses();
    for (std::uint32_t page = 0; page < _table.NumPages(); ++page) {
        if (_table.HasPlace(page) && _uses.WasUsed(page)) {
            _counters.CountUse(page);
        }
    }
}

std::uint64_t StreamingPool::MissingBytes() const {
    std::uint64_t bytes = 0;
    for (std::uint32_t page = 0; page < _table.NumPages(); ++page) {
        bytes += _table.HasPlace(page) ? 0 : _provider->PageBytes(page);
    }
    return bytes;
}

bool StreamingPool::HasRoomForAll() const {
    std::uint64_t bytes = 0;
    for (std::uint32_t page = 0; page < _table.NumPages(); ++page) {
        bytes += _provider->PageBytes(page);
    }
    return bytes <= _bytes && (!_hash || _table.NumPages() <= _hash->MostPages());
}

bool StreamingPool::LoadMissing(std::uint64_t bytes) {
    std::vector<std::uint32_t> batch;
    for (std::uint32_t page = 0; page < _table.NumPages() && bytes > 0; ++page) {
        if (!_table.HasPlace(page) && _provider->PageBytes(page) > 0) {
            batch.push_back(page);
            bytes -= std::min(bytes, _provider->PageBytes(page));
        }
    }
    Prepare(batch);
    ReadUses();
    bool hasRoom = true;
    for (const std::uint32_t page : batch) {
        hasRoom = hasRoom && _table.FindPlace(page, _pageBytes[page]);
        if (hasRoom) {
            _uses.Clear(page); // who asked for it has it
            _queued.push_back(page);
        }
    }
    LoadQueued(false);
    PublishUses();
    return hasRoom;
}

void StreamingPool::MakeResident(bool keepsBytes) {
    HDS_VERIFY(MissingBytes() == 0, _label);
    BeginEpoch();
    for (std::uint32_t page = 0; page < _table.NumPages() && !keepsBytes; ++page) {
        _provider->Drop(page);
    }
}

} // namespace hds
