// SPDX-License-Identifier: Apache-2.0
#include "hdStream/device/deviceOrder.h"

#include <tuple>

namespace hds {

bool ComesBefore(const DeviceProperties& a, const DeviceProperties& b) {
    const auto key = [](const DeviceProperties& device) {
        return std::make_tuple(device.isCpu, device.isCpu && device.platform != kPoclPlatform,
                               device.platform, device.isCpu ? device.version : std::string());
    };
    return key(a) < key(b);
}

} // namespace hds
