// SPDX-License-Identifier: Apache-2.0
// No ray leaves a closed mesh without a hit: through edges and vertices, along axes, across chunk
// borders, under any transform. HDSTREAM_TEST_RAYS sets the number of rays (default 10^6 in all;
// the benchmark program runs 10^8).
#include "testenv/support/deviceFixture.h"
#include "testenv/support/watertight.h"

#include <cstdlib>

namespace hds::test {
namespace {

class Watertight : public DeviceFixture {};

TEST_F(Watertight, ClosedMeshesDoNotLeak) {
    const char* setting = std::getenv("HDSTREAM_TEST_RAYS");
    const std::uint64_t numRays =
        setting != nullptr ? std::strtoull(setting, nullptr, 10) : 1000000;
    const std::vector<WatertightCase> cases = MakeWatertightCases();
    for (const AccelForm form : kAccelForms) {
        LeakCounter counter(device, form);
        for (const WatertightCase& watertight : cases) {
            EXPECT_EQ(counter.Count(watertight, numRays / (2 * cases.size()) + 1), 0U)
                << watertight.name << ", " << NameOf(form);
        }
    }
}

// The counter counts: a mesh with a missing triangle leaks.
TEST_F(Watertight, AHoleLeaks) {
    WatertightCase holed = MakeWatertightCases()[0];
    holed.mesh.triangles.erase(holed.mesh.triangles.begin() + 500);
    for (const AccelForm form : kAccelForms) {
        EXPECT_GT(LeakCounter(device, form).Count(holed, 100000), 0U) << NameOf(form);
    }
}

} // namespace
} // namespace hds::test
