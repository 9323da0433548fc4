// SPDX-License-Identifier: Apache-2.0
// What the program runs on.
#pragma once

#include <cstdint>

namespace hds {

/// Bytes of main memory.
std::uint64_t MachineMemoryBytes();

/// Gives the system back what the process has freed, where the allocator can. Takes milliseconds
/// where much is free in small pieces.
void ReturnFreeMemory();

} // namespace hds
