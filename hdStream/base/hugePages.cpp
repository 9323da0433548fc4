// SPDX-License-Identifier: Apache-2.0
#include "hdStream/base/hugePages.h"

#if defined(__linux__)
#include <sys/mman.h>
#endif

namespace hds {

#if defined(__linux__)

namespace {

constexpr std::uint64_t kPageBytes = 2U << 20U;

std::uint64_t RoundUp(std::uint64_t bytes) {
    return (bytes + kPageBytes - 1) / kPageBytes * kPageBytes;
}

} // namespace

void* AllocateHugePages(std::uint64_t bytes) {
    const std::uint64_t size = RoundUp(bytes);
    void* memory = mmap(nullptr, size + kPageBytes, PROT_READ | PROT_WRITE,
                        MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
    if (memory == MAP_FAILED) {
        return nullptr;
    }
    // Returns what lies before the first and behind the last large page.
    auto* first = static_cast<unsigned char*>(memory);
    const std::uint64_t before =
        RoundUp(reinterpret_cast<std::uintptr_t>(first)) - reinterpret_cast<std::uintptr_t>(first);
    if (before > 0) {
        munmap(first, before);
    }
    if (before < kPageBytes) {
        munmap(first + before + size, kPageBytes - before);
    }
    madvise(first + before, size, MADV_HUGEPAGE); // only a wish: without it pages are small
    return first + before;
}

void FreeHugePages(void* memory, std::uint64_t bytes) {
    munmap(memory, RoundUp(bytes));
}

#else

void* AllocateHugePages(std::uint64_t) {
    return nullptr;
}

void FreeHugePages(void*, std::uint64_t) {}

#endif

} // namespace hds
