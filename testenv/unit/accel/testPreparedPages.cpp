// SPDX-License-Identifier: Apache-2.0
// Prepared pages are counted to the byte, also when memory runs out while they are made.
#include "hdStream/accel/chunkedGeometry.h"
#include "hdStream/accel/geometryPages.h"
#include "testenv/support/meshSource.h"

#include <gtest/gtest.h>

#include <atomic>
#include <functional>
#include <memory>
#include <new>

namespace hds::test {
namespace {

/// Another source that fails to make chunk number `failsAt` from now on.
class FailingSource final : public ChunkSource {
public:
    explicit FailingSource(std::shared_ptr<const ChunkSource> source)
        : ChunkSource(*source), _source(std::move(source)) {}
    std::uint32_t GroupTriangles(std::uint32_t unit) const override {
        return _source->GroupTriangles(unit);
    }
    Bounds GroupBounds(std::uint32_t unit) const override { return _source->GroupBounds(unit); }
    ChunkGeometry Gather(const std::uint32_t* units, std::size_t count) const override {
        if (failsAt-- == 0) {
            throw std::bad_alloc();
        }
        if (onGather) {
            onGather();
        }
        return _source->Gather(units, count);
    }

    mutable std::atomic<int> failsAt{-1};
    std::function<void()> onGather;

private:
    std::shared_ptr<const ChunkSource> _source;
};

class PreparedPagesTest : public ::testing::Test {
protected:
    void SetUp() override {
        TriangleMesh triangles;
        constexpr std::uint32_t kSize = 60;
        for (std::uint32_t i = 0; i < kSize * kSize; ++i) {
            const auto corner = static_cast<std::uint32_t>(triangles.positions.size());
            const glm::vec3 at(static_cast<float>(i % kSize), static_cast<float>(i / kSize), 0.0F);
            for (const glm::vec3& offset :
                 {glm::vec3(0.0F), glm::vec3(1.0F, 0.0F, 0.0F), glm::vec3(0.0F, 1.0F, 0.0F)}) {
                triangles.positions.push_back(at + offset);
            }
            triangles.triangles.emplace_back(corner, corner + 1, corner + 2);
        }
        source = std::make_shared<FailingSource>(SourceOf(std::move(triangles)));
        mesh = std::make_shared<const ChunkedGeometry>([this] { return source; }, 4096, nullptr,
                                                       PageKey{});
        for (std::uint32_t i = 0; i < mesh->Summary().NumChunks(); ++i) {
            chunks.push_back(std::make_shared<ChunkPages>(mesh, i));
        }
        ASSERT_GT(chunks.size(), 20U);
    }
    /// Chunks [begin, end), both pages.
    std::vector<PreparedPages::Wanted> Want(std::size_t begin, std::size_t end) const {
        std::vector<PreparedPages::Wanted> wanted;
        for (std::size_t i = begin; i < end; ++i) {
            wanted.push_back({chunks[i], {true, true}});
        }
        return wanted;
    }
    std::uint64_t BytesInMemory() const {
        std::uint64_t bytes = 0;
        for (const auto& chunk : chunks) {
            bytes += chunk->DataBytes();
        }
        return bytes;
    }

    std::shared_ptr<FailingSource> source;
    std::shared_ptr<const ChunkedGeometry> mesh;
    std::vector<std::shared_ptr<ChunkPages>> chunks;
    PreparedPages prepared;
};

TEST_F(PreparedPagesTest, MemoryThatRunsOutLeavesNothingUncounted) {
    prepared.Prepare(Want(0, 5));
    const std::uint64_t before = BytesInMemory();
    EXPECT_EQ(prepared.Bytes(), before);
    source->failsAt = 7;
    EXPECT_THROW(prepared.Prepare(Want(2, chunks.size())), std::bad_alloc);
    EXPECT_EQ(prepared.Bytes(), BytesInMemory());
    EXPECT_EQ(BytesInMemory(), before) << "those that were there stay";
    prepared.Prepare(Want(0, chunks.size()));
    EXPECT_GT(BytesInMemory(), before);
    EXPECT_EQ(prepared.Bytes(), BytesInMemory());
    prepared.Clear();
    EXPECT_EQ(BytesInMemory(), 0U);
    EXPECT_EQ(prepared.Bytes(), 0U);
}

TEST_F(PreparedPagesTest, TheBoundHoldsAfterwards) {
    prepared.SetLimit(16 << 10);
    for (std::size_t i = 0; i + 4 <= chunks.size(); i += 2) {
        source->failsAt = i % 3 == 0 ? 1 : -1;
        try {
            prepared.Prepare(Want(i, i + 4));
        } catch (const std::bad_alloc&) {
            prepared.Prepare(Want(i, i + 4));
        }
        EXPECT_EQ(prepared.Bytes(), BytesInMemory());
        EXPECT_LE(prepared.Bytes(), 32U << 10U);
    }
}

TEST_F(PreparedPagesTest, CountsBeginAnew) {
    prepared.Prepare(Want(0, 6));
    EXPECT_EQ(prepared.NumBuilt(), 6U);
    prepared.BeginStatistics();
    prepared.Prepare(Want(4, 9));
    EXPECT_EQ(prepared.NumBuilt(), 3U);
}

// As with large geometry whose arrays are read again: what one thread makes its chunks of makes
// what another one needs leave.
TEST_F(PreparedPagesTest, ChunksThatAreWantedTogetherAreMadeOfOneSource) {
    const auto keeper = std::make_shared<SourceKeeper>();
    keeper->SetLimit(1);
    const auto other = std::make_shared<int>();
    source->onGather = [&] {
        keeper->Forget(other.get());
        keeper->Use(other.get(), other, 1);
    };
    std::atomic<int> numMade{0};
    const auto kept = std::make_shared<const ChunkedGeometry>(
        [&] {
            ++numMade;
            return source;
        },
        4096, nullptr, PageKey{}, keeper);
    chunks.clear();
    for (std::uint32_t i = 0; i < kept->Summary().NumChunks(); ++i) {
        chunks.push_back(std::make_shared<ChunkPages>(kept, i));
    }
    keeper->Use(other.get(), other, 1);
    numMade = 0;
    prepared.Prepare(Want(0, 8));
    EXPECT_EQ(numMade, 1);
    prepared.Prepare(Want(8, 16));
    EXPECT_EQ(numMade, 2) << "nothing is held in between";
    EXPECT_EQ(prepared.NumBuilt(), 16U);
}

} // namespace
} // namespace hds::test
