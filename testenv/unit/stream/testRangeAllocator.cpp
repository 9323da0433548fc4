// SPDX-License-Identifier: Apache-2.0
// Ranges never overlap, freed room is found again, neighbours become one.
#include "hdStream/stream/rangeAllocator.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>
#include <vector>

namespace hds::test {
namespace {

constexpr std::uint64_t kUnit = HDS_POOL_UNIT_BYTES;

TEST(RangeAllocator, FillsABufferToTheLastByte) {
    RangeAllocator ranges;
    ranges.AddBuffer(10 * kUnit);
    PoolRange range;
    for (std::uint64_t i = 0; i < 10; ++i) {
        ASSERT_TRUE(ranges.Allocate(kUnit, &range));
        EXPECT_EQ(range.offset, i * kUnit);
    }
    EXPECT_EQ(ranges.FreeBytes(), 0U);
    EXPECT_FALSE(ranges.Allocate(kUnit, &range));
}

TEST(RangeAllocator, NeighboursBecomeOne) {
    RangeAllocator ranges;
    ranges.AddBuffer(3 * kUnit);
    PoolRange a;
    PoolRange b;
    PoolRange c;
    ASSERT_TRUE(ranges.Allocate(kUnit, &a) && ranges.Allocate(kUnit, &b) &&
                ranges.Allocate(kUnit, &c));
    ranges.Free(a);
    ranges.Free(c);
    EXPECT_EQ(ranges.LargestFreeRange(), kUnit);
    ranges.Free(b);
    EXPECT_EQ(ranges.LargestFreeRange(), 3 * kUnit);
}

TEST(RangeAllocator, AddressesTellBuffersApart) {
    RangeAllocator ranges;
    ranges.AddBuffer(2 * kUnit);
    ranges.AddBuffer(4 * kUnit);
    PoolRange range;
    ASSERT_TRUE(ranges.Allocate(3 * kUnit, &range));
    EXPECT_EQ(range.Address(), 1U << HDS_POOL_BUFFER_SHIFT);
    ASSERT_TRUE(ranges.Allocate(kUnit, &range));
    EXPECT_EQ(range.Address(), 0U);
    ASSERT_TRUE(ranges.Allocate(kUnit, &range));
    EXPECT_EQ(range.Address(), 1U);
}

TEST(RangeAllocator, RandomUseKeepsAccount) {
    constexpr std::uint64_t kUnits = 300;
    RangeAllocator ranges;
    ranges.AddBuffer(kUnits * kUnit);
    std::vector<bool> isUsed(kUnits, false);
    std::vector<PoolRange> held;
    std::mt19937 random(7);
    for (int step = 0; step < 20000; ++step) {
        if (random() % 2 == 0 && !held.empty()) {
            const std::size_t which = random() % held.size();
            for (std::uint64_t i = 0; i < held[which].bytes / kUnit; ++i) {
                isUsed[held[which].offset / kUnit + i] = false;
            }
            ranges.Free(held[which]);
            held.erase(held.begin() + static_cast<std::ptrdiff_t>(which));
        } else {
            const std::uint64_t bytes = (1 + random() % 20) * kUnit;
            const bool fits = ranges.LargestFreeRange() >= bytes;
            PoolRange range;
            ASSERT_EQ(ranges.Allocate(bytes, &range), fits);
            if (fits) {
                for (std::uint64_t i = 0; i < bytes / kUnit; ++i) {
                    ASSERT_FALSE(isUsed[range.offset / kUnit + i]);
                    isUsed[range.offset / kUnit + i] = true;
                }
                held.push_back(range);
            }
        }
        std::uint64_t run = 0;
        std::uint64_t longest = 0;
        std::uint64_t free = 0;
        for (const bool used : isUsed) {
            run = used ? 0 : run + 1;
            longest = std::max(longest, run);
            free += used ? 0 : 1;
        }
        ASSERT_EQ(ranges.FreeBytes(), free * kUnit);
        ASSERT_EQ(ranges.LargestFreeRange(), longest * kUnit);
    }
}

} // namespace
} // namespace hds::test
