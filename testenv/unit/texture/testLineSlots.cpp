// SPDX-License-Identifier: Apache-2.0
// Where lines go in a pool: in their set, else in the overflow; what is in use stays.
#include "hdStream/texture/lineSlots.h"
#include "kernels/shared/compat.h"

#include <gtest/gtest.h>

#include <random>
#include <set>

namespace hds::test {
namespace {

TEST(SlotPlan, UsesAllSlotsAndHoldsOneItem) {
    for (std::uint32_t linesPerItem = 1; linesPerItem <= 200; linesPerItem += 13) {
        const std::uint32_t fewest = FewestSlots(linesPerItem);
        for (std::uint32_t numSlots = fewest; numSlots < 5000; numSlots += 1 + numSlots / 7) {
            for (const std::uint32_t numPinned : {0U, 10U, 10000U}) {
                const SlotPlan plan = MakeSlotPlan(numSlots, linesPerItem, numPinned);
                EXPECT_EQ(plan.NumSlots(), numSlots);
                EXPECT_GE(plan.numSets, 1U);
                EXPECT_LE(plan.numPinned, numPinned);
                EXPECT_LE(plan.numPinned, numSlots / 4);
                // Even when all of its lines fall into one set.
                EXPECT_GE(plan.numOverflow + SlotPlan::kWays, linesPerItem) << numSlots;
            }
        }
    }
}

TEST(SlotPlan, EnoughSlotsHoldConsecutiveLinesWithoutConflict) {
    for (const std::uint32_t maxLines : {1U, 8U, 100U, 1234U, 20000U}) {
        const std::uint64_t numSlots = EnoughSlots(maxLines, 16, 128);
        LineSlots slots(MakeSlotPlan(static_cast<std::uint32_t>(numSlots), 16, 128));
        for (std::uint32_t line = 0; line < maxLines; ++line) {
            const auto placement = slots.Place(line, 1, []() -> const std::uint32_t* { throw 1; });
            ASSERT_NE(placement.slot, HDS_NONE);
            ASSERT_EQ(placement.evicted, HDS_NONE);
        }
    }
}

TEST(LineSlots, MostUsedIsAHighWaterMark) {
    LineSlots slots(SlotPlan{2, 1, 1});
    std::vector<std::uint32_t> stamps(11, 0);
    const auto place = [&](std::uint32_t line, std::uint32_t epoch) {
        return slots.Place(line, epoch, [&] { return stamps.data(); }).slot;
    };
    EXPECT_EQ(slots.MostUsed(), 0U);
    const std::uint32_t first = place(1, 1);
    const std::uint32_t second = place(2, 1);
    slots.PlacePinned(3);
    EXPECT_EQ(slots.MostUsed(), 3U);
    slots.Free(first);
    slots.Free(second);
    place(4, 1);
    EXPECT_EQ(slots.NumUsed(), 2U);
    EXPECT_EQ(slots.MostUsed(), 3U) << "it does not fall";
    slots.BeginMost();
    EXPECT_EQ(slots.MostUsed(), 2U) << "but begins with what is there";
    for (std::uint32_t line = 10; line < 40; ++line) {
        place(line, line); // each makes another one leave once all ways are in use
    }
    EXPECT_EQ(slots.MostUsed(), 9U);
}

TEST(LineSlots, ThoseOfASecondPartCountOnFromTheFirst) {
    constexpr std::uint32_t kFirst = 100;
    LineSlots slots(SlotPlan{2, 1, 1}, kFirst);
    std::vector<std::uint32_t> stamps(kFirst + 11, 1);
    stamps[kFirst + 5] = 0; // used least recently
    const auto place = [&](std::uint32_t line, std::uint32_t epoch) {
        return slots.Place(line, epoch, [&] { return stamps.data(); });
    };
    std::set<std::uint32_t> used = {slots.PlacePinned(50)};
    for (std::uint32_t line = 0; line < 8; ++line) {
        used.insert(place(line, 1).slot);
    }
    EXPECT_EQ(*used.begin(), kFirst + 2) << "the overflow comes first";
    EXPECT_EQ(*used.rbegin(), kFirst + 10);
    EXPECT_EQ(used.size(), 9U);
    stamps.assign(stamps.size(), 7);
    stamps[kFirst + 5] = 6;
    const LineSlots::Placement placement = place(20, 8);
    EXPECT_EQ(placement.slot, kFirst + 5);
    EXPECT_EQ(placement.evicted, 3U);
    EXPECT_EQ(slots.Line(kFirst + 5), 20U);
    slots.Free(kFirst + 5);
    EXPECT_EQ(slots.Line(kFirst + 5), HDS_NONE);
}

TEST(LineSlots, LinesLieTogetherInTheOrderInWhichTheyCame) {
    LineSlots slots(SlotPlan{2, 5, 1});
    const auto place = [&](std::uint32_t line) {
        const auto placement = slots.Place(line, 1, []() -> const std::uint32_t* { throw 1; });
        EXPECT_EQ(placement.evicted, HDS_NONE);
        return placement.slot;
    };
    for (std::uint32_t i = 0; i < 40; ++i) {
        EXPECT_EQ(place(1000 + 5 * i), 2 + i) << "also those of one set";
    }
    slots.Free(20);
    slots.Free(7);
    EXPECT_EQ(place(3), 7U);
    EXPECT_EQ(place(8), 20U) << "what was freed is taken first";
}

class OneSet : public ::testing::Test {
protected:
    LineSlots::Placement Place(std::uint32_t line, std::uint32_t epoch) {
        return slots.Place(line, epoch, [this] { return stamps.data(); });
    }

    LineSlots slots{SlotPlan{2, 1, 1}}; ///< 2 of overflow, 8 ways, 1 pinned
    std::vector<std::uint32_t> stamps = std::vector<std::uint32_t>(11, 0);
};

TEST_F(OneSet, TheLeastRecentlyUsedLeaves) {
    for (std::uint32_t line = 0; line < 8; ++line) {
        EXPECT_EQ(Place(100 + line, 1).evicted, HDS_NONE);
    }
    for (std::uint32_t slot = 2; slot < 10; ++slot) {
        stamps[slot] = 20 - slot; // the last one longest ago
    }
    const LineSlots::Placement placement = Place(200, 30);
    EXPECT_EQ(placement.slot, 9U);
    EXPECT_EQ(placement.evicted, 107U);
    EXPECT_FALSE(placement.isConflict);
    EXPECT_EQ(Place(201, 30).slot, 8U);
    EXPECT_EQ(slots.NumUsed(), 8U);
}

TEST_F(OneSet, WhatIsInUseStaysAndOthersGoToTheOverflow) {
    std::set<std::uint32_t> taken;
    for (std::uint32_t line = 0; line < 8; ++line) {
        taken.insert(Place(line, 1).slot);
    }
    for (std::uint32_t slot = 2; slot < 10; ++slot) {
        stamps[slot] = 5;
    }
    for (std::uint32_t line = 8; line < 10; ++line) {
        const LineSlots::Placement placement = Place(line, 5);
        EXPECT_TRUE(placement.isConflict);
        EXPECT_LT(placement.slot, 2U);
        taken.insert(placement.slot);
    }
    EXPECT_EQ(taken.size(), 10U);
    const LineSlots::Placement denied = Place(10, 5);
    EXPECT_EQ(denied.slot, HDS_NONE);
    EXPECT_TRUE(denied.isConflict);
    stamps[4] = 4; // no longer in use
    EXPECT_EQ(Place(10, 5).slot, 4U);
    EXPECT_EQ(Place(11, 5).slot, HDS_NONE) << "what was placed just now stays as well";
    EXPECT_NE(Place(11, 6).slot, HDS_NONE) << "but not in the next epoch";
}

TEST_F(OneSet, WhatWasUsedAgainStaysLonger) {
    for (std::uint32_t line = 0; line < 8; ++line) {
        Place(line, 100);
    }
    for (std::uint32_t slot = 2; slot < 10; ++slot) {
        stamps[slot] = 102; // used again, just after those that each was loaded for
    }
    stamps[6] = 101; // by those alone
    EXPECT_EQ(Place(20, 150).evicted, 4U) << "not used for 49 epochs, which count four times";
    stamps[6] = 151;
    EXPECT_EQ(Place(21, 200).evicted, 20U) << "before what was not used for 98 epochs";
    stamps[6] = 201;
    EXPECT_NE(Place(22, 205).slot, 6U) << "what has come just now stays";
}

TEST_F(OneSet, EpochsMayBeginAnew) {
    for (std::uint32_t line = 0; line < 8; ++line) {
        Place(line, 0xfffffff0U);
        stamps[2 + line] = 0xfffffff0U + line;
    }
    stamps[5] = 2; // used after the count began anew
    EXPECT_EQ(Place(8, 3).evicted, 0U);
    EXPECT_EQ(Place(9, 3).evicted, 1U);
}

TEST_F(OneSet, PinnedSlotsAreFreedOnlyByName) {
    EXPECT_EQ(slots.PlacePinned(77), 10U);
    EXPECT_EQ(slots.PlacePinned(78), HDS_NONE);
    for (std::uint32_t line = 0; line < 40; ++line) {
        Place(line, line + 1);
    }
    EXPECT_EQ(slots.Line(10), 77U);
    EXPECT_EQ(slots.NumPinned(), 1U);
    slots.Free(10);
    EXPECT_EQ(slots.PlacePinned(78), 10U);
}

} // namespace
} // namespace hds::test
