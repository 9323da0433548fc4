// SPDX-License-Identifier: Apache-2.0
#include "hdStream/base/machine.h"

#include <unistd.h>

namespace hds {

std::uint64_t MachineMemoryBytes() {
    const long pages = sysconf(_SC_PHYS_PAGES);
    const long pageBytes = sysconf(_SC_PAGE_SIZE);
    constexpr std::uint64_t kUnknown = 1ULL << 32U;
    return pages > 0 && pageBytes > 0
               ? static_cast<std::uint64_t>(pages) * static_cast<std::uint64_t>(pageBytes)
               : kUnknown;
}

} // namespace hds
