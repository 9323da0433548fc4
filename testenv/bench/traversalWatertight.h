// SPDX-License-Identifier: Apache-2.0
// Counts rays that leak out of closed meshes.
#pragma once

#include "hdStream/device/device.h"

#include <cstdint>

namespace hds::bench {

/// Casts `numRays` rays from inside closed meshes under several transforms, most of them aimed at edges
/// and vertices, with both kernel forms; prints a row a case.
/// \return rays that met nothing (0: watertight).
std::uint64_t RunWatertight(const std::shared_ptr<Device>& device, std::uint64_t numRays);

} // namespace hds::bench
