// SPDX-License-Identifier: Apache-2.0
#include "hdStream/texture/lineSlots.h"

#include "hdStream/base/error.h"
#include "kernels/shared/compat.h"

#include <algorithm>
#include <string>

namespace hds {

namespace {

/// Overflow of pools that are large beside an item's lines: fewer conflicts for 32 KiB.
constexpr std::uint32_t kOverflow = 64;
constexpr std::uint32_t kOverflowDivisor = 16;
constexpr std::uint32_t kPinnedDivisor = 4;
/// Times that a line counts as older which only those have read that it was loaded for: many of
/// these are not read again before they leave.
constexpr std::uint32_t kAgeOfFirstUse = 4;

} // namespace

std::uint32_t FewestSlots(std::uint32_t linesPerItem) {
    return std::max(linesPerItem, SlotPlan::kWays);
}

std::uint64_t EnoughSlots(std::uint64_t maxLines, std::uint32_t linesPerItem,
                          std::uint32_t numPinned) {
    // Up to two sets are lost to rounding and one to an odd count.
    return maxLines + 3 * SlotPlan::kWays + FewestSlots(linesPerItem) + kOverflow + numPinned;
}

SlotPlan MakeSlotPlan(std::uint32_t numSlots, std::uint32_t linesPerItem, std::uint32_t numPinned) {
    const std::uint32_t fewest = FewestSlots(linesPerItem);
    HDS_VERIFY(numSlots >= fewest, "texture pool smaller than an item's lines");
    SlotPlan plan;
    plan.numPinned = std::min(numPinned, (numSlots - fewest) / kPinnedDivisor);
    const std::uint32_t rest = numSlots - plan.numPinned;
    // One set can always be used whole; what an item needs beyond must find room beside the sets.
    const std::uint32_t overflow =
        std::max(fewest - SlotPlan::kWays, std::min(kOverflow, rest / kOverflowDivisor));
    plan.numSets = (rest - overflow) / SlotPlan::kWays;
    // Lines go to sets by their number: an odd count keeps columns of images, whose lines are a
    // power of two apart, from falling into a few.
    plan.numSets -= plan.numSets > 2 && plan.numSets % 2 == 0 ? 1 : 0;
    plan.numOverflow = rest - SlotPlan::kWays * plan.numSets;
    return plan;
}

LineSlots::LineSlots(const SlotPlan& plan, std::uint32_t firstSlot)
    : _plan(plan), _firstSlot(firstSlot), _lines(plan.NumSlots(), HDS_NONE),
      _placedIn(plan.NumSlots(), 0), _firstUnused(plan.numOverflow) {
    for (std::uint32_t i = 0; i < plan.numPinned; ++i) {
        _freePinned.push_back(plan.NumSlots() - 1 - i);
    }
}

/// A slot that was empty is in use.
void LineSlots::CountPlaced() {
    _mostUsed = std::max(_mostUsed, ++_numUsed);
}

/// An empty slot of any set, or HDS_NONE.
std::uint32_t LineSlots::TakeEmptyOfSets() {
    if (!_freed.empty()) {
        const std::uint32_t slot = _freed.back();
        _freed.pop_back();
        return slot;
    }
    return _firstUnused < EndOfSets() ? _firstUnused++ : HDS_NONE;
}

std::uint32_t LineSlots::FindEmpty(std::uint32_t begin, std::uint32_t end) const {
    const auto found = std::find(_lines.begin() + begin, _lines.begin() + end, HDS_NONE);
    return found == _lines.begin() + end ? HDS_NONE
                                         : static_cast<std::uint32_t>(found - _lines.begin());
}

/// The slot of [begin, end) that was used least recently, or HDS_NONE when all are in use; one that
/// was not used again since it was placed counts as older. Ages count back from `epoch`, which may
/// have begun anew.
std::uint32_t LineSlots::FindOldest(std::uint32_t begin, std::uint32_t end, std::uint32_t epoch,
                                    const std::uint32_t* stamps) const {
    std::uint32_t oldest = HDS_NONE;
    std::uint64_t oldestAge = 0;
    for (std::uint32_t slot = begin; slot < end; ++slot) {
        const std::uint32_t stamp = stamps[_firstSlot + slot];
        const std::uint32_t sinceUse = std::min(epoch - stamp, epoch - _placedIn[slot]);
        // Who has asked for a line reads it in the epoch after that in which it was placed.
        const bool wasUsedAgain = stamp - _placedIn[slot] - 2 < epoch - _placedIn[slot];
        const std::uint64_t age = std::uint64_t{sinceUse} * (wasUsedAgain ? 1 : kAgeOfFirstUse);
        if (age > oldestAge) {
            oldest = slot;
            oldestAge = age;
        }
    }
    return oldest;
}

LineSlots::Placement LineSlots::Place(std::uint32_t line, std::uint32_t epoch,
                                      const ReadStamps& readStamps) {
    Placement placement{TakeEmptyOfSets(), HDS_NONE, false};
    if (placement.slot == HDS_NONE) {
        const std::uint32_t* stamps = readStamps();
        const std::uint32_t begin = _plan.numOverflow + line % _plan.numSets * SlotPlan::kWays;
        placement.slot = FindOldest(begin, begin + SlotPlan::kWays, epoch, stamps);
        if (placement.slot == HDS_NONE) {
            placement.isConflict = true;
            placement.slot = FindEmpty(0, _plan.numOverflow);
        }
        if (placement.slot == HDS_NONE) {
            placement.slot = FindOldest(0, _plan.numOverflow, epoch, stamps);
        }
    }
    if (placement.slot != HDS_NONE) {
        placement.evicted = _lines[placement.slot];
        if (placement.evicted == HDS_NONE) {
            CountPlaced();
        }
        _lines[placement.slot] = line;
        _placedIn[placement.slot] = epoch;
        placement.slot += _firstSlot;
    }
    return placement;
}

std::uint32_t LineSlots::PlacePinned(std::uint32_t line) {
    if (_freePinned.empty()) {
        return HDS_NONE;
    }
    const std::uint32_t slot = _freePinned.back();
    _freePinned.pop_back();
    CountPlaced();
    _lines[slot] = line;
    return _firstSlot + slot;
}

void LineSlots::Free(std::uint32_t number) {
    const std::uint32_t slot = number - _firstSlot;
    HDS_VERIFY(_lines[slot] != HDS_NONE, "slot " + std::to_string(number) + " is empty");
    _lines[slot] = HDS_NONE;
    --_numUsed;
    if (slot >= EndOfSets()) {
        _freePinned.push_back(slot);
    } else if (slot >= _plan.numOverflow) {
        _freed.push_back(slot);
    }
}

} // namespace hds
