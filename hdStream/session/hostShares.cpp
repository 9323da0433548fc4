// SPDX-License-Identifier: Apache-2.0
#include "hdStream/session/hostShares.h"

#include <algorithm>

namespace hds {

HostShares ShareHostMemory(std::uint64_t hostBytes, std::uint64_t sceneBytes) {
    constexpr std::uint64_t kDivisor = 4;
    const std::uint64_t left = hostBytes - std::min(hostBytes, sceneBytes);
    const std::uint64_t shared = std::max(left, hostBytes / kDivisor);
    HostShares shares;
    shares.sources = shared / kDivisor;
    shares.pages = shared - shares.sources;
    return shares;
}

} // namespace hds
