// SPDX-License-Identifier: Apache-2.0
// Host memory in the machine's large pages, for buffers of CPU devices: traversal reads all over
// them, and misses of the address translation would cost more than those of the caches.
// Private to the layer. Explained in docs/device.md.
#pragma once

#include <cstdint>

namespace hds {

/// From so many bytes on large pages are worth it, where the system may have any.
#if defined(__linux__)
constexpr std::uint64_t kMinHugePageBytes = 4U << 20U;
#else
constexpr std::uint64_t kMinHugePageBytes = ~std::uint64_t{0};
#endif

/// Memory of zeros for which large pages were asked, aligned to them; null when memory has run out.
/// Thread-safe.
void* AllocateHugePages(std::uint64_t bytes);
/// \param bytes as given to AllocateHugePages.
void FreeHugePages(void* memory, std::uint64_t bytes);

} // namespace hds
