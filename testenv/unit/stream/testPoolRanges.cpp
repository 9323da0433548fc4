// SPDX-License-Identifier: Apache-2.0
// Pinned pages lie in a part of their own and never in the way of others.
#include "hdStream/stream/poolRanges.h"

#include <gtest/gtest.h>

#include <vector>

namespace hds::test {
namespace {

constexpr std::uint64_t kUnit = HDS_POOL_UNIT_BYTES;

TEST(PoolRanges, PinnedPagesAreKeptTogether) {
    PoolRanges ranges;
    ranges.AddBuffer(16 * kUnit);
    ranges.SetApart(4 * kUnit);
    EXPECT_EQ(ranges.ApartBytes(), 4 * kUnit);
    std::vector<PoolRange> pinned(4);
    PoolRange other;
    for (PoolRange& range : pinned) { // in turn with others, all over the pool
        ASSERT_TRUE(ranges.Allocate(kUnit, true, &range));
        EXPECT_TRUE(ranges.IsPinned(range.Address()));
        ASSERT_TRUE(ranges.Allocate(2 * kUnit, false, &other));
        EXPECT_FALSE(ranges.IsPinned(other.Address()));
        ranges.Free(other);
    }
    EXPECT_EQ(ranges.PinnedBytes(), 4 * kUnit);
    EXPECT_TRUE(ranges.Allocate(12 * kUnit, false, &other)) << "the rest is one piece";
    EXPECT_FALSE(ranges.Allocate(kUnit, true, &other));
    ranges.Free(pinned[2]);
    EXPECT_EQ(ranges.PinnedBytes(), 3 * kUnit);
    EXPECT_FALSE(ranges.Allocate(kUnit, false, &other)) << "others do not get that room";
    ASSERT_TRUE(ranges.Allocate(kUnit, true, &other));
    EXPECT_EQ(other.Address(), pinned[2].Address());
}

TEST(PoolRanges, WhatFindsNoRoomAmongPinnedOnesLiesElsewhere) {
    PoolRanges ranges;
    ranges.AddBuffer(2 * kUnit); // too small for the part
    ranges.AddBuffer(8 * kUnit);
    ranges.SetApart(3 * kUnit);
    PoolRange first;
    PoolRange second;
    ASSERT_TRUE(ranges.Allocate(2 * kUnit, true, &first));
    EXPECT_EQ(first.buffer, 1U);
    ASSERT_TRUE(ranges.Allocate(2 * kUnit, true, &second));
    EXPECT_TRUE(ranges.IsPinned(first.Address()));
    EXPECT_FALSE(ranges.IsPinned(second.Address()));
    EXPECT_EQ(ranges.PinnedBytes(), 2 * kUnit);
    ranges.Free(second);
    ranges.Free(first);
    EXPECT_EQ(ranges.PinnedBytes(), 0U);
}

TEST(PoolRanges, NothingSetApartPinsNothing) {
    PoolRanges ranges;
    ranges.AddBuffer(4 * kUnit);
    ranges.SetApart(0);
    PoolRange range;
    ASSERT_TRUE(ranges.Allocate(4 * kUnit, true, &range));
    EXPECT_FALSE(ranges.IsPinned(range.Address()));
    EXPECT_FALSE(ranges.IsPinned(HDS_NOT_RESIDENT));
    EXPECT_EQ(ranges.PinnedBytes(), 0U);
}

} // namespace
} // namespace hds::test
