// SPDX-License-Identifier: Apache-2.0
// How much memory front ends take for blocks of small arrays, so that it can be counted with what
// the core keeps.
#pragma once

#include <atomic>
#include <cstdint>

namespace hds {

/// Bytes of all blocks of the process that are alive.
inline std::atomic<std::uint64_t> arrayBlockBytes{0};

} // namespace hds
