// SPDX-License-Identifier: Apache-2.0
// A kernel that asks a streaming pool for pages and uses them, and what is in the pool.
#pragma once

#include "hdStream/stream/reportPool.h"
#include "testenv/support/deviceFixture.h"
#include "testenv/support/fakePages.h"

#include <algorithm>

namespace hds::test {

inline const char* const kProbeText = R"(
#include "stream/residency.clh"
/* Item i marks page[i] as used (0), asks for it (1), or for all of its group (2). */
kernel void probe_use(global const uint* pages, uint count, uint use,
                      global const uint* addresses HDS_RESIDENCY_ARGS) {
    const uint i = (uint)get_global_id(0);
    if (i >= count) {
        return;
    }
    HdsResidencyView view;
    HDS_RESIDENCY_VIEW(view);
    if (use == 0u) {
        residency_touch(&view, pages[i]);
    } else if (use == 1u) {
        residency_request(&view, pages[i]);
    } else {
        residency_useGroup(&view, addresses, pages[i] & ~1u);
    }
}
)";

using Pages = std::vector<std::uint32_t>;

/// Tests of streaming pools.
class StreamingPoolTest : public DeviceFixture {
protected:
    void SetUp() override {
        DeviceFixture::SetUp();
        if (device) {
            program = Build(kProbeText, {{"HDS_FEATURE_STREAMING", "1"}});
            probe = program->GetKernel("probe_use");
        }
    }

    void Use(const StreamingPool& pool, const Pages& pages, std::uint32_t use) {
        const Buffer list = Upload(pages);
        const auto count = static_cast<std::uint32_t>(pages.size());
        probe.Launch(count, list, count, use, pool.Addresses(), pool.Uses());
        device->Finish();
    }
    /// Asks for pages that are missing.
    void Ask(const StreamingPool& pool, const Pages& pages) { Use(pool, pages, 1); }
    /// Asks for the groups of pages, if they lack any.
    void AskWhole(const StreamingPool& pool, const Pages& pages) { Use(pool, pages, 2); }
    /// Uses pages that are resident.
    void Touch(const StreamingPool& pool, const Pages& pages) { Use(pool, pages, 0); }
    /// What kernels have told of each page.
    std::vector<std::uint32_t> Uses(const StreamingPool& pool, std::size_t numPages) {
        auto words = Download<std::uint32_t>(pool.Uses(), HDS_USE_HEADER + numPages);
        return {words.begin() + HDS_USE_HEADER, words.end()};
    }

    /// Words of the table; checks the bytes of every page that is resident.
    std::vector<std::uint32_t> Table(const StreamingPool& pool,
                                     const std::vector<std::uint64_t>& ids) {
        auto words = Download<std::uint32_t>(pool.Addresses(), ids.size());
        std::vector<std::vector<std::uint8_t>> memory;
        for (std::uint32_t i = 0; i < pool.NumBuffers(); ++i) {
            memory.push_back(
                Download<std::uint8_t>(pool.PoolBuffer(i), pool.PoolBuffer(i).Bytes()));
        }
        for (std::size_t page = 0; page < ids.size(); ++page) {
            const std::uint32_t address = words[page] & ~HDS_PAGE_DONE;
            if (address == HDS_NOT_RESIDENT) {
                continue;
            }
            const std::vector<std::uint8_t> expected = BytesOf(ids[page]);
            const std::uint32_t buffer = address >> HDS_POOL_BUFFER_SHIFT;
            const std::uint64_t at =
                std::uint64_t{address & ((1U << HDS_POOL_BUFFER_SHIFT) - 1U)} * HDS_POOL_UNIT_BYTES;
            EXPECT_LT(buffer, memory.size());
            EXPECT_LE(at + expected.size(), memory[buffer].size());
            EXPECT_TRUE(std::equal(expected.begin(), expected.end(),
                                   memory[buffer].begin() + static_cast<std::ptrdiff_t>(at)))
                << "page " << page;
        }
        return words;
    }

    static Pages Resident(const std::vector<std::uint32_t>& words) {
        Pages pages;
        for (std::uint32_t page = 0; page < words.size(); ++page) {
            if ((words[page] & ~HDS_PAGE_DONE) != HDS_NOT_RESIDENT) {
                pages.push_back(page);
            }
        }
        return pages;
    }

    std::unique_ptr<Program> program;
    Kernel probe;
};

/// Pages of 160 bytes each.
inline std::vector<std::uint64_t> EqualIds(std::size_t count) {
    std::vector<std::uint64_t> ids;
    for (std::uint64_t id = 1; ids.size() < count; ++id) {
        if (BytesOf(id).size() == 160) {
            ids.push_back(id);
        }
    }
    return ids;
}

} // namespace hds::test
