// SPDX-License-Identifier: Apache-2.0
// A pool that holds everything may be read without asking; what it counts is of one render; lists
// of requests hold whatever is asked for.
#include "testenv/device/stream/poolFixture.h"

namespace hds::test {
namespace {

class SettledPool : public StreamingPoolTest {};

TEST_F(SettledPool, LoadsTheRestInPieces) {
    const std::vector<std::uint64_t> ids = Range(0, 300); // all sizes, some pages are empty
    FakePages pages(ids);
    StreamingPool pool(device, "fake", Eviction::Clock);
    pool.Update(&pages, pages.TotalBytes());
    EXPECT_TRUE(pool.HasRoomForAll());
    Ask(pool, {8, 101});
    pool.Service();
    const std::uint64_t asked = pool.Statistics().uploadedBytes;
    const std::uint64_t used = pool.Statistics().chunksUsed;
    EXPECT_EQ(pool.MissingBytes(), pages.TotalBytes() - asked);
    int pieces = 0;
    while (pool.MissingBytes() > 0) {
        ASSERT_TRUE(pool.LoadMissing(10000));
        ++pieces;
    }
    EXPECT_GT(pieces, 5);
    EXPECT_EQ(pool.Statistics().uploadedBytes, pages.TotalBytes());
    EXPECT_EQ(pool.Statistics().evictions, 0U);
    EXPECT_EQ(pool.Statistics().chunksUsed, used) << "nobody has asked for them";
    pool.Settle();
    const auto words = Table(pool, ids); // checks all bytes
    for (std::uint32_t page = 0; page < ids.size(); ++page) {
        EXPECT_EQ(words[page] == HDS_NOT_RESIDENT, pages.PageBytes(page) == 0) << page;
        EXPECT_FALSE(pages.HasData(page)) << "the pool holds it for good";
    }
}

TEST_F(SettledPool, NoPageIsDone) {
    const std::vector<std::uint64_t> ids = EqualIds(8);
    FakePages pages(ids);
    StreamingPool pool(device, "fake", Eviction::Clock);
    pool.Update(&pages, 8 * 160);
    pool.BeginCast();
    Ask(pool, {0, 1, 2, 3, 4, 5});
    pool.ServiceCast();
    Ask(pool, {6, 7});
    pool.ServiceCast(); // those from before are done
    pool.Settle();
    for (const std::uint32_t word : Table(pool, ids)) {
        EXPECT_EQ(word & HDS_PAGE_DONE, 0U);
    }
}

TEST_F(SettledPool, WhatDoesNotFitIsLeft) {
    const std::vector<std::uint64_t> ids = EqualIds(10);
    FakePages pages(ids);
    StreamingPool pool(device, "fake", Eviction::Clock);
    pool.Update(&pages, 9 * 160);
    EXPECT_FALSE(pool.HasRoomForAll());
    EXPECT_FALSE(pool.LoadMissing(1U << 20U));
    EXPECT_EQ(Resident(Table(pool, ids)).size(), 9U);
    Ask(pool, {9});
    pool.Service(); // goes on as before
    const Pages after = Resident(Table(pool, ids));
    EXPECT_EQ(std::count(after.begin(), after.end(), 9U), 1);
}

TEST_F(SettledPool, EditsBringNewPages) {
    std::vector<std::uint64_t> ids = EqualIds(12);
    FakePages all(ids);
    ids.resize(8);
    FakePages pages(ids);
    StreamingPool pool(device, "fake", Eviction::Clock);
    pool.Update(&all, 12 * 160);
    pool.Update(&pages, 12 * 160);
    while (pool.MissingBytes() > 0) {
        ASSERT_TRUE(pool.LoadMissing(500));
    }
    pool.Settle();
    pool.Update(&all, 12 * 160);
    EXPECT_EQ(pool.MissingBytes(), 4U * 160);
    EXPECT_EQ(Resident(Table(pool, EqualIds(12))).size(), 8U) << "the others stay";
}

TEST_F(SettledPool, CountsBeginAnew) {
    const std::vector<std::uint64_t> ids = EqualIds(8);
    FakePages pages(ids);
    StreamingPool pool(device, "fake", Eviction::Clock);
    pool.BeginStatistics();
    pool.Update(&pages, 4 * 160);
    Ask(pool, {1, 3, 3});
    pool.Service();
    Touch(pool, {0, 1, 2, 3});
    pool.CountUsed();
    EXPECT_EQ(pool.Statistics().uploads, 4U);
    EXPECT_EQ(pool.Statistics().chunksUsed, 2U);

    pool.BeginStatistics();
    Touch(pool, {2}); // is there already
    pool.CountUsed();
    pool.CountUsed();
    EXPECT_EQ(pool.Statistics().uploads, 0U);
    EXPECT_EQ(pool.Statistics().uniqueBytes, 0U);
    EXPECT_EQ(pool.Statistics().chunksUsed, 1U);
    Ask(pool, {5, 5});
    pool.Service(); // makes two pages leave
    Ask(pool, {1});
    pool.Service();
    EXPECT_GE(pool.Statistics().uploads, 2U);
    EXPECT_EQ(pool.Statistics().uniqueBytes, pool.Statistics().uploadedBytes)
        << "what the render before has loaded counts again";
    EXPECT_LE(pool.Statistics().chunksUsed, 3U);

    pool.BeginStatistics();
    pool.Update(&pages, 4 * 160); // a new version of the scene
    pool.CountUsed();
    EXPECT_EQ(pool.Statistics().chunksUsed, 0U);
    Touch(pool, {4});
    pool.CountUsed();
    EXPECT_EQ(pool.Statistics().chunksUsed, 1U);
}

TEST_F(SettledPool, RequestsNeverOverflow) {
    const std::vector<std::uint64_t> ids = EqualIds(400);
    FakePages pages(ids);
    StreamingPool pool(device, "fake", Eviction::Clock);
    pool.Update(&pages, 7 * 160);
    Pages asked; // each page by many, one by far more than are counted
    for (int round = 0; round < 50; ++round) {
        for (std::uint32_t page = 0; page < 400; ++page) {
            asked.push_back(page);
        }
    }
    asked.insert(asked.end(), 3 * HDS_REQUEST_MAX_COUNT, 123);
    Ask(pool, asked);
    const auto list = Download<std::uint32_t>(pool.Requests(), HDS_REQUEST_HEADER + 400);
    EXPECT_EQ(list[HDS_REQUEST_NUM_PAGES], 400U);
    Pages listed(list.begin() + HDS_REQUEST_HEADER, list.end());
    std::sort(listed.begin(), listed.end());
    for (std::uint32_t page = 0; page < 400; ++page) {
        ASSERT_EQ(listed[page], page) << "each once";
    }
    pool.Service();
    const Pages resident = Resident(Table(pool, ids));
    EXPECT_EQ(std::count(resident.begin(), resident.end(), 123U), 1) << "most wanted";
    Ask(pool, {}); // served or forgotten: nobody waits from here on
    EXPECT_EQ(Download<std::uint32_t>(pool.Requests(), 1)[HDS_REQUEST_NUM_PAGES], 0U);
}

TEST_F(SettledPool, RequestsInFlightDoNotOutliveAnEdit) {
    const std::vector<std::uint64_t> ids = EqualIds(40);
    FakePages pages(ids);
    StreamingPool pool(device, "fake", Eviction::Clock);
    pool.Update(&pages, 10 * 160);
    Ask(pool, {39, 37, 35, 2});
    FakePages fewer({ids[3], ids[0], ids[7], ids[2]}); // what was page 39 is no page any more
    pool.Update(&fewer, 4 * 160);
    EXPECT_EQ(Download<std::uint32_t>(pool.Requests(), 1)[HDS_REQUEST_NUM_PAGES], 0U);
    Ask(pool, {1});
    pool.Service();
    EXPECT_EQ(Resident(Table(pool, {ids[3], ids[0], ids[7], ids[2]})), (Pages{0, 1}));
}

} // namespace
} // namespace hds::test
