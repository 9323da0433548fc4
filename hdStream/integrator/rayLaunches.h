// SPDX-License-Identifier: Apache-2.0
// Launches of kernels over the rays of a wave, and over what needs the pages of a hit. One launch
// each, for what waits afterwards goes on by itself; the report's design (reportLaunches.h) ends
// each before it goes on. Explained in docs/wavefront.md and docs/streaming.md.
#pragma once

#include "hdStream/integrator/renderStatistics.h"
#include "hdStream/integrator/texelLoop.h"
#include "hdStream/integrator/waveQueues.h"

#include <cstdint>
#include <functional>

namespace hds {

/// Externally synchronised.
class RayLaunches {
public:
    /// Launches a kernel over `count` items of `queue`; it appends those whose pages are missing to
    /// `waiting`.
    using LaunchItems =
        std::function<void(const Buffer& queue, std::uint32_t count, const Buffer& waiting)>;

    RayLaunches(StageKernels* kernels, WaveQueues* queues, TexelLoop* texels,
                RenderStatistics* statistics)
        : _kernels(kernels), _queues(queues), _texels(texels), _statistics(statistics) {}
    virtual ~RayLaunches() = default;

    /// One set of rays: those of queue `rays`, and the shadow rays of queue `shadows`, whose
    /// candidates come to the queue after it.
    virtual void TraceBatch(std::uint32_t rays, std::uint32_t numRays, std::uint32_t shadows,
                            std::uint32_t numShadows);
    /// Launches over items that need all pages of the chunks that were hit, again where texels were
    /// missing.
    virtual void Launch(WaveQueues::Waiting kind, const Buffer& queue, std::uint32_t count,
                        const LaunchItems& launch);
    /// Goes on with rays that have waited.
    void ResumeRays(const Buffer& queue, std::uint32_t count);
    void ResumeShadows(const Buffer& queue, std::uint32_t count, std::uint32_t shadows);

    /// A batch that took so many iterations.
    void CountIterations(std::uint32_t iterations);

protected:
    void LaunchRays(const Buffer& queue, std::uint32_t count);
    void LaunchShadows(const Buffer& queue, std::uint32_t count, std::uint32_t shadows);
    void LaunchOnce(WaveQueues::Waiting kind, const Buffer& queue, std::uint32_t count,
                    const LaunchItems& launch);

    StageKernels* _kernels;
    WaveQueues* _queues;
    TexelLoop* _texels;
    RenderStatistics* _statistics;
};

} // namespace hds
