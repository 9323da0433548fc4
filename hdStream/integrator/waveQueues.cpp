// SPDX-License-Identifier: Apache-2.0
#include "hdStream/integrator/waveQueues.h"

#include <utility>

namespace hds {

namespace {

constexpr std::uint64_t kItemBytes = sizeof(std::uint32_t);

/// Makes or keeps a buffer of exactly so many bytes.
void Resize(Buffer* buffer, const std::shared_ptr<Device>& device, const char* label,
            std::uint64_t bytes) {
    if (!buffer->IsValid() || buffer->Bytes() != bytes) {
        *buffer = Buffer(); // frees first
        *buffer = Buffer(device, label, bytes);
    }
}

} // namespace

WaveQueues::WaveQueues(std::shared_ptr<Device> device) : _device(std::move(device)) {
    _counters = Buffer(_device, "counters", HDS_NUM_COUNTERS * sizeof(std::uint32_t));
}

std::uint64_t WaveQueues::BytesPerPath(const KernelFeatures& features) {
    const std::uint64_t numWaiting = features.streaming ? 2 * NumWaiting : 0;
    return kItemBytes * (numWaiting + (features.HasLists() ? kNumQueues + 1 : kResumedQueue));
}

void WaveQueues::Ready(const StageKernels& kernels, std::uint32_t waveSize) {
    const bool hasLists = kernels.Features().HasLists();
    _waveSize = waveSize;
    Resize(&_paths, _device, "path state", waveSize * kernels.PathStateBytes());
    _bytes = _paths.Bytes();
    for (std::uint32_t i = 0; i < kNumQueues; ++i) {
        const bool isUsed = hasLists || i < kResumedQueue;
        Resize(&_queues[i], _device, "ray queue", isUsed ? waveSize * kItemBytes : 0);
        _bytes += _queues[i].Bytes();
    }
    const std::uint64_t waitBytes = kernels.Features().streaming ? waveSize * kItemBytes : 0;
    for (auto& side : _waitQueues) {
        for (Buffer& queue : side) {
            Resize(&queue, _device, "queue of what waits", waitBytes);
            _bytes += queue.Bytes();
        }
    }
    Resize(&_ready, _device, "queue of ready paths", hasLists ? waitBytes : 0);
    _bytes += _ready.Bytes();
}

void WaveQueues::Turn() {
    _side = 1 - _side;
    ClearWaiting();
}

WaveQueues::Counts WaveQueues::ReadCounters() const {
    Counts values{};
    _counters.Read(values.data(), sizeof(values));
    return values;
}

void WaveQueues::ClearCounter(std::uint32_t counter, std::uint32_t count) {
    _counters.Fill(0, count * sizeof(std::uint32_t), counter * sizeof(std::uint32_t));
}

void WaveQueues::SetCounter(std::uint32_t counter, std::uint32_t value) {
    _counters.Fill(value, sizeof(std::uint32_t), counter * sizeof(std::uint32_t));
}

} // namespace hds
