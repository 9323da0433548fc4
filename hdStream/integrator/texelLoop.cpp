// SPDX-License-Identifier: Apache-2.0
#include "hdStream/integrator/texelLoop.h"

#include "hdStream/texture/texelWaiters.h"

#include <algorithm>
#include <utility>
#include <vector>

namespace hds {

TexelLoop::TexelLoop(std::shared_ptr<Device> device, SceneBuffers* buffers,
                     RenderStatistics* statistics)
    : _device(std::move(device)), _buffers(buffers), _statistics(statistics) {}

void TexelLoop::Ready(StageKernels* kernels, std::uint32_t maxItems, std::uint32_t iterations) {
    _kernels = kernels;
    _iterations = iterations;
    TexturePool* pool = _buffers->Textures().Pool();
    if (pool == nullptr) {
        _queue = Buffer();
        return;
    }
    const std::uint64_t bytes = maxItems * sizeof(std::uint32_t);
    if (!_queue.IsValid() || _queue.Bytes() < bytes) {
        _queue = Buffer(); // frees first
        _queue = Buffer(_device, "queue of what texels have come for", bytes);
    }
    pool->ReserveItems(maxItems);
    pool->SetAcceptsCoarserMips(false); // a render that failed may have left it
    _kernels->Bind(*_buffers);
}

void TexelLoop::Finish(std::uint32_t numItems, const Relaunch& relaunch) {
    TexturePool* pool = _buffers->Textures().Pool();
    if (pool == nullptr || numItems == 0) {
        return;
    }
    ++_statistics->shadePasses;
    ++_statistics->shadeIterations;
    TexelWaiters waiters(numItems, pool->TakeWaiting());
    std::uint32_t launches = 1;
    while (!waiters.IsEmpty()) {
        _isGivenUp = _isGivenUp || (launches > 1 && _isCancelled && _isCancelled());
        if (_isGivenUp) {
            break; // only after a round: who is cancelled ever again gets on, too
        }
        const std::uint64_t generation = pool->Generation();
        const TexturePool::Outcome outcome =
            pool->ProcessRequests(waiters.NumItems(), _isCancelled);
        if (pool->Generation() != generation) {
            _kernels->Bind(*_buffers);
        }
        _isGivenUp = outcome.isCancelled;
        if (_isGivenUp) {
            break;
        }
        waiters.Continue(outcome);
        ++launches;
        pool->SetAcceptsCoarserMips(_iterations > 0 && launches >= _iterations);
        const std::vector<std::uint32_t> items = waiters.Take();
        _queue.Write(items.data(), items.size() * sizeof(std::uint32_t));
        relaunch(_queue, static_cast<std::uint32_t>(items.size()));
        ++_statistics->shadeIterations;
        waiters.Return(pool->TakeWaiting());
    }
    pool->SetAcceptsCoarserMips(false);
    pool->ExpectAnyItems();
}

double TexelLoop::Seconds() const {
    const TextureStatistics statistics = _buffers->Textures().Statistics();
    return statistics.openSeconds + statistics.readSeconds + statistics.requestSeconds;
}

} // namespace hds
