// SPDX-License-Identifier: Apache-2.0
// Words say where pages are from Publish on and no longer than they are there; edits keep the
// places of the pages that stay and free all others.
#include "hdStream/stream/pageTable.h"

#include <gtest/gtest.h>

#include <vector>

namespace hds::test {
namespace {

constexpr std::uint64_t kUnit = HDS_POOL_UNIT_BYTES;

/// A table of pages 0, 1, ... with these ids, over one buffer.
PageTable MakeTable(const std::vector<std::uint64_t>& ids, std::uint64_t units,
                    std::uint64_t pinnedUnits = 0) {
    PageTable table;
    table.Renumber(ids);
    table.SetBuffers({units * kUnit}, pinnedUnits * kUnit);
    return table;
}

TEST(PageTable, AWordTellsOfAPageOnceItIsPublished) {
    PageTable table = MakeTable({5, 6, 7}, 8);
    ASSERT_TRUE(table.FindPlace(1, 3 * kUnit));
    EXPECT_TRUE(table.HasPlace(1));
    EXPECT_EQ(table.PlacedBytes(), 3 * kUnit);
    EXPECT_EQ(table.Words()[1], HDS_NOT_RESIDENT);
    EXPECT_FALSE(table.MayLeave(1)) << "its bytes are still to come";
    table.Publish(1);
    EXPECT_EQ(table.Words()[1], table.Place(1).Address());
    EXPECT_TRUE(table.MayLeave(1));
    table.Remove(1);
    EXPECT_EQ(table.Words()[1], HDS_NOT_RESIDENT);
    EXPECT_FALSE(table.HasPlace(1) || table.MayLeave(1));
    EXPECT_EQ(table.PlacedBytes(), 0U);
    EXPECT_TRUE(table.FindPlace(0, 8 * kUnit)) << "all of the buffer is free again";
}

TEST(PageTable, WhatFindsNoPlaceHasNone) {
    PageTable table = MakeTable({5, 6}, 4);
    ASSERT_TRUE(table.FindPlace(0, 3 * kUnit));
    EXPECT_FALSE(table.FindPlace(1, 2 * kUnit));
    EXPECT_FALSE(table.HasPlace(1));
    EXPECT_EQ(table.PlacedBytes(), 3 * kUnit);
    table.Publish(1);
    EXPECT_EQ(table.Words()[1], HDS_NOT_RESIDENT);
}

TEST(PageTable, EditsKeepPlacesByIdAndFreeTheOthers) {
    PageTable table = MakeTable({10, 11, 12, 13}, 4);
    for (std::uint32_t page = 0; page < 4; ++page) {
        ASSERT_TRUE(table.FindPlace(page, kUnit));
        table.Publish(page);
    }
    const std::uint32_t wordOf11 = table.Words()[1];
    const std::uint32_t wordOf13 = table.Words()[3];
    const std::vector<std::uint32_t> previous = table.Renumber({13, 20, 11});
    EXPECT_EQ(previous, (std::vector<std::uint32_t>{3, PageTable::kNoPage, 1}));
    EXPECT_EQ(table.Words(), (std::vector<std::uint32_t>{wordOf13, HDS_NOT_RESIDENT, wordOf11}));
    EXPECT_EQ(table.PlacedBytes(), 2 * kUnit);
    EXPECT_FALSE(table.FindPlace(1, 3 * kUnit));
    ASSERT_TRUE(table.FindPlace(1, kUnit)) << "the places of pages 10 and 12 are free";
    std::vector<int> values{100, 101, 102, 103};
    RenumberPages(previous, &values);
    EXPECT_EQ(values, (std::vector<int>{103, 0, 101}));
}

/// Two pages of one scene may have the same bytes, so one id.
TEST(PageTable, NoPlaceIsLostWhenPagesShareAnId) {
    PageTable table = MakeTable({7, 7}, 2);
    ASSERT_TRUE(table.FindPlace(0, kUnit));
    ASSERT_TRUE(table.FindPlace(1, kUnit));
    table.Renumber({7, 8});
    EXPECT_EQ(table.PlacedBytes(), kUnit);
    ASSERT_TRUE(table.FindPlace(1, kUnit));
    table.Renumber({9});
    EXPECT_EQ(table.PlacedBytes(), 0U);
    EXPECT_TRUE(table.FindPlace(0, 2 * kUnit));
}

TEST(PageTable, PinnedPagesStayUntilTheyArePinnedNoMore) {
    PageTable table = MakeTable({1, 2, 3}, 8, 2);
    EXPECT_EQ(table.PinLimit(), 2 * kUnit);
    table.SetPinned(0, true);
    table.SetPinned(1, true);
    for (std::uint32_t page = 0; page < 3; ++page) {
        ASSERT_TRUE(table.FindPlace(page, kUnit));
        table.Publish(page);
        EXPECT_EQ(table.MayLeave(page), page == 2);
    }
    EXPECT_EQ(table.PinnedBytes(), 2 * kUnit);
    table.SetPinned(1, false);
    EXPECT_EQ(table.RemoveUnpinned(), 1U);
    EXPECT_TRUE(table.HasPlace(0) && !table.HasPlace(1) && table.HasPlace(2));
    EXPECT_EQ(table.Words()[1], HDS_NOT_RESIDENT);
    EXPECT_EQ(table.PinnedBytes(), kUnit);
}

TEST(PageTable, OtherBuffersHoldNothing) {
    PageTable table = MakeTable({1, 2}, 2);
    ASSERT_TRUE(table.FindPlace(0, kUnit));
    table.Publish(0);
    table.SetBuffers({kUnit, kUnit}, 0);
    EXPECT_EQ(table.NumBuffers(), 2U);
    EXPECT_EQ(table.PlacedBytes(), 0U);
    EXPECT_EQ(table.Words(), (std::vector<std::uint32_t>(2, HDS_NOT_RESIDENT)));
    ASSERT_TRUE(table.FindPlace(0, kUnit));
    ASSERT_TRUE(table.FindPlace(1, kUnit));
    EXPECT_EQ(table.Place(1).buffer, 1U);
}

} // namespace
} // namespace hds::test
