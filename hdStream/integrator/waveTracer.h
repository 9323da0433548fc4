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

#include <array>
#include <cstdint>
#include <functional>
#include <memory>
#include <vector>

namespace hds {

/// The order of launches over the queues of a wave. Externally synchronised.
class WaveTracer {
public:
    using Counts = WaveQueues::Counts;
    /// Launches the kernel that begins paths [first, first + count) of the wave, in slots that
    /// `queue` has from `queueFirst` on; without lists it writes them there.
    using Generate = std::function<void(std::uint32_t first, std::uint32_t count,
                                        const Buffer& queue, std::uint32_t queueFirst)>;
    /// Launches the kernel that shades `count` items of `queue`; it appends paths that go on to
    /// `next` and those whose pages are missing to `waiting`.
    using Shade = std::function<void(const Buffer& queue, std::uint32_t count,
                                     const Buffer& waiting, const Buffer& next)>;

    WaveTracer(std::shared_ptr<Device> device, SceneBuffers* buffers, RenderStatistics* statistics);

    /// Of a wave at most.
    struct Size {
        std::uint32_t numSlots = 0; ///< paths in flight at a time
        std::uint32_t numPaths = 0; ///< without lists: as many
    };

    /// Readies buffers for waves that are begun in tiles of `tileSize`.
    /// \param shadeIterations as RenderOptions::shadeIterations.
    /// \throws Error when memory runs out.
    void Ready(StageKernels* kernels, bool hasCutouts, Size size, std::uint32_t tileSize,
               std::uint32_t shadeIterations);

    /// Asked between launches, and between what they wait for; true ends the wave.
    using IsCancelled = std::function<bool()>;

    /// Traces paths [0, numPaths) to completion. \return false when it was cancelled before: the
    /// sums are not those of samples then.
    bool Trace(std::uint32_t numPaths, const Generate& generate, const Shade& shade,
               const IsCancelled& isCancelled);

    /// Bytes of queues a slot needs, beside its path's state; and of a path, beside its slot, with
    /// lists.
    static std::uint64_t SlotQueueBytes(const KernelFeatures& features) {
        return WaveQueues::BytesPerSlot(features);
    }
    static std::uint64_t SumBytes(const KernelFeatures& features) {
        return WaveQueues::SumBytes(features);
    }

    std::uint32_t NumSlots() const { return _queues.NumSlots(); }
    std::uint32_t MaxPaths() const { return _maxPaths; }
    const Buffer& Paths() const { return _queues.Paths(); }
    const Buffer& Sums() const { return _queues.Sums(); }
    const Buffer& ShadowQueue() const { return _queues.Queue(WaveQueues::kShadowQueue); }
    const Buffer& Counters() const { return _queues.Counters(); }
    Counts ReadCounters() const { return _queues.ReadCounters(); }
    void ClearCounters() { _queues.ClearCounter(0, HDS_GUIDE_CELLS); }

    /// Between the first and the last of these, rays that meet nothing are counted for the guide of
    /// domes. \param scale factor on throughput, for 1 at the camera.
    void BeginDomeGuide(const std::array<float, 3>& camera, float scale);
    /// Of the rays that surfaces have sent on and that have ended: the share of those counted.
    double ReadDomeGuideShare() const;
    std::vector<std::uint32_t> ReadDomeGuide() const;
    /// Clears all counters, too.
    void EndDomeGuide() { _queues.ResizeCounters(HDS_GUIDE_CELLS); }

private:
    double RequestSeconds() const;
    void ClearBounce();
    void TraceInStep(std::uint32_t active, const Shade& shade, const IsCancelled& isStopped);
    bool IsBrief(std::uint32_t numRays) const;
    Counts TraceAndShade(std::uint32_t active, std::uint32_t numShadows, const Shade& shade);
    void TraceWithLists(std::uint32_t numPaths, const Generate& generate, const Shade& shade,
                        const IsCancelled& isStopped);
    bool HasSlotsFor(const Counts& counts, std::uint32_t numBegun) const;
    std::uint32_t BeginPaths(const Counts& counts, std::uint32_t numBegun, std::uint32_t numPaths,
                             const Generate& generate);
    void KeepSums(std::uint32_t first, std::uint32_t count);
    void TraceNextBatch(std::uint32_t active, std::uint32_t numShadows);
    void PassCandidates(std::uint32_t numShadows, std::uint32_t shadowQueue);
    void LaunchPass(const Buffer& queue, std::uint32_t count, std::uint32_t shadowQueue);
    void ShadeItems(const Buffer& queue, std::uint32_t count, const Buffer& next,
                    const Shade& shade);
    Counts ShadeNext(std::uint32_t active, const Shade& shade);
    Counts ShadeReady(const Counts& counts, const Buffer* hits, std::uint32_t numHits,
                      const Shade& shade);
    Counts ProcessRequestsAndResume(const Counts& counts, const Shade& shade,
                                    const IsCancelled& isStopped);
    void ResumeShadows(const Buffer& queue, std::uint32_t count);
    void ResumeCandidates(const Buffer& queue, std::uint32_t count);

    std::shared_ptr<Device> _device;
    SceneBuffers* _buffers;
    RenderStatistics* _statistics;
    StageKernels* _kernels = nullptr;
    bool _hasCutouts = false;
    bool _hasLists = false; ///< what waits goes on by itself
    std::uint32_t _maxPaths = 0;
    std::uint32_t _tileSize = 0;
    std::uint32_t _present = 0; ///< queue of the paths that are traced
    WaveQueues _queues;
    TexelLoop _texels;
    std::unique_ptr<RayLaunches> _launches;
};

} // namespace hds
