// SPDX-License-Identifier: Apache-2.0
// What the program runs on.
#pragma once

#include <cstdint>

namespace hds {

/// Bytes of main memory.
std::uint64_t MachineMemoryBytes();

} // namespace hds
