// SPDX-License-Identifier: Apache-2.0
// Traces the paths of a wave: intersect, shadow and shade in turn until all have ended; while
// geometry streams, what waits for pages goes on after each round of requests. Explained in
// docs/wavefront.md and docs/streaming.md.
#pragma once

#include "hdStream/integrator/rayLaunches.h"
#include "hdStream/integrator/renderStatistics.h"
#include "hdStream/integrator/stageKernels.h"
#include "hdStream/integrator/texelLoop.h"
#include "hdStream/integrator/waveQueues.h"

#include <cstdint>
#include <functional>
#include <memory>

namespace hds {

/// The order of launches over the queues of a wave. Externally synchronised.
class WaveTracer {
public:
    using Counts = WaveQueues::Counts;
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

    /// Asked between launches; true ends the wave.
    using IsCancelled = std::function<bool()>;

    /// Traces slots [0, numSlots) to completion. \return false when it was cancelled before: the
    /// radiance of the slots is not that of samples then.
    bool Trace(std::uint32_t numSlots, const Generate& generate, const Shade& shade,
               const IsCancelled& isCancelled);

    /// Bytes of queues a path needs, beside its state.
    static std::uint64_t QueueBytes(const KernelFeatures& features) {
        return WaveQueues::BytesPerPath(features);
    }

    std::uint32_t WaveSize() const { return _queues.WaveSize(); }
    const Buffer& Paths() const { return _queues.Paths(); }
    const Buffer& ShadowQueue() const { return _queues.Queue(WaveQueues::kShadowQueue); }
    const Buffer& Counters() const { return _queues.Counters(); }
    Counts ReadCounters() const { return _queues.ReadCounters(); }
    void ClearCounters() { _queues.ClearCounter(0, HDS_NUM_COUNTERS); }

private:
    double RequestSeconds() const;
    bool TraceInStep(std::uint32_t active, const Shade& shade, const IsCancelled& isCancelled);
    bool TraceWithLists(std::uint32_t numSlots, const Generate& generate, const Shade& shade,
                        const IsCancelled& isCancelled);
    void TraceNextBatch(std::uint32_t active, std::uint32_t numShadows);
    void PassCandidates(std::uint32_t numShadows, std::uint32_t shadowQueue);
    void LaunchPass(const Buffer& queue, std::uint32_t count, std::uint32_t shadowQueue);
    void ShadeItems(const Buffer& queue, std::uint32_t count, const Buffer& next,
                    const Shade& shade);
    Counts ShadeNext(std::uint32_t active, const Shade& shade);
    Counts ShadeReady(const Counts& counts, const Buffer* hits, std::uint32_t numHits,
                      const Shade& shade);
    Counts ProcessRequestsAndResume(const Counts& counts, const Shade& shade);
    void ResumeShadows(const Buffer& queue, std::uint32_t count);
    void ResumeCandidates(const Buffer& queue, std::uint32_t count);

    std::shared_ptr<Device> _device;
    SceneBuffers* _buffers;
    RenderStatistics* _statistics;
    StageKernels* _kernels = nullptr;
    bool _hasCutouts = false;
    bool _hasLists = false; ///< what waits goes on by itself
    std::uint32_t _tileSize = 0;
    std::uint32_t _present = 0; ///< queue of the paths that are traced
    WaveQueues _queues;
    TexelLoop _texels;
    std::unique_ptr<RayLaunches> _launches;
};

} // namespace hds
