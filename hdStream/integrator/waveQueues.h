// SPDX-License-Identifier: Apache-2.0
// The path state of a wave, the queues of slots that its kernels read and write, and the counters
// of the queues. Explained in docs/wavefront.md.
#pragma once

#include "hdStream/device/device.h"
#include "hdStream/integrator/stageKernels.h"
#include "kernels/shared/frame.h"

#include <array>
#include <cstdint>
#include <memory>
#include <vector>

namespace hds {

/// Buffers of a wave. Externally synchronised.
class WaveQueues {
public:
    /// By HDS_COUNTER_*.
    using Counts = std::array<std::uint32_t, HDS_NUM_COUNTERS>;
    /// What waits for pages, by kind, in the order of HDS_COUNTER_WAITING_*.
    enum Waiting { WaitingRays, WaitingShadows, WaitingHits, WaitingCandidates, NumWaiting };
    static constexpr std::uint32_t kShadowQueue = 2;  ///< queues 0, 1: paths; 2, 3: shadow rays
    static constexpr std::uint32_t kResumedQueue = 4; ///< 4, 5: shadow rays that have waited
    static constexpr std::uint32_t kNumQueues = 6;

    explicit WaveQueues(std::shared_ptr<Device> device);

    /// Readies buffers for waves of at most `numPaths` paths, of which `numSlots` are in flight at
    /// a time: as many, but for rays that keep lists. \throws Error when memory runs out.
    void Ready(const StageKernels& kernels, std::uint32_t numSlots, std::uint32_t numPaths);
    /// Bytes of queues a slot needs, beside its path's state.
    static std::uint64_t BytesPerSlot(const KernelFeatures& features);
    /// Bytes that a path keeps when its slot is another's.
    static std::uint64_t SumBytes(const KernelFeatures& features);

    std::uint32_t NumSlots() const { return _numSlots; }
    /// What the paths of a wave have gathered, as resolve_addSamples reads it. With lists, and for
    /// a Cryptomatte, the surfaces that their camera rays have met follow behind those of all
    /// paths; behind these the sums of light path expressions.
    const Buffer& Sums() const { return _hasSums ? _sums : _paths; }
    /// Slots of paths that have ended: those in no queue. The lowest ones, at most `most`; all
    /// slots have been used. \param present the queue of paths that go on. Blocks.
    std::vector<std::uint32_t> EndedSlots(const Counts& counts, std::uint32_t present,
                                          std::uint32_t most) const;
    /// Bytes of path state, queues and sums.
    std::uint64_t Bytes() const { return _bytes; }
    const Buffer& Paths() const { return _paths; }
    const Buffer& Queue(std::uint32_t i) const { return _queues[i]; }
    /// Puts slots into a queue, from item `first` on.
    void WriteQueue(std::uint32_t i, const std::vector<std::uint32_t>& slots, std::uint32_t first) {
        _queues[i].Write(slots.data(), slots.size() * sizeof(std::uint32_t),
                         first * sizeof(std::uint32_t));
    }
    /// Slots that may be shaded after they have waited.
    const Buffer& ReadySlots() const { return _ready; }

    /// Where kernels append what waits; the other side is what waited before the last Turn.
    const Buffer& WaitQueue(Waiting kind) const { return _waitQueues[_side][kind]; }
    const Buffer& HaveWaited(Waiting kind) const { return _waitQueues[1 - _side][kind]; }
    /// What waits has waited; the queues to append to are empty.
    void Turn();
    /// Nothing waits.
    void ClearWaiting() { ClearCounter(HDS_COUNTER_WAITING_RAYS, NumWaiting); }

    const Buffer& Counters() const { return _counters; }
    Counts ReadCounters() const;
    void ClearCounter(std::uint32_t counter, std::uint32_t count = 1);
    void SetCounter(std::uint32_t counter, std::uint32_t value);
    /// Makes the counters anew, all 0, with other words behind them.
    void ResizeCounters(std::uint32_t numWords);
    void ReadWords(std::uint32_t first, std::uint32_t count, std::uint32_t* values) const;

private:
    std::shared_ptr<Device> _device;
    std::uint32_t _numSlots = 0;
    std::uint64_t _bytes = 0;
    std::uint32_t _side = 0;
    Buffer _paths;
    Buffer _sums;
    bool _hasSums = false; ///< apart from the state of paths
    std::array<Buffer, kNumQueues> _queues;
    std::array<std::array<Buffer, NumWaiting>, 2> _waitQueues;
    Buffer _ready;
    Buffer _counters;
};

} // namespace hds
