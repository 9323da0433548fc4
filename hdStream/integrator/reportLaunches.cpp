// SPDX-License-Identifier: Apache-2.0
#include "hdStream/integrator/reportLaunches.h"

namespace hds {

void ReportLaunches::TraceBatch(std::uint32_t rays, std::uint32_t numRays, std::uint32_t shadows,
                                std::uint32_t numShadows) {
    if (numRays + numShadows == 0) {
        CountIterations(1);
        return;
    }
    _pool->BeginBatch();
    std::uint32_t iterations = 0;
    while (numRays + numShadows > 0) {
        if (iterations == 0) {
            _queues->ClearWaiting();
            LaunchRays(_queues->Queue(rays), numRays);
            LaunchShadows(_queues->Queue(shadows), numShadows, shadows);
        } else {
            _pool->ProcessBatchRequests();
            _queues->Turn();
            ResumeRays(_queues->HaveWaited(WaveQueues::WaitingRays), numRays);
            ResumeShadows(_queues->HaveWaited(WaveQueues::WaitingShadows), numShadows, shadows);
        }
        const WaveQueues::Counts counts = _queues->ReadCounters();
        numRays = counts[HDS_COUNTER_WAITING_RAYS];
        numShadows = counts[HDS_COUNTER_WAITING_SHADOWS];
        _statistics->raysRelaunched += numRays + numShadows;
        ++iterations;
    }
    CountIterations(iterations);
}

void ReportLaunches::Launch(WaveQueues::Waiting kind, const Buffer& queue, std::uint32_t count,
                            const LaunchItems& launch) {
    const Buffer* items = &queue;
    while (count > 0) {
        _queues->Turn();
        LaunchOnce(kind, *items, count, launch);
        count = _queues->ReadCounters()[HDS_COUNTER_WAITING_RAYS + kind];
        items = &_queues->WaitQueue(kind);
        if (count > 0) {
            _pool->ProcessRequests();
        }
    }
}

std::unique_ptr<RayLaunches> MakeRayLaunches(StageKernels* kernels, SceneBuffers* buffers,
                                             WaveQueues* queues, TexelLoop* texels,
                                             RenderStatistics* statistics) {
    if (kernels->Features().requestsFirst) {
        auto& pool = dynamic_cast<ReportPool&>(buffers->Streaming());
        return std::make_unique<ReportLaunches>(kernels, queues, texels, statistics, &pool);
    }
    return std::make_unique<RayLaunches>(kernels, queues, texels, statistics);
}

} // namespace hds
