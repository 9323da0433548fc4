// SPDX-License-Identifier: Apache-2.0
// Memory that is free in small pieces goes back to the system: the oracle is the system's account
// of the process.
#include "hdStream/base/machine.h"

#include <gtest/gtest.h>

#include <cstdint>
#include <cstdlib>
#include <fstream>
#include <memory>
#include <unistd.h>
#include <vector>

#if defined(__GLIBC__) && (__GLIBC__ > 2 || __GLIBC_MINOR__ >= 33)
#include <malloc.h>

namespace hds {
namespace {

constexpr std::size_t kNumBlocks = std::size_t{1} << 16U;
constexpr std::size_t kBlockBytes = 1000; // the allocator maps larger ones one by one
constexpr std::size_t kKeptOf = 64;       // one of so many stays, so that no large piece is free

/// Bytes of main memory that the process has.
std::uint64_t ResidentBytes() {
    std::ifstream file("/proc/self/statm");
    std::uint64_t all = 0;
    std::uint64_t resident = 0;
    file >> all >> resident;
    return resident * static_cast<std::uint64_t>(sysconf(_SC_PAGE_SIZE));
}

/// Whether memory comes from the allocator that is asked: not with sanitizers.
bool IsOfLibrary() {
    const auto before = mallinfo2().uordblks;
    const std::vector<char> block(kBlockBytes);
    return mallinfo2().uordblks > before;
}

TEST(Machine, MemoryThatIsFreeInSmallPiecesGoesBack) {
    if (!IsOfLibrary()) {
        GTEST_SKIP() << "another allocator";
    }
    std::vector<std::unique_ptr<std::vector<char>>> blocks(kNumBlocks);
    for (auto& block : blocks) {
        block = std::make_unique<std::vector<char>>(kBlockBytes, 'x');
    }
    for (std::size_t i = 0; i < kNumBlocks; ++i) {
        if (i % kKeptOf != 0) {
            blocks[i].reset();
        }
    }
    const std::uint64_t before = ResidentBytes();
    ReturnFreeMemory();
    const std::uint64_t after = ResidentBytes();
    EXPECT_LT(after + kNumBlocks * kBlockBytes / 2, before);
    for (std::size_t i = 0; i < kNumBlocks; i += kKeptOf) {
        ASSERT_EQ(*blocks[i], std::vector<char>(kBlockBytes, 'x')) << i;
    }
}

} // namespace
} // namespace hds

#endif
