// SPDX-License-Identifier: Apache-2.0
// Every page is found, whole, at its address, also after edits; missing pages say so.
#include "hdStream/stream/residentPool.h"
#include "testenv/support/deviceFixture.h"
#include "testenv/support/fakePages.h"

#include <algorithm>
#include <random>

namespace hds::test {
namespace {

class ResidentPoolTest : public DeviceFixture {
protected:
    void ExpectPages(const ResidentPool& pool, const std::vector<std::uint64_t>& ids) {
        const auto addresses = Download<std::uint32_t>(pool.Addresses(), ids.size());
        std::vector<std::vector<std::uint8_t>> memory;
        for (std::uint32_t i = 0; i < pool.NumBuffers(); ++i) {
            memory.push_back(
                Download<std::uint8_t>(pool.PoolBuffer(i), pool.PoolBuffer(i).Bytes()));
        }
        for (std::size_t page = 0; page < ids.size(); ++page) {
            const std::vector<std::uint8_t> expected = BytesOf(ids[page]);
            if (expected.empty()) {
                EXPECT_EQ(addresses[page], HDS_NOT_RESIDENT);
                continue;
            }
            const std::uint32_t buffer = addresses[page] >> HDS_POOL_BUFFER_SHIFT;
            ASSERT_LT(buffer, memory.size());
            const std::uint64_t at =
                std::uint64_t{addresses[page] & ((1U << HDS_POOL_BUFFER_SHIFT) - 1U)} *
                HDS_POOL_UNIT_BYTES;
            ASSERT_LE(at + expected.size(), memory[buffer].size());
            EXPECT_TRUE(std::equal(expected.begin(), expected.end(),
                                   memory[buffer].begin() + static_cast<std::ptrdiff_t>(at)))
                << "page " << ids[page];
        }
    }
};

TEST_F(ResidentPoolTest, PagesLieWhereTheTableSays) {
    FakePages pages(Range(0, 1001));
    ResidentPool pool(device, "fake");
    ASSERT_TRUE(pool.Update(&pages, 0));
    ExpectPages(pool, Range(0, 1001));
    EXPECT_EQ(pool.Bytes(), pages.TotalBytes());
    EXPECT_EQ(pool.NumBuffers(), 1U);
}

TEST_F(ResidentPoolTest, EditsUploadOnlyNewPagesAndReuseRoom) {
    ResidentPool pool(device, "fake");
    FakePages first(Range(0, 400));
    ASSERT_TRUE(pool.Update(&first, 0));
    std::uint64_t uploaded = pool.Statistics().uploadedBytes;
    FakePages second(Range(0, 400));
    ASSERT_TRUE(pool.Update(&second, 0));
    EXPECT_EQ(second.NumPrepared(), 0U);
    EXPECT_EQ(pool.Statistics().uploadedBytes, uploaded); // nothing is new
    std::mt19937 random(3);
    std::uint64_t next = 400;
    std::vector<std::uint64_t> ids = Range(0, 400);
    for (int edit = 0; edit < 200; ++edit) {
        std::uint64_t fresh = 0;
        for (int k = 0; k < 1 + static_cast<int>(random() % 8); ++k) {
            fresh += BytesOf(next).size();
            ids[random() % ids.size()] = next++;
        }
        std::shuffle(ids.begin(), ids.end(), random);
        FakePages edited(ids);
        ASSERT_TRUE(pool.Update(&edited, 0)) << "edit " << edit;
        EXPECT_LE(pool.Statistics().uploadedBytes, uploaded + fresh);
        uploaded = pool.Statistics().uploadedBytes;
        ExpectPages(pool, ids);
    }
    EXPECT_LE(pool.Bytes(), 3 * FakePages(ids).TotalBytes()); // room is used again
}

TEST_F(ResidentPoolTest, APageIsPreparedOnce) {
    FakePages pages(Range(0, 50));
    ResidentPool pool(device, "fake");
    ASSERT_TRUE(pool.Update(&pages, 0));
    const std::size_t numPrepared = pages.NumPrepared();
    EXPECT_LE(numPrepared, 50U);
    ASSERT_TRUE(pool.Update(&pages, 0)); // the provider has dropped all bytes by now
    EXPECT_EQ(pages.NumPrepared(), numPrepared);
    ExpectPages(pool, Range(0, 50));
}

TEST_F(ResidentPoolTest, NoPagesIsValid) {
    FakePages pages(Range(0, 0));
    ResidentPool pool(device, "fake");
    ASSERT_TRUE(pool.Update(&pages, 0));
    EXPECT_EQ(pool.Bytes(), 0U);
    for (std::uint32_t i = 0; i < kMaxPoolBuffers; ++i) {
        EXPECT_TRUE(pool.PoolBuffer(i).IsValid());
    }
}

} // namespace
} // namespace hds::test
