// SPDX-License-Identifier: Apache-2.0
// How the host memory that a user grants is shared out. Explained in docs/memory-budgets.md.
#pragma once

#include <cstdint>

namespace hds {

/// Bounds of what can be forgotten and made again.
struct HostShares {
    std::uint64_t pages = 0;   ///< prepared pages
    std::uint64_t sources = 0; ///< what pages are cut from
};

/// The scene comes first: what it takes as long as it is there is taken off, but for a quarter of
/// the bytes, which is always shared out.
HostShares ShareHostMemory(std::uint64_t hostBytes, std::uint64_t sceneBytes);

} // namespace hds
