// SPDX-License-Identifier: Apache-2.0
#include "hdStream/integrator/waveQueues.h"

#include "hdStream/base/error.h"
#include "hdStream/device/resizeBuffer.h"

#include <utility>

namespace hds {

namespace {

constexpr std::uint64_t kItemBytes = sizeof(std::uint32_t);

} // namespace

WaveQueues::WaveQueues(std::shared_ptr<Device> device) : _device(std::move(device)) {
    ResizeCounters(HDS_GUIDE_CELLS);
}

std::uint64_t WaveQueues::BytesPerSlot(const KernelFeatures& features) {
    const std::uint64_t numWaiting = features.streaming ? 2 * NumWaiting : 0;
    return kItemBytes * (numWaiting + (features.HasLists() ? kNumQueues + 1 : kResumedQueue));
}

std::uint64_t WaveQueues::SumBytes(const KernelFeatures& features) {
    return 16ULL * (1 + (features.mattes ? 1 : 0) + features.lightPaths);
}

void WaveQueues::Ready(const StageKernels& kernels, std::uint32_t numSlots,
                       std::uint32_t numPaths) {
    const bool hasLists = kernels.Features().HasLists();
    HDS_VERIFY(hasLists || numSlots == numPaths, "each path has its slot");
    _numSlots = numSlots;
    _hasSums = hasLists;
    ResizeBuffer(_device, "path state", numSlots * kernels.PathStateBytes(), &_paths);
    ResizeBuffer(_device, "sums of paths", hasLists ? numPaths * SumBytes(kernels.Features()) : 0,
                 &_sums);
    _bytes = _paths.Bytes() + _sums.Bytes();
    for (std::uint32_t i = 0; i < kNumQueues; ++i) {
        const bool isUsed = hasLists || i < kResumedQueue;
        ResizeBuffer(_device, "ray queue", isUsed ? numSlots * kItemBytes : 0, &_queues[i]);
        _bytes += _queues[i].Bytes();
    }
    const std::uint64_t waitBytes = kernels.Features().streaming ? numSlots * kItemBytes : 0;
    for (auto& side : _waitQueues) {
        for (Buffer& queue : side) {
            ResizeBuffer(_device, "queue of what waits", waitBytes, &queue);
            _bytes += queue.Bytes();
        }
    }
    ResizeBuffer(_device, "queue of ready paths", hasLists ? waitBytes : 0, &_ready);
    _bytes += _ready.Bytes();
}

std::vector<std::uint32_t> WaveQueues::EndedSlots(const Counts& counts, std::uint32_t present,
                                                  std::uint32_t most) const {
    std::vector<std::uint8_t> isInUse(_numSlots, 0);
    std::vector<std::uint32_t> slots(_numSlots);
    const auto mark = [&](const Buffer& queue, std::uint32_t count) {
        queue.Read(slots.data(), count * kItemBytes);
        for (std::uint32_t item = 0; item < count; ++item) {
            isInUse[slots[item]] = 1;
        }
    };
    mark(_queues[present], counts[HDS_COUNTER_ACTIVE]);
    mark(_queues[kShadowQueue], counts[HDS_COUNTER_SHADOW]);
    mark(_ready, counts[HDS_COUNTER_READY]);
    for (std::uint32_t kind = 0; kind < NumWaiting; ++kind) {
        mark(_waitQueues[_side][kind], counts[HDS_COUNTER_WAITING_RAYS + kind]);
    }
    slots.clear();
    for (std::uint32_t slot = 0; slot < _numSlots && slots.size() < most; ++slot) {
        if (isInUse[slot] == 0) {
            slots.push_back(slot);
        }
    }
    return slots;
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

void WaveQueues::ResizeCounters(std::uint32_t numWords) {
    Buffer counters(_device, "counters", numWords * sizeof(std::uint32_t)); // may throw
    _counters = std::move(counters);
    ClearCounter(0, numWords);
}

void WaveQueues::ReadWords(std::uint32_t first, std::uint32_t count, std::uint32_t* values) const {
    _counters.Read(values, count * sizeof(std::uint32_t), first * sizeof(std::uint32_t));
}

void WaveQueues::ClearCounter(std::uint32_t counter, std::uint32_t count) {
    _counters.Fill(0, count * sizeof(std::uint32_t), counter * sizeof(std::uint32_t));
}

void WaveQueues::SetCounter(std::uint32_t counter, std::uint32_t value) {
    _counters.Fill(value, sizeof(std::uint32_t), counter * sizeof(std::uint32_t));
}

} // namespace hds
