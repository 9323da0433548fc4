// SPDX-License-Identifier: Apache-2.0
// A GoogleTest fixture with an OpenCL device. Without one the tests skip loudly; CI sets
// HDSTREAM_REQUIRE_DEVICE=1, which turns the skip into a failure.
#pragma once

#include "hdStream/device/device.h"
#include "hdStream/device/program.h"

#include <gtest/gtest.h>

#include <memory>
#include <string>
#include <vector>

namespace hds::test {

/// The device under test: HDSTREAM_TEST_DEVICE (part of a name), else the first. Null: none.
std::shared_ptr<Device> SharedTestDevice();

class DeviceFixture : public ::testing::Test {
protected:
    void SetUp() override;

    /// Builds a program from OpenCL text, which may include kernel modules ("math/vector.clh").
    std::unique_ptr<Program> Build(const std::string& text, const ProgramDefines& defines = {});

    template <typename T>
    Buffer Upload(const std::vector<T>& values) {
        Buffer buffer(device, "test input", values.size() * sizeof(T));
        if (!values.empty()) {
            buffer.Write(values.data(), values.size() * sizeof(T));
        }
        return buffer;
    }
    Buffer Allocate(std::uint64_t bytes) { return {device, "test output", bytes}; }
    template <typename T>
    std::vector<T> Download(const Buffer& buffer, std::size_t count) {
        std::vector<T> values(count);
        device->Finish();
        buffer.Read(values.data(), count * sizeof(T));
        return values;
    }

    std::shared_ptr<Device> device;
};

/// For what only CPUs run: forms of kernels, memory that is the host's. Others skip.
class CpuDeviceFixture : public DeviceFixture {
protected:
    void SetUp() override;
};

} // namespace hds::test
