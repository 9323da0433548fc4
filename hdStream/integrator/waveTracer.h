// SPDX-License-Identifier: Apache-2.0
// Traces the paths of a wave: intersect, shadow and shade in turn until all have ended; while
// geometry streams, what waits for pages goes on after each service. Explained in docs/wavefront.md
// and docs/streaming.md.
#pragma once

#include "hdStream/integrator/renderStatistics.h"
#include "hdStream/integrator/stageKernels.h"
#include "hdStream/integrator/texelLoop.h"
#include "kernels/shared/frame.h"

#include <array>
#include <cstdint>
#include <functional>

namespace hds {

/// Path state and queues of a wave, and the order of launches. Externally synchronised.
class WaveTracer {
public:
    /// By HDS_COUNTER_*.
    using Counts = std::array<std::uint32_t, HDS_NUM_COUNTERS>;
    /// Launches the kernel that fills slots [first, first + count), and `queue` with them from
    /// `queueFirst` on.
    using Generate = std::function<void(std::uint32_t first, std::uint32_t count,
                                        const Buffer& queue, std::uint32_t queueFirst)>;
    /// Launches the kernel that shades `count` items of `queue`; it appends paths that go on to
    /// `next` and those whose pages are missing to `waiting`.
    using Shade = std::function<void(const Buffer& queue, std::uint32_t count,
                                     const Buffer& waiting, const Buffer& next)>;

    WaveTracer(std::shared_ptr<Device> device, SceneBuffers* buffers, RenderStatistics* statistics);

    /// Readies buffers for waves of at most `waveSize` paths, begun in tiles of `tileSize`.
    /// \param shadeIterations as RenderOptions::shadeIterations.
    /// \throws Error when memory runs out.
    void Ready(StageKernels* kernels, bool hasCutouts, std::uint32_t waveSize,
               std::uint32_t tileSize, std::uint32_t shadeIterations);

    /// Traces slots [0, numSlots) to completion.
    void Trace(std::uint32_t numSlots, const Generate& generate, const Shade& shade);

    /// Bytes of queues a path needs, beside its state.
    static std::uint64_t QueueBytes(const KernelFeatures& features);

    std::uint32_t WaveSize() const { return _waveSize; }
    const Buffer& Paths() const { return _paths; }
    const Buffer& ShadowQueue() const { return _queues[kShadowQueue]; }
    const Buffer& Counters() const { return _counters; }
    Counts ReadCounters() const;
    void ClearCounters();

private:
    /// What waits for pages, by kind, in the order of HDS_COUNTER_WAITING_*.
    enum Waiting { WaitingRays, WaitingShadows, WaitingHits, WaitingCandidates, NumWaiting };
    static constexpr std::uint32_t kShadowQueue = 2;  ///< queues 0, 1: paths; 2, 3: shadow rays
    static constexpr std::uint32_t kResumedQueue = 4; ///< 4, 5: shadow rays that have waited
    static constexpr std::uint32_t kNumQueues = 6;

    void ClearCounter(std::uint32_t counter, std::uint32_t count = 1);
    double ServiceSeconds() const;
    const Buffer& WaitQueue(Waiting kind) const { return _waitQueues[_waitSide][kind]; }
    void TraceInStep(std::uint32_t active, const Shade& shade);
    void TraceWithLists(std::uint32_t numSlots, const Generate& generate, const Shade& shade);
    void CastNext(std::uint32_t active, std::uint32_t numShadows);
    void PassCandidates(std::uint32_t numShadows, std::uint32_t shadowQueue);
    void LaunchRays(const Buffer& queue, std::uint32_t count, std::uint32_t isResumed);
    void LaunchShadows(const Buffer& queue, std::uint32_t count, std::uint32_t shadowQueue,
                       std::uint32_t isResumed);
    void ShadeItems(const Buffer& queue, std::uint32_t count, const Buffer& next,
                    const Shade& shade);
    Counts ShadeNext(std::uint32_t active, const Shade& shade);
    Counts ShadeReady(const Counts& counts, const Buffer* hits, std::uint32_t numHits,
                      const Shade& shade);
    Counts ServiceAndResume(const Counts& counts, const Shade& shade);
    void ResumeShadows(const Buffer& queue, std::uint32_t count);
    void ResumeCandidates(const Buffer& queue, std::uint32_t count);
    void IterateCast(std::uint32_t active, std::uint32_t numShadows);
    template <typename LaunchItems>
    void IterateWithPages(Waiting kind, const Buffer& queue, std::uint32_t count,
                          LaunchItems launch);
    void CountCast();
    void CountIterations(std::uint32_t iterations);

    std::shared_ptr<Device> _device;
    SceneBuffers* _buffers;
    RenderStatistics* _statistics;
    StageKernels* _kernels = nullptr;
    bool _hasCutouts = false;
    bool _hasLists =
        false; ///< rays that wait keep lists; else all rays of a cast wait for each other
    std::uint32_t _waveSize = 0;
    std::uint32_t _tileSize = 0;
    std::uint32_t _present = 0; ///< queue of the paths that are traced
    std::uint32_t _waitSide = 0;
    Buffer _paths;
    std::array<Buffer, kNumQueues> _queues;
    std::array<std::array<Buffer, NumWaiting>, 2> _waitQueues; ///< one side is read, one filled
    TexelLoop _texels;
    Buffer _ready; ///< slots that may be shaded after they have waited
    Buffer _counters;
};

} // namespace hds
