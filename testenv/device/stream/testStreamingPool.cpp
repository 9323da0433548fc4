// SPDX-License-Identifier: Apache-2.0
// What kernels ask for is there, whole, after the round; the budget holds; the right pages leave.
#include "testenv/device/stream/poolFixture.h"

#include <algorithm>
#include <array>
#include <iterator>
#include <random>

namespace hds::test {
namespace {

TEST_F(StreamingPoolTest, LoadsWhatIsAskedForMost) {
    const std::vector<std::uint64_t> ids = EqualIds(8);
    FakePages pages(ids);
    StreamingPool pool(device, "fake");
    pool.Update(&pages, 3 * 160 + 100);
    EXPECT_LE(pool.Bytes(), 3U * 160 + 100);
    Ask(pool, {5, 1, 5, 7, 2, 7, 5, 7, 7, 1});
    pool.ProcessRequests();
    EXPECT_EQ(Resident(Table(pool, ids)), (Pages{1, 5, 7}));
    EXPECT_EQ(pool.Statistics().uploads, 3U);
    EXPECT_EQ(pool.Statistics().uploadedBytes, 480U);
    EXPECT_EQ(pool.Statistics().evictions, 0U);
}

TEST_F(StreamingPoolTest, TheLeastRecentlyUsedLeaveThenThoseLeastWanted) {
    const std::vector<std::uint64_t> ids = EqualIds(10);
    FakePages pages(ids);
    StreamingPool pool(device, "fake");
    pool.Update(&pages, 4 * 160);
    Ask(pool, {0, 1, 1, 1, 2, 2, 3, 3, 3, 3});
    pool.ProcessRequests();
    Touch(pool, {0, 1, 2});
    Ask(pool, {4, 4, 5});
    pool.ProcessRequests(); // 3 leaves, which was not used, then 0: fewest asked for it
    EXPECT_EQ(Resident(Table(pool, ids)), (Pages{1, 2, 4, 5}));
    EXPECT_EQ(pool.Statistics().evictions, 2U);
}

TEST_F(StreamingPoolTest, GroupsComeWhole) {
    const std::vector<std::uint64_t> ids = EqualIds(10);
    FakePages pages(ids);
    StreamingPool pool(device, "fake");
    pool.Update(&pages, 3 * 160);
    Ask(pool, {4, 6});
    pool.ProcessRequests();
    Touch(pool, {4, 6});
    AskWhole(pool,
             {1, 1, 5}); // page 0 comes with 1; the room that is left is too small for 4 and 5
    pool.ProcessRequests();
    const Pages resident = Resident(Table(pool, ids));
    EXPECT_TRUE(std::count(resident.begin(), resident.end(), 0U) == 1 &&
                std::count(resident.begin(), resident.end(), 1U) == 1);
    AskWhole(pool, {5});
    pool.ProcessRequests(); // 4 may be there already: it stays
    const Pages after = Resident(Table(pool, ids));
    EXPECT_TRUE(std::count(after.begin(), after.end(), 4U) == 1 &&
                std::count(after.begin(), after.end(), 5U) == 1);
}

TEST_F(StreamingPoolTest, APoolOfOneGroupServesEverything) {
    const std::vector<std::uint64_t> ids = Range(0, 400); // all sizes, some pages are empty
    FakePages pages(ids);
    std::uint64_t largest = 0;
    for (std::size_t page = 0; page < ids.size(); page += 2) {
        largest = std::max<std::uint64_t>(largest, pages.PageBytes(std::uint32_t(page)) +
                                                       pages.PageBytes(std::uint32_t(page) + 1));
    }
    for (const Eviction eviction : {Eviction::Lru, Eviction::Flush}) {
        const auto owner = MakeStreamingPool(device, "fake", eviction, false);
        StreamingPool& pool = *owner;
        pool.Update(&pages, largest);
        EXPECT_EQ(pool.Bytes(), largest);
        std::mt19937 random(11);
        for (int round = 0; round < 100; ++round) {
            const std::uint32_t page = random() % 400;
            if (pages.PageBytes(page) == 0) {
                continue;
            }
            const auto isThere = [&](std::uint32_t which) {
                return pages.PageBytes(which) == 0 ||
                       (Table(pool, ids)[which] & ~HDS_PAGE_DONE) != HDS_NOT_RESIDENT;
            };
            if (isThere(page) && isThere(page ^ 1U)) {
                continue;
            }
            AskWhole(pool, {page});
            pool.ProcessRequests();
            EXPECT_TRUE(isThere(page) && isThere(page ^ 1U));
        }
    }
}

// Many ask for pages of which any two take each other's room, in pairs of which none would ever be
// complete: one of each round has its own.
TEST_F(StreamingPoolTest, WhatOneNeedsAtOnceComesTogether) {
    const std::vector<std::uint64_t> ids = Range(0, 400); // all sizes, some pages are empty
    FakePages pages(ids);
    constexpr std::uint32_t kOuter = 100;
    pages.SetOuterPages(kOuter);
    std::array<std::uint64_t, 2> largest{};
    for (std::uint32_t page = 0; page < ids.size(); page += 2) {
        std::uint64_t& kind = largest[page < kOuter ? 0 : 1];
        kind = std::max(kind, pages.PageBytes(page) + pages.PageBytes(page + 1));
    }
    const std::unique_ptr<Program> offering = Build(R"(
#include "stream/residency.clh"
kernel void probe_offer(global const uint* ways, uint count HDS_RESIDENCY_ARGS) {
    const uint i = (uint)get_global_id(0);
    HdsResidencyView view;
    HDS_RESIDENCY_VIEW(view);
    if (i < count) {
        residency_offerWay(&view, ways[3u * i], ways[3u * i + 1u], ways[3u * i + 2u]);
    }
}
)",
                                                    {{"HDS_FEATURE_STREAMING", "1"}});
    Kernel offer = offering->GetKernel("probe_offer");
    StreamingPool pool(device, "fake");
    pool.SetHashEntries(512); // more than pages: they have words of their own
    pool.Update(&pages, largest[0] + largest[1]);
    std::mt19937 random(13);
    for (int round = 0; round < 100; ++round) {
        const auto table = Table(pool, ids);
        const auto isThere = [&](const std::vector<std::uint32_t>& words, std::uint32_t page) {
            return page == HDS_NONE || pages.PageBytes(page) == 0 ||
                   words[page] != HDS_NOT_RESIDENT;
        };
        Pages ways;
        Pages missing;
        while (ways.size() < 7 * 3) {
            const std::uint32_t first = kOuter + random() % 150 * 2;
            const Pages way = {random() % 4 == 0 ? HDS_NONE : random() % kOuter, first,
                               random() % 2 == 0 ? HDS_NONE : first + 1};
            const std::size_t numMissing = missing.size();
            std::copy_if(way.begin(), way.end(), std::back_inserter(missing),
                         [&](std::uint32_t page) { return !isThere(table, page); });
            if (missing.size() > numMissing) { // it waits
                ways.insert(ways.end(), way.begin(), way.end());
            }
        }
        Ask(pool, missing);
        const Buffer list = Upload(ways);
        const auto count = static_cast<std::uint32_t>(ways.size() / 3);
        offer.Launch(count, list, count, pool.Uses());
        device->Finish();
        pool.ProcessRequests();
        const auto words = Table(pool, ids);
        bool isAnyComplete = false;
        for (std::size_t i = 0; i < ways.size(); i += 3) {
            isAnyComplete =
                isAnyComplete || (isThere(words, ways[i]) && isThere(words, ways[i + 1]) &&
                                  isThere(words, ways[i + 2]));
        }
        EXPECT_TRUE(isAnyComplete) << "round " << round;
    }
}

TEST_F(StreamingPoolTest, RandomUseKeepsTheBudget) {
    const std::vector<std::uint64_t> ids = Range(0, 1000);
    FakePages pages(ids);
    for (const Eviction eviction : {Eviction::Lru, Eviction::Flush}) {
        const std::uint64_t before = device->AllocatedBytes();
        const auto owner = MakeStreamingPool(device, "fake", eviction, false);
        StreamingPool& pool = *owner;
        const std::uint64_t budget = pages.TotalBytes() / 7;
        pool.Update(&pages, budget);
        std::mt19937 random(5);
        for (int batch = 0; batch < 20; ++batch) {
            for (int iteration = 0; iteration < 5; ++iteration) {
                Pages asked;
                const std::vector<std::uint32_t> words = Table(pool, ids);
                std::uint64_t residentBytes = 0;
                for (std::uint32_t page = 0; page < words.size(); ++page) {
                    const bool isResident = (words[page] & ~HDS_PAGE_DONE) != HDS_NOT_RESIDENT;
                    residentBytes += isResident ? pages.PageBytes(page) : 0;
                    if (words[page] == HDS_NOT_RESIDENT && pages.PageBytes(page) > 0 &&
                        random() % 10 == 0) {
                        asked.insert(asked.end(), 1 + random() % 3, page);
                    }
                }
                EXPECT_LE(residentBytes, budget);
                if (asked.empty()) {
                    break;
                }
                Ask(pool, asked);
                const std::uint64_t uploads = pool.Statistics().uploads;
                pool.ProcessRequests();
                EXPECT_GT(pool.Statistics().uploads, uploads);
            }
        }
        EXPECT_LE(pool.Bytes(), budget);
        EXPECT_LE(device->AllocatedBytes() - before,
                  budget + pool.TableBytes() + kMaxPoolBuffers * 16);
        EXPECT_GE(pool.Statistics().uploadedBytes, pool.Statistics().uniqueBytes);
        EXPECT_LE(pool.Statistics().uniqueBytes, pages.TotalBytes());
    }
}

TEST_F(StreamingPoolTest, SeveralBuffersServeLikeOne) {
    const std::vector<std::uint64_t> ids = EqualIds(40);
    FakePages pages(ids);
    StreamingPool pool(device, "fake", nullptr, 5 * 160);
    pool.Update(&pages, 12 * 160);
    EXPECT_EQ(pool.NumBuffers(), 3U);
    EXPECT_EQ(pool.Bytes(), 12U * 160);
    for (std::uint32_t first = 0; first < 40; first += 10) {
        Pages asked;
        for (std::uint32_t page = first; page < first + 10; ++page) {
            asked.push_back(page);
        }
        Ask(pool, asked);
        pool.ProcessRequests();
        const Pages resident = Resident(Table(pool, ids));
        EXPECT_EQ(resident.size(), first == 0 ? 10U : 12U);
        EXPECT_TRUE(std::includes(resident.begin(), resident.end(), asked.begin(), asked.end()));
    }
}

TEST_F(StreamingPoolTest, AnEditOfEqualSizeMovesNothing) {
    std::vector<std::uint64_t> ids = EqualIds(8);
    FakePages pages(ids);
    StreamingPool pool(device, "fake");
    pool.Update(&pages, 4 * 160 + 7); // not a whole number of units
    Ask(pool, {0, 1, 2});
    pool.ProcessRequests();
    pool.Update(&pages, 4 * 160 + 7);
    EXPECT_EQ(Resident(Table(pool, ids)), (Pages{0, 1, 2}));
    EXPECT_EQ(pool.Statistics().evictions, 0U);
}

TEST_F(StreamingPoolTest, EditsKeepWhatIsResident) {
    std::vector<std::uint64_t> ids = EqualIds(12);
    const std::vector<std::uint64_t> all = ids;
    ids.resize(8);
    FakePages pages(ids);
    StreamingPool pool(device, "fake");
    pool.Update(&pages, 4 * 160);
    Ask(pool, {0, 1, 2, 3});
    pool.ProcessRequests();
    const std::vector<std::uint64_t> edited = {all[9], all[3], all[10], all[1], all[11], all[6]};
    FakePages other(edited);
    pool.Update(&other, 4 * 160);
    EXPECT_EQ(Resident(Table(pool, edited)), (Pages{1, 3}));
    EXPECT_EQ(pool.Statistics().uploads, 4U);
    Ask(pool, {0, 5});
    pool.ProcessRequests();
    EXPECT_EQ(Resident(Table(pool, edited)), (Pages{0, 1, 3, 5}));
}

TEST_F(StreamingPoolTest, AGroupThatDoesNotFitIsAnErrorThatNamesTheOption) {
    const std::vector<std::uint64_t> ids = EqualIds(4);
    FakePages pages(ids);
    StreamingPool pool(device, "fake");
    try {
        pool.Update(&pages, 319);
        FAIL() << "no error";
    } catch (const Error& error) {
        const std::string text = error.what();
        EXPECT_NE(text.find("--fakeMemory"), std::string::npos) << text;
        EXPECT_NE(text.find("320"), std::string::npos) << text;
    }
}

/// Pages of 16 MiB, all of the same bytes.
class LargePages final : public FakePages {
public:
    using FakePages::FakePages;
    std::uint64_t PageBytes(std::uint32_t) const override { return _bytes.size(); }
    const std::uint8_t* Page(std::uint32_t) const override { return _bytes.data(); }

private:
    std::vector<std::uint8_t> _bytes = std::vector<std::uint8_t>(std::size_t{16} << 20U);
};

TEST_F(StreamingPoolTest, WhoCancelsWaitsForAFewPagesOnly) {
    LargePages pages(Range(1, 9));
    StreamingPool pool(device, "fake");
    pool.Update(&pages, 8 * pages.PageBytes(0));
    Ask(pool, {0, 1, 2, 3, 4, 5, 6, 7});
    pool.ProcessRequests([] { return true; });
    EXPECT_EQ(pages.NumPrepared(), 2U); // some, in each round
    EXPECT_EQ(pages.NumAskable(), 1U) << "the provider may ask, too";
    EXPECT_EQ(pool.Statistics().uploads, 2U);
    int numAsked = 0;
    Ask(pool, {0, 1, 2, 3, 4, 5, 6, 7}); // of another render
    pool.ProcessRequests([&] { return ++numAsked == 2; });
    EXPECT_EQ(pool.Statistics().uploads, 6U);
    Ask(pool, {0, 1, 2, 3, 4, 5, 6, 7});
    pool.ProcessRequests([] { return false; });
    EXPECT_EQ(pool.Statistics().uploads, 8U);
    EXPECT_EQ(pool.Statistics().evictions, 0U);
}

TEST_F(StreamingPoolTest, NoPagesIsValid) {
    FakePages pages(Range(0, 0));
    StreamingPool pool(device, "fake");
    pool.Update(&pages, 1000);
    EXPECT_EQ(pool.Bytes(), 0U);
}

} // namespace
} // namespace hds::test
