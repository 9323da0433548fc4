// SPDX-License-Identifier: Apache-2.0
#include "hdStream/integrator/waveTracer.h"

#include "hdStream/base/timer.h"

#include <algorithm>
#include <utility>

namespace hds {

namespace {

constexpr std::uint64_t kItemBytes = sizeof(std::uint32_t);

/// Makes or keeps a buffer of exactly so many bytes.
void Resize(Buffer* buffer, const std::shared_ptr<Device>& device, const char* label,
            std::uint64_t bytes) {
    if (!buffer->IsValid() || buffer->Bytes() != bytes) {
        *buffer = Buffer(); // frees first
        *buffer = Buffer(device, label, bytes);
    }
}

} // namespace

WaveTracer::WaveTracer(std::shared_ptr<Device> device, SceneBuffers* buffers,
                       RenderStatistics* statistics)
    : _device(std::move(device)), _buffers(buffers), _statistics(statistics),
      _texels(_device, buffers, statistics) {
    _counters = Buffer(_device, "counters", HDS_NUM_COUNTERS * sizeof(std::uint32_t));
}

std::uint64_t WaveTracer::QueueBytes(const KernelFeatures& features) {
    const std::uint64_t numQueues = features.HasLists() ? 1 + 2 * NumWaiting : 4 + 2 * NumWaiting;
    return kItemBytes * (features.streaming ? numQueues : 4);
}

void WaveTracer::Ready(StageKernels* kernels, bool hasCutouts, std::uint32_t waveSize,
                       std::uint32_t tileSize, std::uint32_t shadeIterations) {
    _kernels = kernels;
    _hasCutouts = hasCutouts;
    _hasLists = kernels->Features().HasLists();
    _waveSize = waveSize;
    _tileSize = _hasLists ? std::min(waveSize, tileSize) : waveSize;
    _texels.Ready(kernels, _tileSize, shadeIterations);
    Resize(&_paths, _device, "path state", waveSize * kernels->PathStateBytes());
    _statistics->pathStateBytes = _paths.Bytes();
    for (Buffer& queue : _queues) {
        Resize(&queue, _device, "ray queue", _tileSize * kItemBytes);
        _statistics->pathStateBytes += queue.Bytes();
    }
    const std::uint64_t waitBytes = kernels->Features().streaming ? waveSize * kItemBytes : 0;
    for (auto& side : _waitQueues) {
        for (Buffer& queue : side) {
            Resize(&queue, _device, "queue of what waits", waitBytes);
            _statistics->pathStateBytes += queue.Bytes();
        }
    }
    Resize(&_ready, _device, "queue of ready paths", _hasLists ? waitBytes : 0);
    _statistics->pathStateBytes += _ready.Bytes();
}

std::array<std::uint32_t, HDS_NUM_COUNTERS> WaveTracer::ReadCounters() const {
    std::array<std::uint32_t, HDS_NUM_COUNTERS> values{};
    _counters.Read(values.data(), sizeof(values));
    return values;
}

void WaveTracer::ClearCounters() {
    ClearCounter(0, HDS_NUM_COUNTERS);
}

void WaveTracer::ClearCounter(std::uint32_t counter, std::uint32_t count) {
    _counters.Fill(0, count * sizeof(std::uint32_t), counter * sizeof(std::uint32_t));
}

/// Seconds that services have taken so far: part of the time of whatever waits for them.
double WaveTracer::ServiceSeconds() const {
    if (!_buffers->IsStreaming()) {
        return _texels.Seconds();
    }
    const StreamingStatistics& pool = _buffers->Streaming().Statistics();
    return pool.serviceSeconds + pool.prepareSeconds + pool.transferSeconds + _texels.Seconds();
}

void WaveTracer::CountIterations(std::uint32_t iterations) {
    ++_statistics->casts;
    _statistics->iterations += iterations;
    _statistics->maxIterationsPerCast = std::max(_statistics->maxIterationsPerCast, iterations);
}

void WaveTracer::Trace(std::uint32_t numSlots, const Generate& generate, const Shade& shade) {
    if (_hasLists) {
        ClearCounter(HDS_COUNTER_WAITING_RAYS, NumWaiting);
        _waitSide = 0;
    }
    for (std::uint32_t first = 0; first < numSlots; first += _tileSize) {
        const std::uint32_t count = std::min(_tileSize, numSlots - first);
        generate(first, count, _queues[_present]);
        RunTile(count, 0, shade);
    }
    if (_hasLists) {
        ResumeAll(shade);
    }
}

/// Traces the paths of queue _present and the shadow rays of the shadow queue until all have ended
/// or wait.
void WaveTracer::RunTile(std::uint32_t active, std::uint32_t numShadows, const Shade& shade) {
    while (active + numShadows > 0) {
        CastNext(active, numShadows);
        const Timer timer;
        const double serviceSeconds = ServiceSeconds();
        if (_buffers->IsStreaming() && !_hasLists) {
            ClearCounter(HDS_COUNTER_ACTIVE);
            ClearCounter(HDS_COUNTER_SHADOW);
            IterateWithPages(WaitingHits, _queues[_present], active,
                             [&](const Buffer& items, std::uint32_t count, const Buffer& waiting) {
                                 shade(items, 0, count, waiting, _queues[1 - _present]);
                             });
        } else {
            ShadeItems(_queues[_present], 0, active, shade);
        }
        const auto counts = ReadCounters();
        _statistics->shadeSeconds += timer.Seconds() - (ServiceSeconds() - serviceSeconds);
        active = counts[HDS_COUNTER_ACTIVE];
        numShadows = counts[HDS_COUNTER_SHADOW];
        _statistics->indirectRays += active;
        _present = 1 - _present;
    }
}

/// Queues the shading of some items; paths that go on come to the queue that is not present.
void WaveTracer::ShadeItems(const Buffer& queue, std::uint32_t first, std::uint32_t count,
                            const Shade& shade) {
    ClearCounter(HDS_COUNTER_ACTIVE);
    ClearCounter(HDS_COUNTER_SHADOW);
    shade(queue, first, count, WaitQueue(WaitingHits), _queues[1 - _present]);
    _texels.Finish(count, [&](const Buffer& items, std::uint32_t numItems) {
        shade(items, 0, numItems, WaitQueue(WaitingHits), _queues[1 - _present]);
    });
}

/// One cast of the paths of queue _present and of the shadow rays that shading has made. Shadow
/// rays that meet cut-out surfaces go on until each is decided or waits.
void WaveTracer::CastNext(std::uint32_t active, std::uint32_t numShadows) {
    const Timer timer;
    const double serviceSeconds = ServiceSeconds();
    _statistics->shadowRays += numShadows;
    ClearCounter(HDS_COUNTER_SHADOW); // counts candidates from here on
    if (_buffers->IsStreaming() && !_hasLists) {
        IterateCast(active, numShadows);
    } else {
        // Paths first: what a slot's shadow ray waits for is noted beside its hit.
        Launch({&_queues[_present], active, WaitingRays}, 0);
        Launch({&_queues[kShadowQueue], numShadows, WaitingShadows}, 0);
        _statistics->casts += _hasLists ? 0 : 1;
    }
    PassCandidates(numShadows);
    _device->Finish();
    _statistics->traceSeconds += timer.Seconds() - (ServiceSeconds() - serviceSeconds);
}

void WaveTracer::Launch(const CastRays& rays, std::uint32_t isResumed) {
    if (rays.kind == WaitingRays) {
        _kernels->intersect.Launch(rays.count, _paths, _waveSize, *rays.queue, rays.count,
                                   isResumed, WaitQueue(WaitingRays), _counters);
    } else {
        _kernels->shadowCast.Launch(rays.count, _paths, _waveSize, *rays.queue, rays.count,
                                    isResumed, WaitQueue(WaitingShadows), _queues[kShadowQueue + 1],
                                    _ready, _counters);
    }
}

/// Sends shadow rays on that have met cut-out surfaces, until there are none.
/// \param numShadows 0: there cannot be any.
void WaveTracer::PassCandidates(std::uint32_t numShadows) {
    const Buffer& candidates = _queues[kShadowQueue + 1];
    const Buffer& shadows = _queues[kShadowQueue];
    while (_hasCutouts && numShadows > 0) {
        const std::uint32_t numCandidates = ReadCounters()[HDS_COUNTER_SHADOW];
        if (numCandidates == 0) {
            return;
        }
        ClearCounter(HDS_COUNTER_SHADOW);
        const auto pass = [&](const Buffer& items, std::uint32_t count, const Buffer& waiting) {
            _kernels->shadowPass.Launch(count, _paths, _waveSize, items, 0U, count, waiting,
                                        shadows, _ready, _counters);
        };
        if (_buffers->IsStreaming() && !_hasLists) {
            IterateWithPages(WaitingCandidates, candidates, numCandidates, pass);
        } else {
            const Buffer& waiting = WaitQueue(WaitingCandidates);
            pass(candidates, numCandidates, waiting);
            _texels.Finish(numCandidates, [&](const Buffer& items, std::uint32_t numItems) {
                pass(items, numItems, waiting);
            });
        }
        numShadows = ReadCounters()[HDS_COUNTER_SHADOW];
        _statistics->shadowRays += numShadows;
        ClearCounter(HDS_COUNTER_SHADOW);
        if (numShadows > 0 && _buffers->IsStreaming() && !_hasLists) {
            IterateCast(0, numShadows);
        } else {
            Launch({&shadows, numShadows, WaitingShadows}, 0);
            _statistics->casts += _hasLists ? 0 : 1;
        }
    }
}

/// Services pages and goes on with what waits for them until nothing does.
void WaveTracer::ResumeAll(const Shade& shade) {
    std::uint32_t iterations = 1;
    while (true) {
        const auto counts = ReadCounters();
        std::array<std::uint32_t, NumWaiting> waiting{};
        std::copy_n(counts.begin() + HDS_COUNTER_WAITING_RAYS, NumWaiting, waiting.begin());
        if (waiting == std::array<std::uint32_t, NumWaiting>{}) {
            break;
        }
        _buffers->Streaming().Service();
        ++iterations;
        _statistics->raysRelaunched += waiting[WaitingRays] + waiting[WaitingShadows];
        const auto& queues = _waitQueues[_waitSide];
        _waitSide = 1 - _waitSide;
        ClearCounter(HDS_COUNTER_WAITING_RAYS, NumWaiting);
        ClearCounter(HDS_COUNTER_READY);
        const Timer timer;
        const double texelSeconds = _texels.Seconds();
        _kernels->intersectResume.Launch(waiting[WaitingRays], _paths, _waveSize,
                                         queues[WaitingRays], waiting[WaitingRays],
                                         WaitQueue(WaitingRays), _ready, _counters);
        ResumeShadows(queues[WaitingShadows], waiting[WaitingShadows]);
        ResumeCandidates(queues[WaitingCandidates], waiting[WaitingCandidates]);
        _device->Finish();
        _statistics->traceSeconds += timer.Seconds() - (_texels.Seconds() - texelSeconds);
        ShadeAll(queues[WaitingHits], 0, waiting[WaitingHits], shade);
        ResumeReady(shade);
    }
    CountIterations(iterations);
}

/// Candidates of a launch must fit the queue of a tile when there are cut-outs.
void WaveTracer::ResumeShadows(const Buffer& queue, std::uint32_t count) {
    const std::uint32_t batch = _hasCutouts ? _tileSize : std::max(1U, count);
    for (std::uint32_t first = 0; first < count; first += batch) {
        const std::uint32_t numItems = std::min(batch, count - first);
        ClearCounter(HDS_COUNTER_SHADOW);
        _kernels->shadowResume.Launch(numItems, _paths, _waveSize, queue, first, numItems,
                                      WaitQueue(WaitingShadows), _queues[kShadowQueue + 1], _ready,
                                      _counters);
        PassCandidates(numItems);
    }
}

void WaveTracer::ResumeCandidates(const Buffer& queue, std::uint32_t count) {
    for (std::uint32_t first = 0; first < count; first += _tileSize) {
        const std::uint32_t numItems = std::min(_tileSize, count - first);
        ClearCounter(HDS_COUNTER_SHADOW);
        const auto pass = [&](const Buffer& items, std::uint32_t begin, std::uint32_t size) {
            _kernels->shadowPass.Launch(size, _paths, _waveSize, items, begin, size,
                                        WaitQueue(WaitingCandidates), _queues[kShadowQueue], _ready,
                                        _counters);
        };
        pass(queue, first, numItems);
        _texels.Finish(numItems, [&](const Buffer& items, std::uint32_t size) {
            pass(items, 0, size);
        });
        const std::uint32_t numShadows = ReadCounters()[HDS_COUNTER_SHADOW];
        _statistics->shadowRays += numShadows;
        ClearCounter(HDS_COUNTER_SHADOW);
        Launch({&_queues[kShadowQueue], numShadows, WaitingShadows}, 0);
        PassCandidates(numShadows);
    }
}

/// Shades items [begin, end) of a queue and traces what comes of it, tile by tile.
void WaveTracer::ShadeAll(const Buffer& queue, std::uint32_t begin, std::uint32_t end,
                          const Shade& shade) {
    for (std::uint32_t first = begin; first < end; first += _tileSize) {
        const Timer timer;
        const double texelSeconds = _texels.Seconds();
        ShadeItems(queue, first, std::min(_tileSize, end - first), shade);
        const auto counts = ReadCounters();
        _statistics->shadeSeconds += timer.Seconds() - (_texels.Seconds() - texelSeconds);
        _statistics->indirectRays += counts[HDS_COUNTER_ACTIVE];
        _present = 1 - _present;
        RunTile(counts[HDS_COUNTER_ACTIVE], counts[HDS_COUNTER_SHADOW], shade);
    }
}

/// Shades the slots that have become ready, also those that do so meanwhile.
void WaveTracer::ResumeReady(const Shade& shade) {
    std::uint32_t done = 0;
    std::uint32_t end = ReadCounters()[HDS_COUNTER_READY];
    while (done < end) {
        ShadeAll(_ready, done, end, shade);
        done = end;
        end = ReadCounters()[HDS_COUNTER_READY];
    }
}

/// One cast without lists: all rays are launched until none waits for a chunk. Both kinds share
/// what is loaded.
void WaveTracer::IterateCast(std::uint32_t active, std::uint32_t numShadows) {
    StreamingPool& pool = _buffers->Streaming();
    std::array<CastRays, 2> kinds = {CastRays{&_queues[_present], active, WaitingRays},
                                     CastRays{&_queues[kShadowQueue], numShadows, WaitingShadows}};
    pool.BeginCast();
    std::uint32_t iterations = 0;
    while (kinds[0].count + kinds[1].count > 0) {
        if (iterations > 0) {
            pool.ServiceCast();
        }
        ClearCounter(HDS_COUNTER_WAITING_RAYS, NumWaiting);
        for (CastRays& rays : kinds) {
            Launch(rays, iterations > 0 ? 1 : 0);
            rays.queue = &WaitQueue(rays.kind);
        }
        const auto counts = ReadCounters();
        for (CastRays& rays : kinds) {
            rays.count = counts[HDS_COUNTER_WAITING_RAYS + rays.kind];
            _statistics->raysRelaunched += rays.count;
        }
        _waitSide = 1 - _waitSide;
        ++iterations;
    }
    CountIterations(iterations);
}

/// Without lists: launches a kernel that needs all pages of the chunks that were hit until no item
/// waits for pages. launch(queue, count, waitQueue).
template <typename LaunchItems>
void WaveTracer::IterateWithPages(Waiting kind, const Buffer& queue, std::uint32_t count,
                                  LaunchItems launch) {
    const Buffer* items = &queue;
    while (count > 0) {
        ClearCounter(HDS_COUNTER_WAITING_RAYS, NumWaiting);
        const Buffer& waiting = WaitQueue(kind);
        launch(*items, count, waiting);
        _texels.Finish(count, [&](const Buffer& missed, std::uint32_t numMissed) {
            launch(missed, numMissed, waiting);
        });
        count = ReadCounters()[HDS_COUNTER_WAITING_RAYS + kind];
        items = &waiting;
        _waitSide = 1 - _waitSide;
        if (count > 0) {
            _buffers->Streaming().Service();
        }
    }
}

} // namespace hds
