// SPDX-License-Identifier: Apache-2.0
// Kernels find mapped pages where the table says, in memory that is no device memory; pages that
// are in no file are prepared once.
#include "hdStream/base/error.h"
#include "hdStream/stream/mappedPool.h"
#include "testenv/support/deviceFixture.h"
#include "testenv/support/fakePages.h"

namespace hds::test {
namespace {

const char* const kProbeText = R"(
/* Word `word` of the pool. */
kernel void probe_read(global const uint* pool, global const uint* words, uint count,
                       global uint* values) {
    const uint i = (uint)get_global_id(0);
    if (i < count) {
        values[i] = pool[words[i]];
    }
}
)";

class MappedPoolTest : public CpuDeviceFixture {};

TEST_F(MappedPoolTest, KernelsReadPagesInPlace) {
    const auto ids = Range(0, 300);
    FakePages pages(ids);
    pages.MapPages();
    MappedPool pool(device, "fake");
    const std::uint64_t before = device->AllocatedBytes();
    pool.Update(&pages, 0);
    EXPECT_LE(device->AllocatedBytes(), before + ids.size() * sizeof(std::uint32_t));
    const std::size_t numPrepared = pages.NumPrepared();
    EXPECT_EQ(pool.NumBuffers(), 1U);
    const auto table = Download<std::uint32_t>(pool.Addresses(), ids.size());
    std::vector<std::uint32_t> words;
    std::vector<std::uint32_t> expected;
    for (std::size_t page = 0; page < ids.size(); ++page) {
        const std::vector<std::uint8_t> bytes = BytesOf(ids[page]);
        ASSERT_EQ(table[page] == HDS_NOT_RESIDENT, bytes.empty());
        for (std::size_t i = 0; i + 4 <= bytes.size(); i += 4) {
            words.push_back(table[page] * 4 + static_cast<std::uint32_t>(i / 4));
            expected.push_back(bytes[i] | bytes[i + 1] << 8U | bytes[i + 2] << 16U |
                               static_cast<std::uint32_t>(bytes[i + 3]) << 24U);
        }
    }
    const auto program = Build(kProbeText);
    Kernel probe = program->GetKernel("probe_read");
    const Buffer list = Upload(words);
    const Buffer values = Allocate(words.size() * sizeof(std::uint32_t));
    const auto count = static_cast<std::uint32_t>(words.size());
    probe.Launch(count, pool.PoolBuffer(0), list, count, values);
    EXPECT_EQ(Download<std::uint32_t>(values, words.size()), expected);
    pool.Update(&pages, 0);
    EXPECT_EQ(pages.NumPrepared(), numPrepared) << "all lie in the file";
}

TEST_F(MappedPoolTest, ACacheThatCannotHoldThemIsAnError) {
    FakePages pages(Range(0, 10)); // in no file
    MappedPool pool(device, "fake");
    EXPECT_THROW(pool.Update(&pages, 0), Error);
}

} // namespace
} // namespace hds::test
