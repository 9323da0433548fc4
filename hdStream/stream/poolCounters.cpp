// SPDX-License-Identifier: Apache-2.0
#include "hdStream/stream/poolCounters.h"

#include "hdStream/stream/pageUses.h"

namespace hds {

void PoolCounters::Renumber(const std::vector<std::uint32_t>& previous) {
    RenumberPages(previous, &_pages);
}

void PoolCounters::Begin() {
    _statistics = {};
    _pages.assign(_pages.size(), {});
    _held.BeginPeak();
}

void PoolCounters::CountLoad(std::uint32_t page, std::uint64_t bytes, bool isAskedFor) {
    _statistics.uploadedBytes += bytes;
    ++_statistics.uploads;
    _statistics.uniqueBytes += _pages[page].wasLoaded ? 0 : bytes;
    _pages[page].wasLoaded = true;
    if (isAskedFor) {
        CountUse(page);
    }
}

void PoolCounters::CountUse(std::uint32_t page) {
    State& first = _pages[FirstOfGroup(page)];
    _statistics.chunksUsed += first.wasUsed ? 0 : 1;
    first.wasUsed = true;
}

} // namespace hds
