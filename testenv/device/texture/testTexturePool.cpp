// SPDX-License-Identifier: Apache-2.0
// Items that look texels up and come again until all are there get the texels, whatever the pool.
#include "hdStream/texture/residentTextures.h"
#include "hdStream/texture/texelWaiters.h"
#include "testenv/support/deviceFixture.h"
#include "testenv/support/fakeTextures.h"

#include <algorithm>
#include <iterator>
#include <numeric>
#include <random>

namespace hds::test {
namespace {

const char* const kProbeText = R"(
#include "texture/cache.clh"
/* Item queue[first + id] reads its taps (texture, mip, x, y); results are written when all are
 * there. */
kernel void probe_read(HDS_TEXTURE_ARGS, global const uint4* taps, uint numTaps,
                       global const uint* queue, uint count, global uint* results) {
    const uint id = (uint)get_global_id(0);
    if (id >= count) {
        return;
    }
    const uint item = queue[id];
    HdsTextureView view;
    HDS_TEXTURE_VIEW(view);
    bool isMissing = false;
    for (uint i = 0u; i < numTaps; ++i) {
        const uint4 tap = taps[item * numTaps + i];
        HdsFoundTexel found;
        cache_findTexel(&view, tap.x, tap.y, tap.z, tap.w, &found, &isMissing);
    }
    if (isMissing) {
        texture_count(&view);
        texture_wait(&view, item);
        return;
    }
    for (uint i = 0u; i < numTaps; ++i) {
        const uint4 tap = taps[item * numTaps + i];
        HdsFoundTexel found = {0, 0, 0};
        bool isFound = cache_findTexel(&view, tap.x, tap.y, tap.z, tap.w, &found, &isMissing);
        results[item * numTaps + i] =
            isFound ? found.line[(found.y * 16u + found.x) % 128u] : 0u;
    }
    texture_count(&view);
}
)";

struct Tap {
    std::uint32_t texture;
    std::uint32_t mip;
    std::uint32_t x;
    std::uint32_t y;
};

/// Where a tap lies, and what it reads.
LineId LineOf(const FakeTextures& textures, const Tap& tap, std::uint32_t* word) {
    const shared::HdsTexture record = textures.Record(tap.texture);
    const shared::HdsTexelPlace place =
        shared::texture_place(record.width, record.format, record.flags, record.numLines,
                              record.mipBlock[tap.mip], tap.mip, tap.x, tap.y);
    *word = (place.y * 16 + place.x) % kLineWords;
    return {tap.texture, place.line};
}

std::uint32_t Expected(const FakeTextures& textures, const Tap& tap) {
    std::uint32_t word = 0;
    const LineId line = LineOf(textures, tap, &word);
    return FakeWord(textures.TextureId(tap.texture), line.line, word);
}

std::vector<FakeTexture> MixedTextures() {
    return {{10, 300, 200},
            {11, 1, 1},
            {12, 512, 1},
            {13, 64, 64, HDS_TEXEL_U8},
            {14, 33, 77, HDS_TEXEL_HALF | 2U},
            {15, 128, 128, HDS_TEXEL_FLOAT | 2U},
            {16, 5, 1000, HDS_TEXEL_U16 | 1U},
            {17, 256, 256}};
}

std::vector<Tap> RandomTaps(const FakeTextures& textures, std::size_t count, unsigned seed) {
    std::mt19937 random(seed);
    std::vector<Tap> taps;
    for (std::size_t i = 0; i < count; ++i) {
        Tap tap{};
        tap.texture = random() % textures.NumTextures();
        const shared::HdsTexture record = textures.Record(tap.texture);
        tap.mip = random() % 3 == 0 ? random() % record.numMips : 0;
        tap.x = random() % shared::texture_mipSize(record.width, tap.mip);
        tap.y = random() % shared::texture_mipSize(record.height, tap.mip);
        taps.push_back(tap);
    }
    return taps;
}

class TexturePoolTest : public DeviceFixture {
protected:
    void SetUp() override {
        DeviceFixture::SetUp();
        if (device) {
            program = Build(kProbeText, {{"HDS_FEATURE_TEXTURE_STREAMING", "1"}});
            probe = program->GetKernel("probe_read");
        }
    }

    void Launch(const TextureBinding& binding, const std::vector<std::uint32_t>& items) {
        const Buffer queue = Upload(items);
        probe.KeepFirst(binding.Bind(&probe, 0));
        probe.Launch(items.size(), tapBuffer, numTaps, queue,
                     static_cast<std::uint32_t>(items.size()), resultBuffer);
        device->Finish();
    }
    /// Launches items; those that wait come back.
    std::vector<std::uint32_t> Launch(TexturePool* pool, const std::vector<std::uint32_t>& items) {
        Launch(pool->Binding(), items);
        return pool->TakeWaiting();
    }

    /// Reads all taps, numTaps an item, until none waits or has waited `iterations` times.
    std::vector<std::uint32_t> Read(TexturePool* pool, const std::vector<Tap>& list,
                                    std::uint32_t tapsPerItem, int iterations = 0) {
        numTaps = tapsPerItem;
        const auto numItems = static_cast<std::uint32_t>(list.size() / numTaps);
        tapBuffer = Upload(list);
        resultBuffer = Allocate(list.size() * 4);
        std::vector<std::uint32_t> items(numItems);
        std::iota(items.begin(), items.end(), 0U);
        pool->ReserveItems(numItems);
        TexelWaiters waiters(numItems, Launch(pool, items));
        numRequestRounds = 0;
        while (!waiters.IsEmpty()) {
            waiters.Continue(pool->ProcessRequests(waiters.NumItems()));
            ++numRequestRounds;
            pool->SetAcceptsCoarserMips(iterations > 0 && numRequestRounds >= iterations);
            waiters.Return(Launch(pool, waiters.Take()));
            EXPECT_LT(numRequestRounds, 20000);
            if (numRequestRounds >= 20000) {
                break;
            }
        }
        pool->SetAcceptsCoarserMips(false);
        pool->ExpectAnyItems();
        pool->CollectCounts();
        return Download<std::uint32_t>(resultBuffer, list.size());
    }

    static void ExpectExact(const FakeTextures& textures, const std::vector<Tap>& list,
                            const std::vector<std::uint32_t>& values) {
        EXPECT_FALSE(textures.isMisused);
        std::size_t numWrong = 0;
        for (std::size_t i = 0; i < list.size(); ++i) {
            numWrong += values[i] != Expected(textures, list[i]) ? 1 : 0;
        }
        EXPECT_EQ(numWrong, 0U) << "of " << list.size();
    }

    std::unique_ptr<Program> program;
    Kernel probe;
    std::uint32_t numTaps = 1;
    Buffer tapBuffer;
    Buffer resultBuffer;
    int numRequestRounds = 0;
};

TEST_F(TexturePoolTest, IsExactAtEveryBudgetThatHoldsOneItem) {
    FakeTextures textures(MixedTextures());
    const std::vector<Tap> list = RandomTaps(textures, 12 * 500, 1);
    const std::uint64_t all = textures.TotalLines() * HDS_LINE_BYTES;
    for (const std::uint64_t budget :
         {std::uint64_t{12} * HDS_LINE_BYTES, std::uint64_t{13} * HDS_LINE_BYTES + 100, all / 20,
          all / 3, all, 4 * all}) {
        const std::uint64_t before = device->AllocatedBytes();
        TexturePool pool(device);
        pool.Update(&textures, budget, 12);
        EXPECT_LE(pool.Bytes(), budget);
        ExpectExact(textures, list, Read(&pool, list, 12));
        EXPECT_EQ(device->AllocatedBytes() - before - tapBuffer.Bytes() - resultBuffer.Bytes(),
                  pool.Bytes() + pool.TableBytes())
            << "the device's own ledger";
        EXPECT_EQ(pool.Statistics().fallbackTexels, 0U);
        EXPECT_LE(pool.Statistics().uniqueBytesLoaded, pool.Statistics().uploadedBytes);
        if (budget > 2 * all) {
            EXPECT_EQ(pool.Statistics().uniqueBytesLoaded, pool.Statistics().uploadedBytes);
            EXPECT_EQ(pool.Statistics().evictions, 0U);
        }
        tapBuffer = Buffer();
        resultBuffer = Buffer();
    }
}

TEST_F(TexturePoolTest, ABudgetBelowOneItemIsAnErrorThatNamesTheOption) {
    FakeTextures textures(MixedTextures());
    TexturePool pool(device);
    try {
        pool.Update(&textures, 12 * HDS_LINE_BYTES - 1, 12);
        FAIL();
    } catch (const Error& error) {
        EXPECT_NE(std::string(error.what()).find("--textureMemory"), std::string::npos);
        EXPECT_NE(std::string(error.what()).find("6144"), std::string::npos);
    }
    EXPECT_THROW(pool.Update(&textures, 7 * HDS_LINE_BYTES, 1), Error);
    EXPECT_NO_THROW(pool.Update(&textures, 12 * HDS_LINE_BYTES, 12));
}

TEST_F(TexturePoolTest, GridsHaveABudgetOfTheirOwn) {
    FakeTextures textures({{20, 256, 256}, {21, 512, 512}, {22, 512, 512}});
    textures.numGrids = 2;
    const std::vector<Tap> both = RandomTaps(textures, 4 * 1500, 9);
    std::vector<Tap> images;
    std::copy_if(both.begin(), both.end(), std::back_inserter(images),
                 [](const Tap& tap) { return tap.texture == 0; });
    TexturePool pool(device);
    constexpr std::uint64_t kGrids = 40 * HDS_LINE_BYTES;
    textures.maxLines = textures.TotalLines();
    pool.Update(&textures, 1U << 20U, 8, {kGrids, 4});
    ExpectExact(textures, both, Read(&pool, both, 4));
    const TextureStatistics cold = pool.Statistics();
    EXPECT_GT(cold.grids.evictions, 1000U);
    EXPECT_EQ(cold.evictions, cold.grids.evictions) << "images have room";
    EXPECT_EQ(cold.uploadedBytes - cold.grids.uploadedBytes,
              cold.uniqueBytesLoaded - cold.grids.uniqueBytesLoaded);
    EXPECT_LE(pool.GridPeakUsedBytes(), kGrids);
    EXPECT_GE(pool.GridPeakUsedBytes(), kGrids / 2);
    EXPECT_LT(pool.GridPeakUsedBytes(), pool.PeakUsedBytes());
    ExpectExact(textures, images, Read(&pool, images, 1));
    EXPECT_EQ(pool.Statistics().uploadedBytes, cold.uploadedBytes) << "no grid took their place";
    // Another budget of grids: nothing is lost but what was in the pool.
    pool.Update(&textures, 1U << 20U, 8, {0, 4});
    EXPECT_EQ(pool.GridPeakUsedBytes(), 0U) << "they share";
    ExpectExact(textures, both, Read(&pool, both, 4));
}

TEST_F(TexturePoolTest, GridsAloneNeedNoTextureMemory) {
    FakeTextures textures({{20, 256, 256}, {21, 64, 64}});
    textures.numGrids = 2;
    textures.maxLines = textures.TotalLines();
    TexturePool pool(device);
    pool.Update(&textures, 0, 8, {64 * HDS_LINE_BYTES, 4});
    EXPECT_LE(pool.Bytes(), 64U * HDS_LINE_BYTES);
    const std::vector<Tap> list = RandomTaps(textures, 1000, 9);
    ExpectExact(textures, list, Read(&pool, list, 1));
    try {
        pool.Update(&textures, 0, 8, {8 * HDS_LINE_BYTES - 1, 4});
        FAIL();
    } catch (const Error& error) {
        EXPECT_NE(std::string(error.what()).find("--volumeMemory"), std::string::npos);
        EXPECT_NE(std::string(error.what()).find("4096"), std::string::npos);
    }
}

TEST_F(TexturePoolTest, LinesOfOneSetNeededAtOnce) {
    // A pool of 40 slots has few sets: an item's 24 lines are a multiple of the sets apart.
    FakeTextures textures({{20, 16, 16 * 600}});
    TexturePool pool(device);
    pool.Update(&textures, 40 * HDS_LINE_BYTES, 24);
    const SlotPlan plan = MakeSlotPlan(40, 24, 128);
    std::vector<Tap> list;
    for (std::uint32_t item = 0; item < 9; ++item) {
        for (std::uint32_t i = 0; i < 24; ++i) {
            list.push_back({0, 0, item, 16 * (item + i * plan.numSets * 3) + item});
        }
    }
    ExpectExact(textures, list, Read(&pool, list, 24));
    EXPECT_GT(pool.Statistics().setConflicts, 0U);
}

TEST_F(TexturePoolTest, TexturesNobodyTouchesAreNotOpened) {
    FakeTextures textures(MixedTextures());
    TexturePool pool(device);
    pool.Update(&textures, 1U << 20U, 8);
    const std::vector<Tap> list = {{7, 0, 200, 100}, {7, 2, 3, 3}, {1, 0, 0, 0}};
    ExpectExact(textures, list, Read(&pool, list, 1));
    EXPECT_EQ(textures.opened, (std::set<std::uint32_t>{1, 7}));
    EXPECT_EQ(textures.numOpens, 2U);
    EXPECT_EQ(pool.Statistics().openedTextures, 2U);
    EXPECT_EQ(numRequestRounds, 2); // one opens, one loads
    // Tails of both, and the line of each tap (texture 1 is its tail).
    EXPECT_EQ(pool.Statistics().linesLoaded, 4U);
    EXPECT_EQ(textures.numReads, 4U);
}

TEST_F(TexturePoolTest, MoreMissesThanRequestsFit) {
    FakeTextures textures(MixedTextures());
    const std::vector<Tap> list = RandomTaps(textures, 3000, 2);
    TexturePool pool(device, nullptr, 5);
    pool.Update(&textures, 4U << 20U, 8);
    ExpectExact(textures, list, Read(&pool, list, 1));
    EXPECT_GT(pool.Statistics().droppedRequests, 0U);
    EXPECT_EQ(pool.Statistics().uploadedBytes, pool.Statistics().uniqueBytesLoaded);
}

TEST_F(TexturePoolTest, CoarsestMipsStay) {
    FakeTextures textures({{30, 512, 512}, {31, 512, 512}});
    TexturePool pool(device);
    pool.Update(&textures, 64 * HDS_LINE_BYTES, 8);
    const std::vector<Tap> tails = {{0, 9, 0, 0}, {1, 9, 0, 0}};
    Read(&pool, tails, 1);
    const std::vector<Tap> list = RandomTaps(textures, 3000, 3);
    Read(&pool, list, 1);
    EXPECT_GT(pool.Statistics().evictions, 100U);
    ExpectExact(textures, tails, Read(&pool, tails, 1));
    EXPECT_EQ(numRequestRounds, 0);
    EXPECT_GE(pool.PinnedBytes(), 2U * HDS_LINE_BYTES);
}

TEST_F(TexturePoolTest, CountsEveryTap) {
    FakeTextures textures(MixedTextures());
    const std::vector<Tap> list = RandomTaps(textures, 4 * 1000, 4);
    TexturePool pool(device);
    pool.Update(&textures, 4U << 20U, 8);
    Read(&pool, list, 4);
    const TextureStatistics cold = pool.Statistics();
    EXPECT_GT(cold.misses, 0U);
    EXPECT_LT(cold.misses, cold.lookups);
    EXPECT_EQ(cold.droppedRequests, 0U) << "also where few items are left, and the set is small";
    Read(&pool, list, 4);
    // The probe looks twice: to see whether all is there, and to read.
    EXPECT_EQ(pool.Statistics().lookups - cold.lookups, 2 * list.size());
    EXPECT_EQ(pool.Statistics().misses, cold.misses);
}

TEST_F(TexturePoolTest, AcceptedTexelsComeFromTheNearestCoarserMip) {
    FakeTextures textures({{40, 256, 256}});
    TexturePool pool(device);
    pool.Update(&textures, 1U << 20U, 8);
    // Mip 2 is loaded, then a texel of mip 0 below it.
    const Tap coarse{0, 2, 20, 13};
    Read(&pool, {coarse}, 1);
    const Tap fine{0, 0, 83, 55};
    pool.SetAcceptsCoarserMips(true);
    numTaps = 1;
    tapBuffer = Upload(std::vector<Tap>{fine});
    EXPECT_TRUE(Launch(&pool, {0}).empty());
    EXPECT_EQ(Download<std::uint32_t>(resultBuffer, 1)[0], Expected(textures, coarse));
    pool.SetAcceptsCoarserMips(false);
    pool.CollectCounts();
    EXPECT_EQ(pool.Statistics().fallbackTexels, 2U); // looks twice
    // What it asked for comes with the next round.
    EXPECT_EQ(pool.ProcessRequests().numLoaded, 1U);
    EXPECT_TRUE(Launch(&pool, {0}).empty());
    EXPECT_EQ(Download<std::uint32_t>(resultBuffer, 1)[0], Expected(textures, fine));
}

TEST_F(TexturePoolTest, WhatFewAndManyHaveAskedForIsLoadedOnce) {
    FakeTextures textures({{40, 256, 256}});
    TexturePool pool(device);
    pool.Update(&textures, 1U << 20U, 8);
    const Tap fine{0, 0, 83, 55};
    Read(&pool, {{0, 2, 20, 13}}, 1);
    numTaps = 1;
    tapBuffer = Upload(std::vector<Tap>{fine});
    pool.SetAcceptsCoarserMips(true); // they ask, and do not wait
    EXPECT_EQ(pool.ProcessRequests(1).numLoaded, 0U);
    EXPECT_TRUE(Launch(&pool, {0}).empty());
    pool.ExpectAnyItems();
    EXPECT_TRUE(Launch(&pool, {0}).empty()); // its place in the set is another one now
    EXPECT_EQ(pool.ProcessRequests(1).numLoaded, 1U);
    pool.SetAcceptsCoarserMips(false);
    EXPECT_TRUE(Launch(&pool, {0}).empty());
    EXPECT_EQ(Download<std::uint32_t>(resultBuffer, 1)[0], Expected(textures, fine));
    // Nothing is left in either set that would keep the same lines from being asked for again.
    const std::vector<Tap> list = RandomTaps(textures, 2000, 8);
    pool.Update(&textures, 16 * HDS_LINE_BYTES, 8);
    ExpectExact(textures, list, Read(&pool, list, 1));
}

TEST_F(TexturePoolTest, InteractiveRendersEndAfterTheirIterations) {
    FakeTextures textures(MixedTextures());
    const std::vector<Tap> list = RandomTaps(textures, 12 * 500, 5);
    TexturePool pool(device);
    pool.Update(&textures, 40 * HDS_LINE_BYTES, 12);
    Read(&pool, list, 12, 2);
    EXPECT_GT(pool.Statistics().fallbackTexels, 0U);
    EXPECT_LT(numRequestRounds, 20);
}

TEST_F(TexturePoolTest, LinesOfOneRepeatedBlockShareASlot) {
    FakeTextures textures({{50, 512, 512}, {53, 512, 512}});
    TexturePool pool(device);
    pool.Update(&textures, 4U << 20U, 8);
    std::vector<Tap> list;
    for (std::uint32_t line = 0; line < 1024; ++line) {
        list.push_back({line / 512, 0, line % 32 * 16, line / 32 % 16 * 16});
    }
    ExpectExact(textures, list, Read(&pool, list, 1));
    const TextureStatistics& statistics = pool.Statistics();
    EXPECT_EQ(statistics.linesLoaded, 1024U + 2U);
    // 512 lines of each, 47 or 46 of which repeat the same block; two coarsest mips.
    const std::uint64_t repeated = 2 * ((512 - 5 + 10) / 11);
    EXPECT_EQ(statistics.uploadedBytes, (1026 - repeated + 1) * HDS_LINE_BYTES);
    EXPECT_EQ(statistics.uniqueBytesLoaded, statistics.uploadedBytes);
}

TEST_F(TexturePoolTest, WhatIsLoadedStaysFromSceneToScene) {
    FakeTextures before({{60, 128, 128}, {61, 128, 128}, {62, 64, 64}});
    TexturePool pool(device);
    pool.Update(&before, 1U << 20U, 8);
    const std::vector<Tap> list = RandomTaps(before, 500, 6);
    ExpectExact(before, list, Read(&pool, list, 1));
    const std::uint64_t uploaded = pool.Statistics().uploadedBytes;

    FakeTextures after({{62, 64, 64}, {63, 128, 128}, {60, 128, 128}});
    pool.Update(&after, 1U << 20U, 8);
    std::vector<Tap> kept;
    for (Tap tap : list) {
        if (tap.texture != 1) {
            tap.texture = tap.texture == 0 ? 2 : 0;
            kept.push_back(tap);
        }
    }
    ExpectExact(after, kept, Read(&pool, kept, 1));
    EXPECT_EQ(numRequestRounds, 0);
    const std::vector<Tap> others = RandomTaps(after, 500, 7);
    ExpectExact(after, others, Read(&pool, others, 1));
    EXPECT_GT(pool.Statistics().uploadedBytes, uploaded);
    pool.Update(&after, 64 * HDS_LINE_BYTES, 8); // another budget
    EXPECT_LE(pool.Bytes(), 64U * HDS_LINE_BYTES);
    ExpectExact(after, others, Read(&pool, others, 1));
}

TEST_F(TexturePoolTest, RequestsOfAStoppedRenderAreForgotten) {
    FakeTextures before({{70, 128, 128}});
    TexturePool pool(device);
    pool.Update(&before, 1U << 20U, 8);
    Read(&pool, {{0, 0, 0, 0}}, 1);
    tapBuffer = Upload(std::vector<Tap>{{0, 0, 100, 100}});
    EXPECT_EQ(Launch(&pool, {0}).size(), 1U); // asks, and nobody answers
    FakeTextures after({{71, 128, 128}});
    pool.Update(&after, 1U << 20U, 8);
    EXPECT_EQ(pool.ProcessRequests().numLoaded, 0U);
    const std::vector<Tap> list = RandomTaps(after, 100, 8);
    ExpectExact(after, list, Read(&pool, list, 1));
}

TEST_F(TexturePoolTest, WhoCancelsWaitsForOneImageOrBatchOnly) {
    std::vector<FakeTexture> list;
    for (std::uint64_t id = 80; id < 88; ++id) {
        list.push_back({id, 512, 512});
    }
    FakeTextures textures(list);
    TexturePool pool(device);
    pool.Update(&textures, 8U << 20U, 8);
    const std::vector<Tap> taps = RandomTaps(textures, 20000, 9);
    numTaps = 1;
    tapBuffer = Upload(taps);
    resultBuffer = Allocate(taps.size() * 4);
    std::vector<std::uint32_t> items(taps.size());
    std::iota(items.begin(), items.end(), 0U);
    const auto cancelled = [&](const LineProvider::IsCancelled& isCancelled) {
        pool.ReserveItems(static_cast<std::uint32_t>(items.size()));
        EXPECT_FALSE(Launch(&pool, items).empty());
        const TexturePool::Outcome outcome =
            pool.ProcessRequests(TexturePool::kAnyItems, isCancelled);
        EXPECT_TRUE(outcome.isCancelled);
        return outcome.numLoaded;
    };
    EXPECT_EQ(cancelled([] { return true; }), 0U);
    EXPECT_EQ(textures.numOpens, 1U);
    EXPECT_EQ(pool.Statistics().openedTextures, 0U);
    // Coarsest lines are loaded whatever is asked.
    pool.ReserveItems(static_cast<std::uint32_t>(items.size()));
    Launch(&pool, items);
    int numAsked = 0;
    pool.ProcessRequests(TexturePool::kAnyItems, [&] { return ++numAsked == 9; });
    EXPECT_EQ(numAsked, 8);
    EXPECT_EQ(pool.Statistics().linesLoaded, 8U);
    // Of the lines one batch of 2048, until the next is read; then until the next is begun.
    for (const int last : {3, 2}) {
        const std::uint64_t before = pool.Statistics().linesLoaded;
        numAsked = 0;
        EXPECT_EQ(cancelled([&] { return ++numAsked == last; }), 2048U);
        EXPECT_EQ(numAsked, last);
        EXPECT_EQ(pool.Statistics().linesLoaded, before + 2048U);
    }
    ExpectExact(textures, taps, Read(&pool, taps, 1));
    EXPECT_FALSE(textures.isMisused);
}

TEST_F(TexturePoolTest, AKnownTotalBoundsThePool) {
    FakeTextures textures(MixedTextures());
    textures.maxLines = textures.TotalLines();
    TexturePool pool(device);
    pool.Update(&textures, std::uint64_t{1} << 40U, 12);
    EXPECT_LT(pool.Bytes(), 2 * textures.TotalLines() * HDS_LINE_BYTES);
    std::vector<Tap> list;
    for (int i = 0; i < 4; ++i) {
        const std::vector<Tap> more =
            RandomTaps(textures, 12 * 500, 10U + static_cast<unsigned>(i));
        list.insert(list.end(), more.begin(), more.end());
    }
    ExpectExact(textures, list, Read(&pool, list, 12));
    EXPECT_EQ(pool.Statistics().evictions, 0U);
    EXPECT_EQ(pool.Statistics().setConflicts, 0U);
}

TEST_F(TexturePoolTest, APoolWithRoomForAllKeepsNoMarks) {
    FakeTextures textures({{80, 300, 200}, {81, 512, 512}});
    TexturePool marked(device);
    marked.Update(&textures, std::uint64_t{1} << 22U, 8); // of how many lines is not known
    textures.maxLines = textures.TotalLines();
    TexturePool pool(device);
    pool.Update(&textures, std::uint64_t{1} << 22U, 8);
    EXPECT_LE(pool.TableBytes() + 4 * pool.Bytes() / HDS_LINE_BYTES, marked.TableBytes());
    // Edits change which lines there are: those that have gone make room, for nothing else does.
    for (std::uint64_t id = 90; id < 96; ++id) {
        FakeTextures after({{id, 300, 200}, {id + 10, 512, 512}});
        after.maxLines = after.TotalLines();
        pool.Update(&after, std::uint64_t{1} << 22U, 8);
        const std::vector<Tap> list = RandomTaps(after, 8 * 400, static_cast<unsigned>(id));
        ExpectExact(after, list, Read(&pool, list, 8));
    }
    EXPECT_EQ(pool.Statistics().evictions, 0U);
    // A smaller budget takes lines away again.
    FakeTextures last({{106, 512, 512}});
    last.maxLines = last.TotalLines();
    pool.Update(&last, 64 * HDS_LINE_BYTES, 8);
    const std::vector<Tap> list = RandomTaps(last, 8 * 100, 3);
    ExpectExact(last, list, Read(&pool, list, 8));
    EXPECT_GT(pool.Statistics().evictions, 0U);
}

TEST_F(TexturePoolTest, ResidentTexturesReadTheSame) {
    FakeTextures textures(MixedTextures());
    program = Build(kProbeText, {{"HDS_FEATURE_TEXTURE_STREAMING", "0"}});
    probe = program->GetKernel("probe_read");
    ResidentTextures resident(device);
    resident.Update(&textures);
    EXPECT_EQ(resident.Bytes(), textures.TotalLines() * HDS_LINE_BYTES);
    const std::vector<Tap> list = RandomTaps(textures, 5000, 20);
    numTaps = 1;
    tapBuffer = Upload(list);
    resultBuffer = Allocate(list.size() * 4);
    std::vector<std::uint32_t> items(list.size());
    std::iota(items.begin(), items.end(), 0U);
    Launch(resident.Binding(), items);
    ExpectExact(textures, list, Download<std::uint32_t>(resultBuffer, list.size()));
    resident.Update(&textures);
    EXPECT_EQ(textures.numOpens, textures.NumTextures());
}

TEST_F(TexturePoolTest, SlotsBeyondTheFirstBuffer) {
    if (LineBuffers::MaxSlots(*device) <= LineBuffers::kSlotsPerBuffer ||
        device->Properties().memoryBytes < (std::uint64_t{5} << 30U)) {
        GTEST_SKIP() << "needs a device with more than 1 GiB for a pool";
    }
    FakeTextures textures(MixedTextures());
    TexturePool pool(device);
    const std::uint64_t budget =
        (LineBuffers::kSlotsPerBuffer + 2048) * std::uint64_t{HDS_LINE_BYTES};
    pool.Update(&textures, budget, 8);
    EXPECT_EQ(pool.NumBuffers(), 2U);
    // The coarsest mips are pinned, behind the sets.
    std::vector<Tap> list;
    for (std::uint32_t texture = 0; texture < textures.NumTextures(); ++texture) {
        list.push_back({texture, textures.Record(texture).numMips - 1, 0, 0});
    }
    ExpectExact(textures, list, Read(&pool, list, 1));
    EXPECT_GE(pool.PinnedBytes(), HDS_LINE_BYTES);
    const std::vector<Tap> others = RandomTaps(textures, 500, 21);
    ExpectExact(textures, others, Read(&pool, others, 1));
}

} // namespace
} // namespace hds::test
