// SPDX-License-Identifier: Apache-2.0
// A device ends when the driver's threads have let go of it, so that nothing of it is left to them
// where a process ends right behind it.
#include "hdStream/device/openclHandles.h"
#include "testenv/support/deviceFixture.h"

#include <atomic>
#include <chrono>
#include <thread>

namespace hds::test {
namespace {

class DeviceEnd : public DeviceFixture {};

struct SlowThread {
    std::atomic<bool> hasBegun{false};
    std::atomic<bool> hasEnded{false};
};

void CL_CALLBACK BeSlow(cl_event, cl_int, void* data) {
    auto* slow = static_cast<SlowThread*>(data);
    slow->hasBegun = true;
    std::this_thread::sleep_for(std::chrono::milliseconds(300));
    slow->hasEnded = true;
}

TEST_F(DeviceEnd, WaitsForThreadsOfTheDriverThatStillHoldIt) {
    if (!device->Properties().hasSlowBinaries) {
        GTEST_SKIP() << "known of PoCL alone";
    }
    std::shared_ptr<Device> own = Device::Create(device->Properties());
    const Device::Handles& handles = own->GetHandles();
    SlowThread slow;
    // PoCL counts a command as done, for whoever waits for the queue, before it calls back.
    cl_int code = CL_SUCCESS;
    cl_event start = clCreateUserEvent(handles.context, &code);
    ASSERT_EQ(code, CL_SUCCESS);
    cl_event done = nullptr;
    ASSERT_EQ(clEnqueueMarkerWithWaitList(handles.queue, 1, &start, &done), CL_SUCCESS);
    ASSERT_EQ(clSetEventCallback(done, CL_COMPLETE, BeSlow, &slow), CL_SUCCESS);
    clReleaseEvent(done);
    std::thread starter([start] { // on which PoCL may run the marker, too
        clSetUserEventStatus(start, CL_COMPLETE);
        clReleaseEvent(start);
    });
    while (!slow.hasBegun) {
        std::this_thread::yield();
    }
    own.reset();
    EXPECT_TRUE(slow.hasEnded);
    starter.join();
}

// A reference that is never given back must not keep a process from its end.
TEST_F(DeviceEnd, EndsAllTheSameWhereSomebodyElseHoldsIt) {
    std::shared_ptr<Device> own = Device::Create(device->Properties());
    cl_context context = own->GetHandles().context;
    ASSERT_EQ(clRetainContext(context), CL_SUCCESS);
    own.reset();
    cl_uint count = 0;
    EXPECT_EQ(clGetContextInfo(context, CL_CONTEXT_REFERENCE_COUNT, sizeof(count), &count, nullptr),
              CL_SUCCESS);
    EXPECT_EQ(count, 1U);
    clReleaseContext(context);
}

} // namespace
} // namespace hds::test
