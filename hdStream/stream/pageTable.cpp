// SPDX-License-Identifier: Apache-2.0
#include "hdStream/stream/pageTable.h"

#include <unordered_map>

namespace hds {

std::vector<std::uint32_t> PageTable::Renumber(const std::vector<std::uint64_t>& ids) {
    std::unordered_map<std::uint64_t, std::uint32_t> known;
    for (std::uint32_t page = 0; page < NumPages(); ++page) {
        known.emplace(_ids[page], page);
    }
    std::vector<std::uint32_t> previous(ids.size(), kNoPage);
    std::vector<bool> isKept(_pages.size(), false);
    for (std::size_t page = 0; page < ids.size(); ++page) {
        const auto found = known.find(ids[page]);
        if (found != known.end()) {
            previous[page] = found->second;
            isKept[found->second] = true;
            known.erase(found); // of pages with one id the first has its place
        }
    }
    for (std::size_t page = 0; page < _pages.size(); ++page) {
        if (!isKept[page] && _pages[page].range.bytes > 0) {
            _placedBytes -= _pages[page].range.bytes;
            --_numPlaced;
            _ranges.Free(_pages[page].range);
        }
    }
    RenumberPages(previous, &_pages);
    _ids = ids;
    _words.assign(ids.size(), HDS_NOT_RESIDENT);
    for (std::uint32_t page = 0; page < NumPages(); ++page) {
        Publish(page);
    }
    return previous;
}

void PageTable::SetBuffers(const std::vector<std::uint64_t>& sizes, std::uint64_t pinnedBytes) {
    _ranges = {};
    _placedBytes = 0;
    _numPlaced = 0;
    for (const std::uint64_t size : sizes) {
        _ranges.AddBuffer(size);
    }
    _ranges.SetApart(pinnedBytes);
    for (Entry& entry : _pages) {
        entry.range = {};
    }
    _words.assign(_pages.size(), HDS_NOT_RESIDENT);
}

std::uint32_t PageTable::RemoveUnpinned() {
    std::uint32_t count = 0;
    for (std::uint32_t page = 0; page < NumPages(); ++page) {
        if (HasPlace(page) && !_pages[page].isPinned && _ranges.IsPinned(Place(page).Address())) {
            Remove(page);
            ++count;
        }
    }
    return count;
}

bool PageTable::FindPlace(std::uint32_t page, std::uint64_t bytes) {
    Entry& entry = _pages[page];
    if (!_ranges.Allocate(bytes, entry.isPinned, &entry.range)) {
        entry.range = {};
        return false;
    }
    _placedBytes += bytes;
    ++_numPlaced;
    return true;
}

void PageTable::Remove(std::uint32_t page) {
    _placedBytes -= _pages[page].range.bytes;
    --_numPlaced;
    _ranges.Free(_pages[page].range);
    _pages[page].range = {};
    _words[page] = HDS_NOT_RESIDENT;
}

void PageTable::Publish(std::uint32_t page) {
    _words[page] = HasPlace(page) ? Place(page).Address() : HDS_NOT_RESIDENT;
}

} // namespace hds
