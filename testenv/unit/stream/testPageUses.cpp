// SPDX-License-Identifier: Apache-2.0
// What kernels ask for comes in the order of how many ask, once; a word is a count of a page that
// is missing and a stamp of one that is there.
#include "hdStream/stream/pageUses.h"

#include <gtest/gtest.h>

#include <vector>

namespace hds::test {
namespace {

constexpr std::uint64_t kUnit = HDS_POOL_UNIT_BYTES;

/// So many pages, of which those in `placed` have a place.
PageTable MakeTable(std::uint32_t numPages, const std::vector<std::uint32_t>& placed) {
    PageTable table;
    std::vector<std::uint64_t> ids;
    for (std::uint32_t page = 0; page < numPages; ++page) {
        ids.push_back(100 + page);
    }
    table.Renumber(ids);
    table.SetBuffers({numPages * kUnit}, 0);
    for (const std::uint32_t page : placed) {
        EXPECT_TRUE(table.FindPlace(page, kUnit));
        table.Publish(page);
    }
    return table;
}

TEST(PageUses, RequestsComeMostWantedFirstAndOnce) {
    const PageTable table = MakeTable(6, {2});
    PageUses uses;
    uses.Reset(6);
    uses.Words() = {3, 0, 9, 7, 3, 1 | HDS_ASKED_WHOLE};
    const std::vector<PageRequest> requests = uses.TakeRequests(table, true);
    ASSERT_EQ(requests.size(), 4U);
    EXPECT_EQ(requests[0].page, 3U);
    EXPECT_EQ(requests[1].page, 0U) << "of two that as many ask for the first";
    EXPECT_EQ(requests[2].page, 4U);
    EXPECT_EQ(requests[3].page, 5U);
    EXPECT_EQ(requests[3].count, 1U);
    EXPECT_TRUE(requests[3].isGroup && !requests[0].isGroup);
    EXPECT_EQ(uses.Words(), (std::vector<std::uint32_t>{0, 0, 9, 0, 0, 0})) << "9 is a stamp";
    EXPECT_TRUE(uses.TakeRequests(table, true).empty());
}

TEST(PageUses, WithoutGroupsAPageIsAskedForAlone) {
    const PageTable table = MakeTable(2, {});
    PageUses uses;
    uses.Reset(2);
    uses.Words() = {0, 4 | HDS_ASKED_WHOLE};
    const std::vector<PageRequest> requests = uses.TakeRequests(table, false);
    ASSERT_EQ(requests.size(), 1U);
    EXPECT_FALSE(requests[0].isGroup);
    EXPECT_EQ(requests[0].count, 4U);
}

TEST(PageUses, StampsAreEpochs) {
    PageUses uses;
    uses.Reset(2);
    uses.BeginEpoch();
    uses.Words() = {uses.Epoch(), uses.Epoch() - 1};
    EXPECT_EQ(uses.Age(0), 0U);
    EXPECT_EQ(uses.Age(1), 1U);
    uses.BeginStatistics();
    EXPECT_TRUE(uses.WasUsed(0));
    EXPECT_FALSE(uses.WasUsed(1)) << "before the statistics began";
    uses.BeginEpoch();
    EXPECT_EQ(uses.Age(0), 1U);
    EXPECT_TRUE(uses.WasUsed(0));
    uses.Clear(0);
    EXPECT_FALSE(uses.WasUsed(0));
}

} // namespace
} // namespace hds::test
