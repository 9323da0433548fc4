// SPDX-License-Identifier: Apache-2.0
// Every page is found, whole, at its address; missing pages say so.
#include "hdStream/stream/residentPool.h"
#include "kernels/shared/geometry.h"
#include "testenv/support/deviceFixture.h"

namespace hds::test {
namespace {

/// Pages of odd counts of 16 bytes, some of them absent; byte i of page p is a function of both.
class FakePages : public PageProvider {
public:
    explicit FakePages(std::uint32_t count) {
        for (std::uint32_t page = 0; page < count; ++page) {
            std::vector<std::uint8_t> bytes(page % 5 == 3 ? 0 : 16 * (1 + (page * 7919) % 63));
            for (std::size_t i = 0; i < bytes.size(); ++i) {
                bytes[i] = static_cast<std::uint8_t>(page * 31 + i);
            }
            _pages.push_back(std::move(bytes));
        }
    }
    std::uint32_t NumPages() const override { return static_cast<std::uint32_t>(_pages.size()); }
    std::uint64_t PageBytes(std::uint32_t page) const override { return _pages[page].size(); }
    const std::uint8_t* Page(std::uint32_t page) const override { return _pages[page].data(); }

private:
    std::vector<std::vector<std::uint8_t>> _pages;
};

class ResidentPoolTest : public DeviceFixture {};

TEST_F(ResidentPoolTest, PagesLieWhereTheTableSays) {
    const FakePages pages(1001);
    const ResidentPool pool(device, "fake", pages);
    const auto addresses = Download<std::uint32_t>(pool.Addresses(), pages.NumPages());
    const auto memory = Download<std::uint8_t>(pool.PoolBuffer(0), pool.Bytes());
    std::uint64_t total = 0;
    for (std::uint32_t page = 0; page < pages.NumPages(); ++page) {
        if (pages.PageBytes(page) == 0) {
            EXPECT_EQ(addresses[page], HDS_NOT_RESIDENT);
            continue;
        }
        ASSERT_EQ(addresses[page] >> HDS_POOL_BUFFER_SHIFT, 0U);
        const std::uint64_t at = std::uint64_t{addresses[page]} * HDS_POOL_UNIT_BYTES;
        EXPECT_TRUE(std::equal(pages.Page(page), pages.Page(page) + pages.PageBytes(page),
                               memory.begin() + static_cast<std::ptrdiff_t>(at)))
            << "page " << page;
        total += pages.PageBytes(page);
    }
    EXPECT_EQ(pool.Bytes(), total);
    EXPECT_EQ(pool.NumBuffers(), 1U);
}

TEST_F(ResidentPoolTest, NoPagesIsValid) {
    const FakePages pages(0);
    const ResidentPool pool(device, "fake", pages);
    EXPECT_EQ(pool.Bytes(), 0U);
    for (std::uint32_t i = 0; i < kMaxPoolBuffers; ++i) {
        EXPECT_TRUE(pool.PoolBuffer(i).IsValid());
    }
}

} // namespace
} // namespace hds::test
