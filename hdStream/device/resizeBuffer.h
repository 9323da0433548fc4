// SPDX-License-Identifier: Apache-2.0
// Buffers that are kept from one render to the next.
#pragma once

#include "hdStream/device/device.h"

namespace hds {

/// Makes `buffer` one of so many bytes, or keeps it where it is: its contents are undefined then.
/// The old one is freed before the new one is made.
void ResizeBuffer(const std::shared_ptr<Device>& device, const char* label, std::uint64_t bytes,
                  Buffer* buffer);

} // namespace hds
