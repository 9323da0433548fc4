// SPDX-License-Identifier: Apache-2.0
// What chunks are cut from stays up to a bound, is made again beyond it, and then gives the same.
#include "hdStream/accel/chunkedGeometry.h"
#include "hdStream/accel/geometryPages.h"
#include "hdStream/base/error.h"
#include "testenv/support/meshSource.h"
#include "testenv/support/temporaryFolder.h"

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <algorithm>
#include <functional>
#include <memory>
#include <thread>
#include <vector>

namespace hds::test {
namespace {

TEST(SourceKeeper, KeepsThoseUsedLast) {
    SourceKeeper keeper;
    keeper.SetLimit(100);
    std::vector<std::weak_ptr<int>> objects;
    const auto use = [&](std::uintptr_t owner, std::uint64_t bytes) {
        const auto object = std::make_shared<int>(0);
        objects.emplace_back(object);
        keeper.Use(reinterpret_cast<const void*>(owner), object, bytes);
    };
    const auto isAlive = [&](std::size_t i) { return !objects[i].expired(); };
    use(1, 40);
    use(2, 40);
    keeper.Use(reinterpret_cast<const void*>(1), objects[0].lock(), 40);
    EXPECT_EQ(keeper.Bytes(), 80U) << "each is counted once";
    use(3, 40);
    EXPECT_TRUE(isAlive(0) && !isAlive(1) && isAlive(2));
    EXPECT_EQ(keeper.Bytes(), 80U);
    use(4, 500);
    EXPECT_TRUE(isAlive(3)) << "what is in use stays";
    EXPECT_FALSE(isAlive(0) || isAlive(2));
    EXPECT_EQ(keeper.PeakBytes(), 500U);
    keeper.Forget(reinterpret_cast<const void*>(4));
    keeper.Forget(reinterpret_cast<const void*>(4));
    EXPECT_FALSE(isAlive(3));
    EXPECT_EQ(keeper.Bytes(), 0U);
    keeper.BeginStatistics();
    EXPECT_EQ(keeper.PeakBytes(), 0U);
    use(5, 60);
    use(6, 30);
    keeper.SetLimit(50);
    EXPECT_TRUE(!isAlive(4) && isAlive(5));
}

std::shared_ptr<const ChunkSource> Grid(std::uint32_t size) {
    TriangleMesh triangles;
    for (std::uint32_t i = 0; i < size * size; ++i) {
        const auto corner = static_cast<std::uint32_t>(triangles.positions.size());
        const glm::vec3 at(static_cast<float>(i % size), static_cast<float>(i / size), 0.0F);
        for (const glm::vec3& offset :
             {glm::vec3(0.0F), glm::vec3(1.0F, 0.0F, 0.0F), glm::vec3(0.0F, 1.0F, 0.0F)}) {
            triangles.positions.push_back(at + offset);
        }
        triangles.triangles.emplace_back(corner, corner + 1, corner + 2);
    }
    return SourceOf(std::move(triangles));
}

TEST(SourceKeeper, WhatIsMadeAgainGivesTheSamePages) {
    auto keeper = std::make_shared<SourceKeeper>();
    keeper->SetLimit(1);
    int numMade = 0;
    const auto make = [&numMade] {
        ++numMade;
        return Grid(40);
    };
    const auto a = std::make_unique<ChunkedGeometry>(make, 4096, nullptr, PageKey{}, keeper, 100);
    const auto b = std::make_unique<ChunkedGeometry>(make, 4096, nullptr, PageKey{}, keeper, 100);
    const ChunkedGeometry kept(make, 4096, nullptr, PageKey{});
    ASSERT_GT(kept.Summary().NumChunks(), 4U);
    EXPECT_EQ(numMade, 3);
    for (std::uint32_t chunk = 0; chunk < 4; ++chunk) {
        EXPECT_EQ(a->Make(chunk), kept.Make(chunk));
        EXPECT_EQ(b->Make(chunk), kept.Make(chunk));
    }
    EXPECT_EQ(numMade, 3 + 8) << "each time that the other one was used between";
    keeper->SetLimit(1U << 30U);
    for (std::uint32_t chunk = 0; chunk < 4; ++chunk) {
        a->Make(chunk);
        b->Make(chunk);
    }
    EXPECT_EQ(numMade, 3 + 8 + 1) << "both stay";
    EXPECT_GE(keeper->Bytes(), 200U);
}

/// Two geometries of which there is room for the source of one, with a store.
class TwoInOneRoom : public ::testing::Test {
protected:
    void SetUp() override {
        store = std::make_shared<PageStore>(Options(), nullptr);
        keeper->SetLimit(1);
    }
    virtual PageStoreOptions Options() const {
        PageStoreOptions options;
        options.directory = folder.Path();
        return options;
    }
    std::shared_ptr<ChunkedGeometry> Geometry(std::uint64_t key) {
        const auto make = [this] {
            ++numMade;
            return Grid(80);
        };
        return std::make_shared<ChunkedGeometry>(make, 4096, store, PageKey{{key, 0}}, keeper, 100);
    }
    static ChunkBytes Ask(const std::shared_ptr<ChunkedGeometry>& geometry, std::uint32_t chunk,
                          const std::function<bool()>& isCancelled = {}) {
        PreparedPages prepared;
        const auto made = std::make_shared<ChunkPages>(geometry, chunk);
        prepared.Prepare({{made, {true, true}}}, isCancelled);
        return {made->Data(0), made->Data(1)};
    }
    /// Asks for all chunks, or each of so many, one of each geometry in turn, from `first` on.
    /// \return the pages in the order of chunks of one.
    std::vector<ChunkBytes> AskInTurn(std::uint32_t first, std::uint32_t step = 1) {
        const auto a = Geometry(1);
        const auto b = Geometry(2);
        numChunks = static_cast<std::uint32_t>(a->Summary().NumChunks());
        numMade = 0;
        std::vector<ChunkBytes> pages(numChunks);
        for (std::uint32_t i = 0; i < numChunks; i += step) {
            const std::uint32_t chunk = (first + i) % numChunks;
            pages[chunk] = Ask(a, chunk);
            EXPECT_EQ(Ask(b, chunk), pages[chunk]);
        }
        return pages;
    }
    std::vector<ChunkBytes> Expected() const {
        const ChunkedGeometry kept([] { return Grid(80); }, 4096, nullptr, PageKey{});
        std::vector<ChunkBytes> pages;
        for (std::uint32_t chunk = 0; chunk < numChunks; ++chunk) {
            pages.push_back(kept.Make(chunk));
        }
        return pages;
    }

    test::TemporaryFolder folder;
    std::shared_ptr<SourceKeeper> keeper = std::make_shared<SourceKeeper>();
    std::shared_ptr<PageStore> store;
    int numMade = 0;
    std::uint32_t numChunks = 0;
};

// Once for the first chunk, then three times with an eighth, a quarter and a half of all chunks,
// and what that leaves. It was twice for each chunk.
TEST_F(TwoInOneRoom, NoSourceIsMadeVeryOften) {
    const std::vector<ChunkBytes> pages = AskInTurn(7);
    ASSERT_GT(numChunks, 40U);
    EXPECT_LE(numMade, 2 * 5);
    EXPECT_EQ(keeper->NumMade(), static_cast<std::uint64_t>(numMade));
    EXPECT_GT(keeper->NumAhead(), numChunks);
    EXPECT_LE(keeper->NumAhead(), 2 * (numChunks - 1));
    EXPECT_EQ(pages, Expected());
    keeper->BeginStatistics();
    EXPECT_EQ(AskInTurn(0), pages);
    EXPECT_EQ(numMade, 0) << "the store has all of them";
    EXPECT_EQ(keeper->NumMade() + keeper->NumAhead(), 0U);
}

TEST_F(TwoInOneRoom, OneThatStaysMakesNothingAhead) {
    keeper->SetLimit(1U << 30U);
    const std::vector<ChunkBytes> pages = AskInTurn(0);
    EXPECT_EQ(pages, Expected());
    EXPECT_EQ(numMade, 0) << "those of the plans";
    EXPECT_EQ(keeper->NumAhead(), 0U);
}

// Between the chunks that nobody has asked for it is looked whether the render goes on.
TEST_F(TwoInOneRoom, WhoCancelsWaitsForNoMoreChunksAhead) {
    const auto a = Geometry(1);
    const auto b = Geometry(2);
    numChunks = static_cast<std::uint32_t>(a->Summary().NumChunks());
    Ask(a, 0);
    Ask(b, 0);
    EXPECT_EQ(keeper->NumAhead(), 0U);
    {
        const tbb::global_control serial(tbb::global_control::max_allowed_parallelism, 1);
        int numAsked = 0;
        Ask(a, 1, [&numAsked] { return ++numAsked == 4; });
        EXPECT_EQ(numAsked, 4) << "once told, it is not asked again";
        EXPECT_GT(numChunks / 8, 4U);
        EXPECT_EQ(keeper->NumAhead(), 2U) << "one was there";
    }
    const std::thread::id caller = std::this_thread::get_id();
    Ask(b, 1, [caller] {
        EXPECT_EQ(std::this_thread::get_id(), caller);
        return false;
    });
    EXPECT_GE(keeper->NumAhead(), 2 + numChunks / 8 - 2) << "all of b's";
    keeper->BeginStatistics();
    std::vector<ChunkBytes> pages(numChunks);
    for (std::uint32_t chunk = 0; chunk < numChunks; ++chunk) {
        pages[chunk] = Ask(a, chunk);
        b->Hold(); // a's goes
    }
    EXPECT_EQ(pages, Expected());
    EXPECT_LE(keeper->NumMade(), 4U) << "those that were cancelled are made another time";
}

class TwoInALittleStore : public TwoInOneRoom {
protected:
    PageStoreOptions Options() const override {
        PageStoreOptions options = TwoInOneRoom::Options();
        options.maxBytes = kStoreBytes;
        return options;
    }
    static constexpr std::uint64_t kStoreBytes = 5 * (256U << 10U); ///< five segments
};

// Pages that nobody has asked for would take the room of those that somebody asks for.
TEST_F(TwoInALittleStore, WhatNobodyAsksForTakesHalfOfTheStore) {
    AskInTurn(0, 12);
    std::uint64_t bytes = 0;
    for (const ChunkBytes& page : Expected()) {
        bytes += page[0].size() + page[1].size();
    }
    ASSERT_GT(2 * bytes, kStoreBytes * 55 / 100) << "not all fit in half";
    const std::uint64_t ahead = keeper->NumAhead() * bytes / numChunks;
    EXPECT_GT(ahead, kStoreBytes * 3 / 10);
    EXPECT_LT(ahead, kStoreBytes / 2);
    EXPECT_EQ(store->Statistics().pagesNotKept, 0U);
}

// What was made ahead and is asked for then is like any other: more comes in its place, so all of
// it fits, and the source is not made for each chunk of the second half.
TEST_F(TwoInALittleStore, WhatIsAheadAndAskedForMakesRoomForMore) {
    const std::vector<ChunkBytes> pages = AskInTurn(0);
    EXPECT_EQ(pages, Expected());
    EXPECT_EQ(store->Statistics().pagesNotKept, 0U);
    EXPECT_LE(numMade, 2 * 8);
}

class TwoInAFullStore : public TwoInOneRoom {
protected:
    PageStoreOptions Options() const override {
        PageStoreOptions options = TwoInOneRoom::Options();
        options.maxBytes = 64U << 10U; // less than a segment
        return options;
    }
};

TEST_F(TwoInAFullStore, NothingIsMadeAheadThatIsNotKept) {
    const std::vector<ChunkBytes> pages = AskInTurn(0);
    EXPECT_EQ(pages, Expected());
    EXPECT_EQ(keeper->NumAhead(), 0U);
    EXPECT_EQ(static_cast<std::uint32_t>(numMade), 2 * numChunks);
    EXPECT_LE(store->Statistics().pagesNotKept, 2 * (2 * numChunks + 4)) << "few are tried ahead";
}

TEST(SourceKeeper, WhatCannotBeMadeAgainIsAnErrorEachTimeAndNoLock) {
    auto keeper = std::make_shared<SourceKeeper>();
    keeper->SetLimit(1);
    bool isGone = false;
    const auto make = [&isGone]() -> std::shared_ptr<const ChunkSource> {
        if (isGone) {
            throw Error("/M.points: cannot be read again");
        }
        return Grid(40);
    };
    auto a = std::make_unique<ChunkedGeometry>(make, 4096, nullptr, PageKey{}, keeper, 100);
    const ChunkedGeometry b(make, 4096, nullptr, PageKey{}, keeper, 100);
    const ChunkBytes before = a->Make(0);
    b.Make(0);
    isGone = true;
    EXPECT_THROW(a->Make(0), Error);
    EXPECT_THROW(a->Make(1), Error);
    isGone = false;
    EXPECT_EQ(a->Make(0), before);
    a.reset();
    EXPECT_EQ(keeper->Bytes(), 0U) << "b's went when a's came";
}

} // namespace
} // namespace hds::test
