// SPDX-License-Identifier: Apache-2.0
#include "hdStream/stream/evictionOrder.h"

#include <algorithm>
#include <functional>

namespace hds {

namespace {

/// As many pages of the same or a greater age are listed together.
constexpr std::uint32_t kVictimBatch = 512;

} // namespace

void EvictionOrder::Renumber(const std::vector<std::uint32_t>& previous) {
    RenumberPages(previous, &_pages);
}

void LastUseOrder::BeginRound() {
    EvictionOrder::BeginRound();
    _isCounted = false;
}

bool LastUseOrder::Next(const PageTable& table, const PageUses& uses,
                        std::vector<std::uint32_t>* pages) {
    pages->clear();
    if (!_isCounted) {
        CountAges(table, uses);
    }
    while (pages->empty()) {
        if (_victims.empty()) {
            if (_listedAge == 0) {
                return false;
            }
            ListVictims(table, uses);
            continue;
        }
        std::pop_heap(_victims.begin(), _victims.end(), std::greater<>());
        const std::uint32_t page = _victims.back().page;
        _victims.pop_back();
        if (!IsProtected(page) && table.HasPlace(page)) {
            pages->push_back(page);
        }
    }
    return true;
}

/// Counts by age what may leave in this round.
void LastUseOrder::CountAges(const PageTable& table, const PageUses& uses) {
    _isCounted = true;
    _victims.clear();
    _numByAge = {};
    _listedAge = kNumAges;
    for (std::uint32_t page = 0; page < table.NumPages(); ++page) {
        if (table.MayLeave(page)) {
            ++_numByAge[std::min(uses.Age(page), kNumAges - 1)];
        }
    }
}

/// Puts the next younger pages into the heap, as few of many leave: a heap of all would take longer
/// than what is left of the round.
void LastUseOrder::ListVictims(const PageTable& table, const PageUses& uses) {
    const std::uint32_t end = _listedAge;
    std::uint32_t count = 0;
    while (_listedAge > 0 && count < kVictimBatch) {
        count += _numByAge[--_listedAge];
    }
    for (std::uint32_t page = 0; count > 0 && page < table.NumPages(); ++page) {
        if (!table.MayLeave(page)) {
            continue;
        }
        const std::uint32_t age = std::min(uses.Age(page), kNumAges - 1);
        if (age >= _listedAge && age < end && !IsProtected(page)) {
            _victims.push_back({uses.Stamp(page), Wanted(page), page});
        }
    }
    std::make_heap(_victims.begin(), _victims.end(), std::greater<>());
}

} // namespace hds
