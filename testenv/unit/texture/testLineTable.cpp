// SPDX-License-Identifier: Apache-2.0
// The table of lines against a map: what kernels would read after each batch of updates.
#include "hdStream/base/error.h"
#include "hdStream/texture/lineTable.h"
#include "hdStream/texture/openTextures.h"
#include "hdStream/texture/texelWaiters.h"
#include "testenv/support/fakeTextures.h"

#include <gtest/gtest.h>

#include <algorithm>

#include <map>
#include <random>

namespace hds::test {
namespace {

TEST(LineTable, UpdatesGiveKernelsTheSameTable) {
    std::mt19937 random(5);
    LineTable table;
    std::map<std::uint32_t, std::uint32_t> expected;
    std::vector<std::uint32_t> device; // what the device has
    std::uint32_t numLines = 300;
    for (int round = 0; round < 60; ++round) {
        table.Reserve(numLines);
        for (int change = 0; change < 50; ++change) {
            const std::uint32_t line = random() % numLines;
            const std::uint32_t slot = random() % 4 == 0 ? HDS_NONE : random() % 1000;
            const bool wasSet = expected.count(line) > 0;
            EXPECT_EQ(table.Set(line, slot), wasSet);
            if (slot != HDS_NONE || wasSet) {
                expected[line] = slot;
            }
        }
        bool isMoved = false;
        const auto updates = table.TakeUpdates(&isMoved);
        device.resize(table.Words().size(), HDS_NONE);
        if (isMoved) {
            device = table.Words();
        }
        for (const shared::HdsTableUpdate& update : updates) {
            device[update.word] = update.value;
        }
        ASSERT_EQ(device, table.Words());
        for (std::uint32_t line = 0; line < numLines; ++line) {
            const std::uint32_t slot =
                device[device[line >> HDS_LINE_PAGE_SHIFT] + (line & (HDS_LINE_PAGE_WORDS - 1U))];
            ASSERT_EQ(slot, expected.count(line) > 0 ? expected[line] : HDS_NONE) << line;
        }
        numLines += round % 7 == 0 ? 900 : 0;
    }
    table.Clear();
    for (std::uint32_t line = 0; line < numLines; ++line) {
        ASSERT_EQ(table.Slot(line), HDS_NONE);
    }
}

TEST(LineTable, PagesAreMadeWhenTheirFirstLineComes) {
    LineTable table;
    table.Reserve(1000 * HDS_LINE_PAGE_WORDS);
    EXPECT_EQ(table.Words().size(), 1000U + HDS_LINE_PAGE_WORDS);
    table.Set(5, HDS_NONE);
    EXPECT_EQ(table.Words().size(), 1000U + HDS_LINE_PAGE_WORDS);
    table.Set(5, 1);
    table.Set(6, 1);
    table.Set(999 * HDS_LINE_PAGE_WORDS, 1);
    EXPECT_EQ(table.Words().size(), 1000U + 3 * HDS_LINE_PAGE_WORDS);
}

TEST(OpenTextures, LinesKeepTheirNumbersWhileTexturesComeAndGo) {
    FakeTextures before({{1, 64, 64}, {2, 300, 20}, {3, 8, 8}, {4, 100, 100}});
    OpenTextures textures;
    EXPECT_TRUE(textures.Update(before).empty());
    EXPECT_FALSE(textures.IsOpen(2));
    EXPECT_EQ(textures.Records()[2].width, 1U);
    for (const std::uint32_t texture : {2U, 0U, 3U, 0U}) {
        textures.Add(before, texture);
    }
    const std::uint32_t first = textures.Records()[0].firstLine;
    EXPECT_EQ(first, textures.Records()[2].numLines);
    EXPECT_EQ(textures.Find(first).texture, 0U);
    EXPECT_EQ(textures.Find(first + 3).line, 3U);
    EXPECT_EQ(textures.Find(first - 1).texture, 2U);

    FakeTextures after({{9, 4, 4}, {4, 100, 100}, {2, 300, 20}, {1, 64, 64}});
    const std::vector<LineRange> gone = textures.Update(after);
    ASSERT_EQ(gone.size(), 1U);
    EXPECT_EQ(gone[0], LineRange(0, first));
    EXPECT_FALSE(textures.IsOpen(0));
    EXPECT_FALSE(textures.IsOpen(2));
    EXPECT_EQ(textures.Records()[3].firstLine, first);
    EXPECT_EQ(textures.Find(first).texture, 3U);
    EXPECT_LT(textures.NumLiveLines(), textures.NumLines());
}

/// Shades items that need lines, on paper: an item is done when its launch has at most `room`.
TEST(TexelWaiters, EndWhateverFitsAtOnce) {
    for (const std::size_t room : {1U, 3U, 100U, 5000U}) {
        std::vector<std::uint32_t> all(1000);
        for (std::uint32_t i = 0; i < all.size(); ++i) {
            all[i] = i;
        }
        TexelWaiters waiters(1000, all);
        std::vector<bool> isDone(1000);
        std::size_t launched = 1000;
        int rounds = 0;
        while (!waiters.IsEmpty()) {
            ASSERT_LT(++rounds, 3000);
            waiters.Continue({0, launched > room ? 1U : 0U});
            const std::vector<std::uint32_t> batch = waiters.Take();
            ASSERT_FALSE(batch.empty());
            std::vector<std::uint32_t> waiting;
            for (const std::uint32_t item : batch) {
                ASSERT_FALSE(isDone[item]);
                if (batch.size() > room) {
                    waiting.push_back(item);
                } else {
                    isDone[item] = true;
                }
            }
            launched = batch.size();
            waiters.Return(waiting);
        }
        EXPECT_EQ(std::count(isDone.begin(), isDone.end(), true), 1000);
    }
}

TEST(TexelWaiters, OneItemThatFindsNoRoomTwiceIsAnError) {
    TexelWaiters waiters(1, {7});
    const auto waitAgain = [&](const TexturePool::Outcome& outcome) {
        waiters.Continue(outcome);
        waiters.Return(waiters.Take());
    };
    for (int step = 0; step < 5; ++step) { // of a walk, which has let go what it used before
        waitAgain({0, 1});
        waitAgain({1, 0});
    }
    waitAgain({0, 1});
    EXPECT_THROW(waiters.Continue({0, 1}), Error);
}

} // namespace
} // namespace hds::test
