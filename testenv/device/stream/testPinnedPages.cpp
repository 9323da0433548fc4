// SPDX-License-Identifier: Apache-2.0
// Pages that should stay are loaded once, up to a quarter of the pool; whatever is pinned, the
// largest group finds room.
#include "testenv/device/stream/poolFixture.h"

#include <algorithm>
#include <numeric>
#include <random>

namespace hds::test {
namespace {

class PinnedPages : public StreamingPoolTest {
protected:
    /// A round for the group of each page that is not there.
    void AskForGroups(StreamingPool* pool, const std::vector<std::uint64_t>& ids,
                      const Pages& groups) {
        for (const std::uint32_t group : groups) {
            const auto words = Table(*pool, ids);
            const bool isThere = IsThere(words[2 * group]) && IsThere(words[2 * group + 1]);
            if (!isThere) {
                AskWhole(*pool, {2 * group});
                pool->ProcessRequests();
            }
        }
    }
    static bool IsThere(std::uint32_t word) { return (word & ~HDS_PAGE_DONE) != HDS_NOT_RESIDENT; }
    static Pages AllPages(std::uint32_t count) {
        Pages all(count);
        std::iota(all.begin(), all.end(), 0U);
        return all;
    }
    static Pages ShuffledGroups(std::uint32_t count, unsigned seed) {
        Pages groups = AllPages(count);
        std::shuffle(groups.begin(), groups.end(), std::mt19937(seed));
        return groups;
    }
    /// Which of the pages are resident.
    Pages Among(const StreamingPool& pool, const std::vector<std::uint64_t>& ids,
                const Pages& pages) {
        const auto words = Table(pool, ids);
        Pages found;
        std::copy_if(pages.begin(), pages.end(), std::back_inserter(found),
                     [&](std::uint32_t page) { return IsThere(words[page]); });
        return found;
    }
};

TEST_F(PinnedPages, OnceLoadedTheyStay) {
    const std::vector<std::uint64_t> ids = EqualIds(80);
    FakePages pages(ids);
    const Pages lights = {10, 11, 40, 41, 66, 67};
    pages.Keep(lights);
    StreamingPool pool(device, "fake");
    pool.Update(&pages, 24 * 160);
    EXPECT_EQ(pool.PinnedBytes(), 0U) << "nobody has asked for them";
    AskForGroups(&pool, ids, {20, 5});
    EXPECT_EQ(pool.PinnedBytes(), 4U * 160);
    AskForGroups(&pool, ids, {33});
    EXPECT_EQ(pool.PinnedBytes(), 6U * 160);
    for (unsigned seed = 0; seed < 4; ++seed) {
        AskForGroups(&pool, ids, ShuffledGroups(40, seed));
        EXPECT_EQ(Among(pool, ids, lights), lights);
    }
    EXPECT_GT(pool.Statistics().evictions, 100U);
    EXPECT_EQ(pool.PinnedBytes(), 6U * 160);
}

TEST_F(PinnedPages, TakeAQuarterOfThePoolAtMost) {
    const std::vector<std::uint64_t> ids = EqualIds(80);
    FakePages pages(ids);
    pages.Keep(AllPages(80));
    StreamingPool pool(device, "fake");
    const std::uint64_t budget = 23 * 160;
    pool.Update(&pages, budget);
    for (unsigned seed = 0; seed < 3; ++seed) {
        AskForGroups(&pool, ids, ShuffledGroups(40, seed));
        EXPECT_LE(pool.PinnedBytes(), budget / 4);
    }
    EXPECT_EQ(pool.PinnedBytes(), 4U * 160) << "two whole groups";
    EXPECT_EQ(Among(pool, ids, {0, 1, 2, 3}), (Pages{0, 1, 2, 3}));
}

TEST_F(PinnedPages, LeaveRoomForTheLargestGroup) {
    const std::vector<std::uint64_t> ids = Range(0, 400); // all sizes, some pages are empty
    FakePages pages(ids);
    pages.Keep(AllPages(400));
    std::uint64_t largest = 0;
    for (std::uint32_t page = 0; page < 400; page += 2) {
        largest = std::max(largest, pages.PageBytes(page) + pages.PageBytes(page + 1));
    }
    for (const std::uint64_t spare : {0U, 160U, 1600U, 16000U}) {
        StreamingPool pool(device, "fake");
        pool.Update(&pages, largest + spare);
        for (const std::uint32_t group : ShuffledGroups(200, 3)) {
            const auto isThere = [&](std::uint32_t page) {
                return pages.PageBytes(page) == 0 || IsThere(Table(pool, ids)[page]);
            };
            if (!isThere(2 * group) || !isThere(2 * group + 1)) {
                AskWhole(pool, {2 * group});
                pool.ProcessRequests();
            }
            ASSERT_TRUE(isThere(2 * group) && isThere(2 * group + 1)) << group;
            ASSERT_LE(pool.PinnedBytes(), std::min((largest + spare) / 4, spare));
        }
        EXPECT_TRUE(spare < 16000 || pool.PinnedBytes() > 0);
    }
}

TEST_F(PinnedPages, FlushKnowsNone) {
    const std::vector<std::uint64_t> ids = EqualIds(20);
    FakePages pages(ids);
    pages.Keep({0, 1});
    StreamingPool pool(device, "fake", std::make_unique<FlushOrder>());
    pool.Update(&pages, 8 * 160);
    AskForGroups(&pool, ids, {0, 1, 2, 3, 4});
    EXPECT_EQ(pool.PinnedBytes(), 0U);
    EXPECT_TRUE(Among(pool, ids, {0, 1}).empty());
}

TEST_F(PinnedPages, EditsPinAndUnpin) {
    const std::vector<std::uint64_t> ids = EqualIds(80);
    FakePages pages(ids);
    pages.Keep({0, 1, 2, 3});
    StreamingPool pool(device, "fake");
    pool.Update(&pages, 24 * 160);
    AskForGroups(&pool, ids, {0, 1, 7});
    EXPECT_EQ(pool.PinnedBytes(), 4U * 160);
    FakePages edited(ids); // another light; one less, whose pages remain
    edited.Keep({2, 3, 60, 61});
    pool.Update(&edited, 24 * 160);
    EXPECT_EQ(pool.PinnedBytes(), 2U * 160);
    EXPECT_EQ(Among(pool, ids, {2, 3, 14, 15}), (Pages{2, 3, 14, 15})) << "others stay";
    AskForGroups(&pool, ids, ShuffledGroups(40, 1));
    AskForGroups(&pool, ids, ShuffledGroups(40, 2));
    EXPECT_EQ(pool.PinnedBytes(), 4U * 160);
    EXPECT_EQ(Among(pool, ids, {2, 3, 60, 61}), (Pages{2, 3, 60, 61}));
    FakePages dark(ids);
    pool.Update(&dark, 24 * 160);
    EXPECT_EQ(pool.PinnedBytes(), 0U);
    AskForGroups(&pool, ids, ShuffledGroups(40, 3));
}

} // namespace
} // namespace hds::test
