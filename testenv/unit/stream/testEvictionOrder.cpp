// SPDX-License-Identifier: Apache-2.0
// Pages leave in the order of their last use, whatever the number of pages; those that the present
// round needs and those that are pinned do not leave.
#include "hdStream/stream/evictionOrder.h"
#include "hdStream/stream/reportPool.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>
#include <tuple>
#include <vector>

namespace hds::test {
namespace {

constexpr std::uint64_t kUnit = HDS_POOL_UNIT_BYTES;
using Pages = std::vector<std::uint32_t>;

/// Pages that are all there, numbered from 0.
class EvictionOrderTest : public ::testing::Test {
protected:
    void Fill(EvictionOrder* order, std::uint32_t numPages, std::uint32_t numPinned = 0) {
        std::vector<std::uint64_t> ids;
        for (std::uint32_t page = 0; page < numPages; ++page) {
            ids.push_back(page + 1);
        }
        order->Renumber(table.Renumber(ids));
        table.SetBuffers({numPages * kUnit}, numPinned * kUnit);
        uses.Reset(numPages);
        for (std::uint32_t page = 0; page < numPages; ++page) {
            table.SetPinned(page, page < numPinned);
            ASSERT_TRUE(table.FindPlace(page, kUnit));
            table.Publish(page);
        }
        order->BeginRound();
    }
    void SetEpoch(std::uint32_t epoch) {
        while (uses.Epoch() < epoch) {
            uses.BeginEpoch();
        }
    }
    /// All pages in the order in which they leave.
    Pages Drain(EvictionOrder* order) {
        Pages left;
        Pages next;
        while (order->Next(table, uses, &next)) {
            for (const std::uint32_t page : next) {
                table.Remove(page);
                uses.Clear(page);
                left.push_back(page);
            }
        }
        return left;
    }

    PageTable table;
    PageUses uses;
};

TEST_F(EvictionOrderTest, TheLeastRecentlyUsedLeaveThenThoseLeastWanted) {
    LastUseOrder order;
    Fill(&order, 6);
    SetEpoch(9);
    uses.Words() = {8, 3, 8, 9, 3, 0};
    order.SetWanted(0, 5);
    order.SetWanted(2, 4);
    order.SetWanted(1, 1);
    order.SetWanted(4, 1);
    EXPECT_EQ(Drain(&order), (Pages{5, 1, 4, 2, 0, 3}));
}

TEST_F(EvictionOrderTest, WhatTheRoundNeedsStaysAsLongAsItLasts) {
    LastUseOrder order;
    Fill(&order, 4);
    SetEpoch(5);
    uses.Words() = {1, 2, 3, 4};
    order.Protect(0);
    Pages next;
    ASSERT_TRUE(order.Next(table, uses, &next));
    EXPECT_EQ(next, (Pages{1}));
    table.Remove(1);
    order.Protect(2); // after it was listed
    EXPECT_EQ(Drain(&order), (Pages{3}));
    order.BeginRound();
    EXPECT_EQ(Drain(&order), (Pages{0, 2}));
}

TEST_F(EvictionOrderTest, PinnedPagesStay) {
    LastUseOrder order;
    Fill(&order, 5, 2);
    SetEpoch(3);
    EXPECT_EQ(Drain(&order), (Pages{2, 3, 4}));
}

/// More pages than are listed at a time, of more ages than are told apart.
TEST_F(EvictionOrderTest, TheOrderIsExactForAnyNumberOfPages) {
    LastUseOrder order;
    const std::uint32_t numPages = 5000;
    Fill(&order, numPages);
    SetEpoch(700);
    std::mt19937 random(7);
    std::vector<std::tuple<std::uint32_t, std::uint32_t, std::uint32_t>> keys;
    for (std::uint32_t page = 0; page < numPages; ++page) {
        uses.Words()[page] = random() % 701;
        const std::uint32_t wanted = random() % 3;
        order.SetWanted(page, wanted);
        keys.emplace_back(uses.Stamp(page), wanted, page);
    }
    std::sort(keys.begin(), keys.end());
    Pages expected;
    for (const auto& key : keys) {
        expected.push_back(std::get<2>(key));
    }
    EXPECT_EQ(Drain(&order), expected);
}

TEST_F(EvictionOrderTest, EditsKeepWhatIsKnownOfPages) {
    LastUseOrder order;
    Fill(&order, 3);
    SetEpoch(2);
    order.SetWanted(0, 7);
    order.SetWanted(1, 2);
    order.SetWanted(2, 4);
    order.Renumber(table.Renumber({3, 1, 9})); // pages 2 and 0, and a new one
    uses.Reset(3);
    order.BeginRound();
    EXPECT_EQ(order.Wanted(0), 4U);
    EXPECT_EQ(order.Wanted(1), 7U);
    EXPECT_EQ(order.Wanted(2), 0U);
    EXPECT_EQ(Drain(&order), (Pages{0, 1}));
}

TEST_F(EvictionOrderTest, TheReportsOrderIsAllAtOnce) {
    FlushOrder order;
    EXPECT_FALSE(order.IsSelective());
    Fill(&order, 4);
    order.Protect(2);
    Pages next;
    ASSERT_TRUE(order.Next(table, uses, &next));
    EXPECT_EQ(next, (Pages{0, 1, 3}));
    for (const std::uint32_t page : next) {
        table.Remove(page);
    }
    EXPECT_FALSE(order.Next(table, uses, &next));
    EXPECT_TRUE(next.empty());
}

} // namespace
} // namespace hds::test
