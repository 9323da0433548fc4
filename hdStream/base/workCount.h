// SPDX-License-Identifier: Apache-2.0
// How much of some work is done, for those who wait for it.
#pragma once

#include <cstdint>

namespace hds {

struct WorkCount {
    std::uint64_t done = 0;
    std::uint64_t total = 0; ///< 0: there is none, or it is not known yet
};

} // namespace hds
