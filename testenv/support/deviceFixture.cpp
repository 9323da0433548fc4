// SPDX-License-Identifier: Apache-2.0
#include "testenv/support/deviceFixture.h"

#include <cstdlib>

namespace hds::test {

std::shared_ptr<Device> SharedTestDevice() {
    static const std::shared_ptr<Device> device = []() -> std::shared_ptr<Device> {
        const char* name = std::getenv("HDSTREAM_TEST_DEVICE");
        try {
            return Device::Create(name != nullptr ? name : "");
        } catch (const Error&) {
            return nullptr;
        }
    }();
    return device;
}

void DeviceFixture::SetUp() {
    device = SharedTestDevice();
    if (!device) {
        if (std::getenv("HDSTREAM_REQUIRE_DEVICE") != nullptr) {
            FAIL() << "no OpenCL device, and HDSTREAM_REQUIRE_DEVICE is set";
        }
        GTEST_SKIP() << "SKIPPED LOUDLY: no OpenCL device on this machine";
    }
}

void CpuDeviceFixture::SetUp() {
    DeviceFixture::SetUp();
    if (device && !device->Properties().isCpu) {
        GTEST_SKIP() << "of CPUs alone";
    }
}

std::unique_ptr<Program> DeviceFixture::Build(const std::string& text,
                                              const ProgramDefines& defines) {
    return std::make_unique<Program>(device, "test.cl", defines, nullptr, &text);
}

} // namespace hds::test
