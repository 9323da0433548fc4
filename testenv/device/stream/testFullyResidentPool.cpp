// SPDX-License-Identifier: Apache-2.0
// A pool that holds everything may be read without asking; what it counts is of one render; any
// number of requests are counted.
#include "testenv/device/stream/poolFixture.h"

#include <algorithm>

namespace hds::test {
namespace {

class FullyResidentPool : public StreamingPoolTest {};

TEST_F(FullyResidentPool, LoadsTheRestInPieces) {
    const std::vector<std::uint64_t> ids = Range(0, 300); // all sizes, some pages are empty
    FakePages pages(ids);
    StreamingPool pool(device, "fake");
    pool.Update(&pages, pages.TotalBytes());
    EXPECT_TRUE(pool.HasRoomForAll());
    Ask(pool, {8});
    AskWhole(pool, {101});
    pool.ProcessRequests();
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
    pool.MakeResident(false);
    const auto words = Table(pool, ids); // checks all bytes
    for (std::uint32_t page = 0; page < ids.size(); ++page) {
        EXPECT_EQ(words[page] == HDS_NOT_RESIDENT, pages.PageBytes(page) == 0) << page;
        EXPECT_FALSE(pages.HasData(page)) << "the pool holds it for good";
    }
}

TEST_F(FullyResidentPool, WhatDoesNotFitIsLeft) {
    const std::vector<std::uint64_t> ids = EqualIds(10);
    FakePages pages(ids);
    StreamingPool pool(device, "fake");
    pool.Update(&pages, 9 * 160);
    EXPECT_FALSE(pool.HasRoomForAll());
    EXPECT_FALSE(pool.LoadMissing(1U << 20U));
    EXPECT_EQ(Resident(Table(pool, ids)).size(), 9U);
    AskWhole(pool, {9});
    pool.ProcessRequests(); // goes on as before
    const Pages after = Resident(Table(pool, ids));
    EXPECT_EQ(std::count(after.begin(), after.end(), 9U), 1);
}

TEST_F(FullyResidentPool, EditsBringNewPages) {
    std::vector<std::uint64_t> ids = EqualIds(12);
    FakePages all(ids);
    ids.resize(8);
    FakePages pages(ids);
    StreamingPool pool(device, "fake");
    pool.Update(&all, 12 * 160);
    pool.Update(&pages, 12 * 160);
    while (pool.MissingBytes() > 0) {
        ASSERT_TRUE(pool.LoadMissing(500));
    }
    pool.MakeResident(false);
    pool.Update(&all, 12 * 160);
    EXPECT_EQ(pool.MissingBytes(), 4U * 160);
    EXPECT_EQ(Resident(Table(pool, EqualIds(12))).size(), 8U) << "the others stay";
}

TEST_F(FullyResidentPool, CountsBeginAnew) {
    const std::vector<std::uint64_t> ids = EqualIds(8);
    FakePages pages(ids);
    StreamingPool pool(device, "fake");
    pool.BeginStatistics();
    pool.Update(&pages, 4 * 160);
    AskWhole(pool, {1, 3, 3});
    pool.ProcessRequests();
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
    AskWhole(pool, {5, 5});
    pool.ProcessRequests(); // makes two pages leave
    AskWhole(pool, {1});
    pool.ProcessRequests();
    EXPECT_GE(pool.Statistics().uploads, 2U);
    EXPECT_EQ(pool.Statistics().uniqueBytes, pool.Statistics().uploadedBytes)
        << "what the render before has loaded counts again";
    EXPECT_LE(pool.Statistics().chunksUsed, 3U);

    pool.BeginStatistics();
    pool.Update(&pages, 4 * 160); // a new version of the scene
    pool.CountUsed();
    EXPECT_EQ(pool.Statistics().chunksUsed, 0U);
    Touch(pool, {2});
    pool.CountUsed();
    EXPECT_EQ(pool.Statistics().chunksUsed, 1U);
}

TEST_F(FullyResidentPool, WhatWasUsedIsCountedWhenItHasLeft) {
    const std::vector<std::uint64_t> ids = EqualIds(8);
    FakePages pages(ids);
    StreamingPool pool(device, "fake");
    pool.Update(&pages, 2 * 160);
    AskWhole(pool, {0});
    pool.ProcessRequests();
    pool.BeginStatistics();
    AskWhole(pool, {0}); // is there: a use
    AskWhole(pool, {2});
    pool.ProcessRequests(); // group 0 leaves
    AskWhole(pool, {4});
    pool.ProcessRequests(); // group 1 leaves unused
    pool.CountUsed();
    EXPECT_EQ(pool.Statistics().chunksUsed, 3U);
    EXPECT_EQ(pool.Statistics().evictions, 4U);
}

TEST_F(FullyResidentPool, AUseIsAStampOrACount) {
    const std::vector<std::uint64_t> ids = EqualIds(40);
    FakePages pages(ids);
    StreamingPool pool(device, "fake");
    pool.Update(&pages, 4 * 160);
    EXPECT_LE(pool.TableBytes(), 40U * 8 + 64) << "8 bytes a page";
    std::vector<std::uint32_t> uses(ids.size(), 0);
    for (std::uint32_t round = 0; round < 100; ++round) { // stamps are larger than counts
        if (uses[2 * (round % 20)] != 0) {
            continue; // is there
        }
        AskWhole(pool, {2 * (round % 20)});
        pool.ProcessRequests();
        const Pages resident = Resident(Table(pool, ids));
        Touch(pool, resident);
        uses = Uses(pool, ids.size());
        for (std::uint32_t page = 0; page < ids.size(); ++page) {
            const bool isResident = std::count(resident.begin(), resident.end(), page) != 0;
            ASSERT_EQ(uses[page] != 0, isResident) << "those that have left begin from 0";
            ASSERT_TRUE(!isResident || uses[page] == uses[resident[0]]) << "the present epoch";
        }
    }
    // Resident are 36 to 39. A group of which one page is there is asked for by the other.
    pool.Update(&pages, 4 * 160);
    Pages asked(5, 7);
    asked.insert(asked.end(), 3, 20);
    Ask(pool, asked);
    AskWhole(pool, {6, 7, 36, 0});
    uses = Uses(pool, ids.size());
    EXPECT_EQ(uses[7], 5U);
    EXPECT_EQ(uses[20], 3U);
    EXPECT_EQ(uses[6], 2U | HDS_ASKED_WHOLE);
    EXPECT_EQ(uses[0], 1U | HDS_ASKED_WHOLE);
    EXPECT_EQ(uses[36], uses[37]);
}

TEST_F(FullyResidentPool, WhatIsLoadedUnaskedIsNotAskedFor) {
    const std::vector<std::uint64_t> ids = EqualIds(6);
    FakePages pages(ids);
    StreamingPool pool(device, "fake");
    pool.BeginStatistics();
    pool.Update(&pages, 6 * 160);
    Ask(pool, {0, 1, 1, 2}); // of a render that was stopped
    ASSERT_TRUE(pool.LoadMissing(3 * 160));
    const std::vector<std::uint32_t> uses = Uses(pool, ids.size());
    EXPECT_EQ(uses, (std::vector<std::uint32_t>(6, 0)));
    pool.CountUsed();
    EXPECT_EQ(pool.Statistics().chunksUsed, 0U);
}

TEST_F(FullyResidentPool, RequestsNeverOverflow) {
    const std::vector<std::uint64_t> ids = EqualIds(400);
    FakePages pages(ids);
    StreamingPool pool(device, "fake");
    pool.Update(&pages, 7 * 160);
    Pages asked; // each page by many, one by far more than are counted
    for (int round = 0; round < 50; ++round) {
        for (std::uint32_t page = 0; page < 400; ++page) {
            asked.push_back(page);
        }
    }
    asked.insert(asked.end(), 3 * HDS_ASKED_MAX, 123);
    Ask(pool, asked);
    const std::vector<std::uint32_t> uses = Uses(pool, 400);
    for (std::uint32_t page = 0; page < 400; ++page) {
        ASSERT_TRUE(page == 123 || uses[page] == 50) << page;
    }
    EXPECT_GE(uses[123], HDS_ASKED_MAX);
    // What is in flight at a time may all have read a count that is below: on a GPU most of a wave.
    const std::uint32_t inFlight = device->Properties().isCpu ? HDS_ASKED_MAX : 1U << 24U;
    EXPECT_LT(uses[123], HDS_ASKED_MAX + inFlight) << "far from HDS_ASKED_WHOLE";
    pool.ProcessRequests();
    const Pages resident = Resident(Table(pool, ids));
    EXPECT_EQ(std::count(resident.begin(), resident.end(), 123U), 1) << "most wanted";
    EXPECT_EQ(Uses(pool, 400), std::vector<std::uint32_t>(400, 0)) << "served or forgotten";
}

TEST_F(FullyResidentPool, RequestsInFlightDoNotOutliveAnEdit) {
    const std::vector<std::uint64_t> ids = EqualIds(40);
    FakePages pages(ids);
    StreamingPool pool(device, "fake");
    pool.Update(&pages, 10 * 160);
    Ask(pool, {39, 37, 35, 2});
    FakePages fewer({ids[3], ids[0], ids[7], ids[2]}); // what was page 39 is no page any more
    pool.Update(&fewer, 4 * 160);
    EXPECT_EQ(Uses(pool, 4), std::vector<std::uint32_t>(4, 0));
    AskWhole(pool, {1});
    pool.ProcessRequests();
    EXPECT_EQ(Resident(Table(pool, {ids[3], ids[0], ids[7], ids[2]})), (Pages{0, 1}));
}

} // namespace
} // namespace hds::test
