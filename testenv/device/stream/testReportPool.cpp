// SPDX-License-Identifier: Apache-2.0
// The report's own streaming: pages that were visited are done, and all leave together.
#include "hdStream/stream/reportPool.h"
#include "testenv/device/stream/poolFixture.h"

#include <algorithm>

namespace hds::test {
namespace {

class ReportPoolTest : public StreamingPoolTest {};

TEST_F(ReportPoolTest, WhatWasVisitedIsDoneUntilTheNextBatch) {
    const std::vector<std::uint64_t> ids = EqualIds(8);
    FakePages pages(ids);
    ReportPool pool(device, "fake");
    pool.Update(&pages, 2 * 160);
    pool.BeginBatch();
    Ask(pool, {0, 1});
    pool.ProcessBatchRequests();
    Touch(pool, {0, 1});
    Ask(pool, {2});
    pool.ProcessBatchRequests(); // 0 and 1 are done; one of them leaves for 2
    const std::vector<std::uint32_t> words = Table(pool, ids);
    EXPECT_NE(words[0] & HDS_PAGE_DONE, 0U);
    EXPECT_NE(words[1] & HDS_PAGE_DONE, 0U);
    EXPECT_EQ(words[2] & HDS_PAGE_DONE, 0U);
    EXPECT_EQ(words[3], HDS_NOT_RESIDENT);
    pool.BeginBatch();
    for (const std::uint32_t word : Table(pool, ids)) {
        EXPECT_EQ(word & HDS_PAGE_DONE, 0U);
    }
}

TEST_F(ReportPoolTest, FlushMakesAllLeave) {
    const std::vector<std::uint64_t> ids = EqualIds(10);
    FakePages pages(ids);
    ReportPool pool(device, "fake", std::make_unique<FlushOrder>());
    pool.Update(&pages, 4 * 160);
    pool.BeginBatch();
    Ask(pool, {0, 1, 2, 3});
    pool.ProcessBatchRequests();
    Ask(pool, {7});
    pool.ProcessBatchRequests();
    EXPECT_EQ(Resident(Table(pool, ids)), (Pages{7}));
    EXPECT_EQ(pool.Statistics().evictions, 4U);
}

TEST_F(ReportPoolTest, NoPageIsDoneInAFullyResidentPool) {
    const std::vector<std::uint64_t> ids = EqualIds(8);
    FakePages pages(ids);
    ReportPool pool(device, "fake");
    pool.Update(&pages, 8 * 160);
    pool.BeginBatch();
    Ask(pool, {0, 1, 2, 3, 4, 5});
    pool.ProcessBatchRequests();
    Ask(pool, {6, 7});
    pool.ProcessBatchRequests(); // those from before are done
    pool.MakeResident(false);
    for (const std::uint32_t word : Table(pool, ids)) {
        EXPECT_EQ(word & HDS_PAGE_DONE, 0U);
    }
}

/// A batch ends when every page was there once, whatever leaves.
TEST_F(ReportPoolTest, CastsOfAPoolThatIsTooSmallEnd) {
    const std::vector<std::uint64_t> ids = EqualIds(30);
    FakePages pages(ids);
    for (const Eviction eviction : {Eviction::Lru, Eviction::Flush}) {
        const auto owner = MakeStreamingPool(device, "fake", eviction, true);
        auto& pool = dynamic_cast<ReportPool&>(*owner);
        pool.Update(&pages, 4 * 160);
        for (int batch = 0; batch < 3; ++batch) {
            pool.BeginBatch();
            int iterations = 0;
            while (true) {
                const std::vector<std::uint32_t> words = Table(pool, ids);
                Pages missing;
                for (std::uint32_t page = 0; page < words.size(); ++page) {
                    if (words[page] == HDS_NOT_RESIDENT) { // and not done
                        missing.push_back(page);
                    }
                }
                if (missing.empty()) {
                    break;
                }
                ASSERT_LT(++iterations, 10);
                Ask(pool, missing);
                pool.ProcessBatchRequests();
                const std::vector<std::uint32_t> after = Table(pool, ids);
                const std::size_t numLoaded = std::min<std::size_t>(4, missing.size());
                EXPECT_EQ(Resident(after).size(), eviction == Eviction::Flush ? numLoaded : 4U);
            }
            EXPECT_EQ(iterations, batch == 0 ? 8 : 7)
                << "four pages each, but for those that are there";
        }
    }
}

} // namespace
} // namespace hds::test
