// SPDX-License-Identifier: Apache-2.0
// Pages and groups count once a render, however often they come; the peak is the most that was held
// at a time.
#include "hdStream/stream/poolCounters.h"

#include <gtest/gtest.h>

#include <vector>

namespace hds::test {
namespace {

constexpr std::uint32_t kNoPage = 0xffffffffU;

PoolCounters MakeCounters(std::uint32_t numPages) {
    PoolCounters counters;
    counters.Renumber(std::vector<std::uint32_t>(numPages, kNoPage));
    return counters;
}

TEST(PoolCounters, BytesOfAPageAreUniqueOnce) {
    PoolCounters counters = MakeCounters(4);
    counters.CountLoad(0, 100, true);
    counters.CountLoad(1, 20, true);
    counters.CountLoad(0, 100, true);
    counters.CountEvictions(2);
    counters.CountGroupLoads(3);
    const StreamingStatistics& statistics = counters.Statistics();
    EXPECT_EQ(statistics.uploads, 3U);
    EXPECT_EQ(statistics.uploadedBytes, 220U);
    EXPECT_EQ(statistics.uniqueBytes, 120U);
    EXPECT_EQ(statistics.evictions, 2U);
    EXPECT_EQ(statistics.groupUploads, 3U);
    EXPECT_EQ(statistics.chunksUsed, 1U) << "pages 0 and 1 are one group";
    counters.Begin();
    EXPECT_EQ(counters.Statistics().uploads, 0U);
    counters.CountLoad(0, 100, true);
    EXPECT_EQ(counters.Statistics().uniqueBytes, 100U);
    EXPECT_EQ(counters.Statistics().chunksUsed, 1U);
}

TEST(PoolCounters, OnlyWhatIsAskedForOrUsedIsUsed) {
    PoolCounters counters = MakeCounters(6);
    counters.CountLoad(0, 100, false);
    EXPECT_EQ(counters.Statistics().chunksUsed, 0U);
    counters.CountUse(1);
    counters.CountUse(0);
    counters.CountUse(5);
    EXPECT_EQ(counters.Statistics().chunksUsed, 2U);
}

TEST(PoolCounters, EditsKeepWhatWasCounted) {
    PoolCounters counters = MakeCounters(4);
    counters.CountLoad(2, 10, true);
    counters.CountLoad(3, 10, true);
    counters.Renumber({2, 3, kNoPage, kNoPage});
    counters.CountLoad(0, 10, true);
    EXPECT_EQ(counters.Statistics().uniqueBytes, 20U);
    EXPECT_EQ(counters.Statistics().chunksUsed, 1U);
    counters.CountLoad(2, 10, true);
    EXPECT_EQ(counters.Statistics().uniqueBytes, 30U);
    EXPECT_EQ(counters.Statistics().chunksUsed, 2U);
}

TEST(PoolCounters, SecondsAddUp) {
    PoolCounters counters = MakeCounters(0);
    counters.AddPrepareSeconds(1.0);
    counters.AddPrepareSeconds(0.5);
    counters.AddRequestSeconds(2.0);
    counters.AddTransferSeconds(4.0);
    EXPECT_EQ(counters.Statistics().prepareSeconds, 1.5);
    EXPECT_EQ(counters.Statistics().requestSeconds, 2.0);
    EXPECT_EQ(counters.Statistics().transferSeconds, 4.0);
}

TEST(PoolCounters, ThePeakIsTheMostThatWasHeld) {
    PoolCounters counters = MakeCounters(2);
    counters.SetHeld(300);
    counters.SetHeld(500);
    counters.SetHeld(200);
    EXPECT_EQ(counters.Held().Bytes(), 200U);
    EXPECT_EQ(counters.Held().Peak(), 500U);
    counters.Begin();
    EXPECT_EQ(counters.Held().Bytes(), 200U) << "pages stay when counting begins anew";
    EXPECT_EQ(counters.Held().Peak(), 200U);
    counters.SetHeld(350);
    EXPECT_EQ(counters.Held().Peak(), 350U);
}

} // namespace
} // namespace hds::test
