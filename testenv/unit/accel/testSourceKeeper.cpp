// SPDX-License-Identifier: Apache-2.0
// What chunks are cut from stays up to a bound, is made again beyond it, and then gives the same.
#include "hdStream/accel/chunkedGeometry.h"
#include "hdStream/base/error.h"
#include "testenv/support/meshSource.h"

#include <gtest/gtest.h>

#include <memory>
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
