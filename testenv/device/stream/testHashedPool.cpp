// SPDX-License-Identifier: Apache-2.0
// A pool whose pages kernels look up in hash tables holds what one with a word for each page holds,
// until its tables are full: then pages leave, requests are dropped and counted, and each that is
// repeated is served.
#include "testenv/device/stream/poolFixture.h"

#include <array>
#include <numeric>
#include <random>

namespace hds::test {
namespace {

const char* const kText = R"(
#include "stream/residency.clh"
/* Item i marks page[i] as used (0), asks for it (1), or for all of its group (2); writes its word. */
kernel void probe_hash(global const uint* pages, uint count, uint use, global uint* words,
                       global const uint* hdsChunkAddresses HDS_RESIDENCY_ARGS) {
    const uint i = (uint)get_global_id(0);
    if (i >= count) {
        return;
    }
    HdsResidencyView view;
    HDS_RESIDENCY_VIEW(view);
    words[i] = residency_word(hdsChunkAddresses, pages[i]);
    if (use == 0u) {
        residency_touch(&view, pages[i]);
    } else if (use == 1u) {
        residency_request(&view, pages[i]);
    } else if (use == 2u) {
        residency_useGroup(&view, hdsChunkAddresses, pages[i] & ~1u);
    }
}
)";

class HashedPoolTest : public DeviceFixture {
protected:
    void SetUp() override {
        DeviceFixture::SetUp();
        for (std::size_t isHashed = 0; device && isHashed < 2; ++isHashed) {
            programs[isHashed] =
                Build(kText, {{"HDS_FEATURE_STREAMING", "1"},
                              {"HDS_FEATURE_PAGE_HASH", isHashed != 0 ? "1" : "0"}});
        }
    }

    /// Runs the kernel over pages. \return their words.
    Pages Use(const StreamingPool& pool, const Pages& pages, std::uint32_t use) {
        Kernel kernel = programs[pool.HasPageHash() ? 1 : 0]->GetKernel("probe_hash");
        const Buffer list = Upload(pages);
        const Buffer words = Upload(pages);
        const auto count = static_cast<std::uint32_t>(pages.size());
        kernel.Launch(count, list, count, use, words, pool.Addresses(), pool.Uses());
        device->Finish();
        return Download<std::uint32_t>(words, pages.size());
    }

    std::array<std::unique_ptr<Program>, 2> programs; ///< of direct tables, of hashed ones
    static constexpr std::uint32_t kTouch = 0;
    static constexpr std::uint32_t kAsk = 1;
    static constexpr std::uint32_t kAskWhole = 2;
    static constexpr std::uint32_t kLook = 3;
};

TEST_F(HashedPoolTest, HoldsWhatADirectTableHolds) {
    const std::vector<std::uint64_t> ids = Range(0, 400); // all sizes, some pages are empty
    FakePages pages(ids);
    pages.SetOuterPages(100);
    StreamingPool direct(device, "fake");
    direct.SetHashEntries(1U << 20U);
    StreamingPool hashed(device, "fake");
    hashed.SetHashEntries(256);
    direct.Update(&pages, 20'000);
    hashed.Update(&pages, 20'000);
    ASSERT_FALSE(direct.HasPageHash());
    ASSERT_TRUE(hashed.HasPageHash());
    Pages all(ids.size());
    std::iota(all.begin(), all.end(), 0U);
    std::mt19937 random(7);
    for (int round = 0; round < 40; ++round) {
        Pages asked;
        Pages touched;
        const Pages before = Use(direct, all, kLook);
        while (asked.size() < 12) {
            const std::uint32_t page = random() % 400;
            if (pages.PageBytes(page) > 0 && before[page] == HDS_NOT_RESIDENT) {
                asked.insert(asked.end(), 1 + random() % 5, page);
            } else if (before[page] != HDS_NOT_RESIDENT) {
                touched.push_back(page);
            }
        }
        touched.push_back(touched.empty() ? asked[0] : touched[0]);
        for (StreamingPool* pool : {&direct, &hashed}) {
            if (before[touched[0]] != HDS_NOT_RESIDENT) {
                Use(*pool, touched, kTouch);
            }
            Use(*pool, asked, round % 2 == 0 ? kAsk : kAskWhole);
            pool->ProcessRequests();
        }
        ASSERT_EQ(Use(direct, all, kLook), Use(hashed, all, kLook)) << "round " << round;
    }
    EXPECT_EQ(direct.Statistics().uploads, hashed.Statistics().uploads);
    EXPECT_EQ(direct.Statistics().evictions, hashed.Statistics().evictions);
    EXPECT_GT(hashed.Statistics().evictions, 100U);
    EXPECT_EQ(hashed.Statistics().requestsDropped, 0U);
}

TEST_F(HashedPoolTest, AFullTableMakesPagesLeaveAndDropsRequestsThatAreRepeated) {
    const std::vector<std::uint64_t> ids = EqualIds(300);
    FakePages pages(ids);
    pages.SetOuterPages(100);
    StreamingPool pool(device, "fake");
    pool.SetHashEntries(32);
    pool.Update(&pages, 300 * 160); // room for all
    ASSERT_TRUE(pool.HasPageHash());
    EXPECT_FALSE(pool.HasRoomForAll());
    Pages all(ids.size());
    std::iota(all.begin(), all.end(), 0U);
    Pages waiting = all;
    int rounds = 0;
    for (; !waiting.empty() && rounds < 1000; ++rounds) {
        Use(pool, waiting, kAsk);
        pool.ProcessRequests();
        const Pages words = Use(pool, all, kLook);
        const auto numThere = static_cast<std::uint64_t>(
            300 - std::count(words.begin(), words.end(), HDS_NOT_RESIDENT));
        EXPECT_LE(numThere, 28U);
        EXPECT_EQ(numThere, pool.Statistics().uploads - pool.Statistics().evictions)
            << "kernels find all that are there";
        Pages left;
        std::copy_if(waiting.begin(), waiting.end(), std::back_inserter(left),
                     [&](std::uint32_t page) { return words[page] == HDS_NOT_RESIDENT; });
        EXPECT_LT(left.size(), waiting.size()) << "each round serves one";
        waiting = left;
    }
    EXPECT_TRUE(waiting.empty());
    EXPECT_GE(rounds, 300 / 8); // a bucket of requests has eight
    EXPECT_GT(pool.Statistics().requestsDropped, 1000U);
    EXPECT_GT(pool.Statistics().evictions, 200U);
}

// What finds its bucket full lies in the next, at the end of the table in the first.
TEST_F(HashedPoolTest, PagesOfOneBucketAreAllFound) {
    const std::vector<std::uint64_t> ids = EqualIds(400);
    FakePages pages(ids);
    pages.SetOuterPages(100);
    StreamingPool pool(device, "fake");
    pool.SetHashEntries(64);
    pool.Update(&pages, 400 * 160);
    const std::uint32_t mask = 64 / HDS_BUCKET_PAGES - 1;
    Pages crowded;
    for (std::uint32_t page = 0; page < 400 && crowded.size() < 20; ++page) {
        if (HDS_HASH_BUCKET(page, mask) == mask) {
            crowded.push_back(page);
        }
    }
    ASSERT_EQ(crowded.size(), 20U);
    for (std::size_t i = 0; i < crowded.size(); i += 4) {
        Use(pool, Pages(crowded.begin() + i, crowded.begin() + i + 4), kAsk);
        pool.ProcessRequests();
        const Pages words = Use(pool, crowded, kLook);
        EXPECT_EQ(crowded.size() - std::count(words.begin(), words.end(), HDS_NOT_RESIDENT), i + 4);
    }
    Use(pool, crowded, kTouch);
    pool.BeginStatistics(); // a new epoch
    Use(pool, {crowded[19]}, kTouch);
    pool.CountUsed();
    EXPECT_EQ(pool.Statistics().chunksUsed, 1U) << "its own use, and no other";
}

TEST_F(HashedPoolTest, ThoseWithoutOuterPagesAndSmallOnesHaveAWordForEachPage) {
    const std::vector<std::uint64_t> ids = EqualIds(300);
    FakePages pages(ids);
    StreamingPool pool(device, "fake");
    pool.SetHashEntries(32);
    pool.Update(&pages, 3000);
    EXPECT_FALSE(pool.HasPageHash()); // no page is reached through others
    pages.SetOuterPages(100);
    pool.SetHashEntries(0);
    pool.Update(&pages, 3000);
    EXPECT_TRUE(pool.HasPageHash()); // of 32 entries
    EXPECT_LT(pool.TableBytes(), 300 * 8U);
    pool.Update(&pages, 48'000);
    EXPECT_FALSE(pool.HasPageHash()); // all pages fit
    pool.SetHashEntries(512);
    pool.Update(&pages, 3000);
    EXPECT_FALSE(pool.HasPageHash());
}

} // namespace
} // namespace hds::test
