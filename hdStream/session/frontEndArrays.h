// SPDX-License-Identifier: Apache-2.0
// What front ends whose arrays are read again tell the core: the memory of the blocks that small
// arrays lie in, and the files that large ones are mapped from.
#pragma once

#include "hdStream/persist/arrayFiles.h"

#include <atomic>
#include <cstdint>

namespace hds {

/// Bytes of all blocks of the process that are alive. Any thread.
inline std::atomic<std::uint64_t> arrayBlockBytes{0};

} // namespace hds
