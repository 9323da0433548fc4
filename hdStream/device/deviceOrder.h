// SPDX-License-Identifier: Apache-2.0
// The order of the devices of a machine. The loader's own is that of the files in a folder, as the
// file system has them.
#pragma once

#include "hdStream/device/device.h"

namespace hds {

/// PoCL, whose platform has this name: on it the whole suite runs.
inline constexpr const char* kPoclPlatform = "Portable Computing Language";

/// Whether a device comes before another one: GPUs before CPUs, among CPUs PoCL's first, then by
/// the names of platforms; CPUs by their versions too, for there may be two PoCLs. The GPUs of one
/// platform stay as the driver has them.
bool ComesBefore(const DeviceProperties& a, const DeviceProperties& b);

} // namespace hds
