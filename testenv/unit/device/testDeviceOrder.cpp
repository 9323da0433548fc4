// SPDX-License-Identifier: Apache-2.0
// The default device does not depend on the order in which a loader finds drivers.
#include "hdStream/device/deviceOrder.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <string>
#include <vector>

namespace hds {

namespace {

DeviceProperties Of(const std::string& platform, const std::string& name, bool isCpu) {
    DeviceProperties properties;
    properties.platform = platform;
    properties.name = name;
    properties.isCpu = isCpu;
    properties.version = "OpenCL of the " + name; // "second" is behind "first"
    return properties;
}

TEST(DeviceOrder, IsTheSameWhateverTheOrderOfPlatforms) {
    const std::vector<DeviceProperties> wanted = {
        Of("A GPU driver", "second", false),       Of("A GPU driver", "first", false),
        Of(kPoclPlatform, "a GPU of PoCL", false), Of("Z GPU driver", "other", false),
        Of(kPoclPlatform, "a CPU", true),          Of("A CPU driver", "a CPU", true)};
    std::vector<std::size_t> order = {0, 1, 2, 3, 4, 5};
    do {
        if (std::find(order.begin(), order.end(), 0) > std::find(order.begin(), order.end(), 1)) {
            continue; // devices of a platform stay as the driver has them
        }
        std::vector<DeviceProperties> found;
        for (const std::size_t i : order) {
            found.push_back(wanted[i]);
        }
        std::stable_sort(found.begin(), found.end(), ComesBefore);
        for (std::size_t i = 0; i < found.size(); ++i) {
            ASSERT_EQ(found[i].platform + found[i].name, wanted[i].platform + wanted[i].name) << i;
        }
    } while (std::next_permutation(order.begin(), order.end()));
}

} // namespace

} // namespace hds
