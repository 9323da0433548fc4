// SPDX-License-Identifier: Apache-2.0
#include "hdStream/integrator/rayLaunches.h"

#include <algorithm>

namespace hds {

void RayLaunches::TraceBatch(std::uint32_t rays, std::uint32_t numRays, std::uint32_t shadows,
                             std::uint32_t numShadows) {
    // Paths first: what a slot's shadow ray waits for is noted beside its hit.
    LaunchRays(_queues->Queue(rays), numRays);
    LaunchShadows(_queues->Queue(shadows), numShadows, shadows);
    if (!_kernels->Features().HasLists()) {
        CountIterations(1); // with lists it is a part of the wave's
    }
}

void RayLaunches::Launch(WaveQueues::Waiting kind, const Buffer& queue, std::uint32_t count,
                         const LaunchItems& launch) {
    LaunchOnce(kind, queue, count, launch);
}

void RayLaunches::LaunchOnce(WaveQueues::Waiting kind, const Buffer& queue, std::uint32_t count,
                             const LaunchItems& launch) {
    const Buffer& waiting = _queues->WaitQueue(kind);
    launch(queue, count, waiting);
    _texels->Finish(count, [&](const Buffer& items, std::uint32_t numItems) {
        launch(items, numItems, waiting);
    });
}

void RayLaunches::LaunchRays(const Buffer& queue, std::uint32_t count) {
    _kernels->intersect.Launch(count, _queues->Paths(), _queues->NumSlots(), queue, count,
                               _queues->WaitQueue(WaveQueues::WaitingRays), _queues->Counters());
}

void RayLaunches::LaunchShadows(const Buffer& queue, std::uint32_t count, std::uint32_t shadows) {
    _kernels->shadowCast.Launch(count, _queues->Paths(), _queues->NumSlots(), queue, count,
                                _queues->WaitQueue(WaveQueues::WaitingShadows),
                                _queues->Queue(shadows + 1), _queues->ReadySlots(),
                                _queues->Counters());
}

void RayLaunches::ResumeRays(const Buffer& queue, std::uint32_t count) {
    _kernels->intersectResume.Launch(count, _queues->Paths(), _queues->NumSlots(), queue, count,
                                     _queues->WaitQueue(WaveQueues::WaitingRays),
                                     _queues->ReadySlots(), _queues->Counters());
}

void RayLaunches::ResumeShadows(const Buffer& queue, std::uint32_t count, std::uint32_t shadows) {
    _kernels->shadowResume.Launch(count, _queues->Paths(), _queues->NumSlots(), queue, count,
                                  _queues->WaitQueue(WaveQueues::WaitingShadows),
                                  _queues->Queue(shadows + 1), _queues->ReadySlots(),
                                  _queues->Counters());
}

void RayLaunches::CountIterations(std::uint32_t iterations) {
    ++_statistics->rayBatches;
    _statistics->iterations += iterations;
    _statistics->maxIterationsPerBatch = std::max(_statistics->maxIterationsPerBatch, iterations);
}

} // namespace hds
