// SPDX-License-Identifier: Apache-2.0
// The report's own design, which ours is measured against (docs/streaming.md, Report mode): a ray
// batch is over when none of its rays waits, and so is the shading of its hits.
#pragma once

#include "hdStream/integrator/rayLaunches.h"
#include "hdStream/stream/reportPool.h"

#include <memory>

namespace hds {

/// Launches that are repeated until nothing waits, with a round of the pool before each. Rays of
/// both kinds share what is loaded.
class ReportLaunches : public RayLaunches {
public:
    ReportLaunches(StageKernels* kernels, WaveQueues* queues, TexelLoop* texels,
                   RenderStatistics* statistics, ReportPool* pool)
        : RayLaunches(kernels, queues, texels, statistics), _pool(pool) {}

    void TraceBatch(std::uint32_t rays, std::uint32_t numRays, std::uint32_t shadows,
                    std::uint32_t numShadows) override;
    void Launch(WaveQueues::Waiting kind, const Buffer& queue, std::uint32_t count,
                const LaunchItems& launch) override;

private:
    ReportPool* _pool;
};

/// Launches as the kernels wait for chunks: each once, or as the report does.
std::unique_ptr<RayLaunches> MakeRayLaunches(StageKernels* kernels, SceneBuffers* buffers,
                                             WaveQueues* queues, TexelLoop* texels,
                                             RenderStatistics* statistics);

} // namespace hds
