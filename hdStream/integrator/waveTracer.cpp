// SPDX-License-Identifier: Apache-2.0
#include "hdStream/integrator/waveTracer.h"

#include "hdStream/base/timer.h"

#include <algorithm>
#include <utility>

namespace hds {

namespace {

constexpr std::uint64_t kItemBytes = sizeof(std::uint32_t);
/// While rays keep lists: launches of less than this part of a tile wait for company. A launch and
/// the reading of its counters cost what some hundred rays do.
constexpr std::uint32_t kCompanyPart = 16;

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
    const std::uint64_t numWaiting = features.streaming ? 2 * NumWaiting : 0;
    return kItemBytes * (numWaiting + (features.HasLists() ? kNumQueues + 1 : kResumedQueue));
}

void WaveTracer::Ready(StageKernels* kernels, bool hasCutouts, std::uint32_t waveSize,
                       std::uint32_t tileSize, std::uint32_t shadeIterations) {
    _kernels = kernels;
    _hasCutouts = hasCutouts;
    _hasLists = kernels->Features().HasLists();
    _waveSize = waveSize;
    _tileSize = _hasLists ? std::min(waveSize, tileSize) : waveSize;
    _texels.Ready(kernels, _waveSize, shadeIterations);
    Resize(&_paths, _device, "path state", waveSize * kernels->PathStateBytes());
    _statistics->pathStateBytes = _paths.Bytes();
    for (std::uint32_t i = 0; i < kNumQueues; ++i) {
        const bool isUsed = _hasLists || i < kResumedQueue;
        Resize(&_queues[i], _device, "ray queue", isUsed ? waveSize * kItemBytes : 0);
        _statistics->pathStateBytes += _queues[i].Bytes();
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

WaveTracer::Counts WaveTracer::ReadCounters() const {
    Counts values{};
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

/// A set of rays that was launched once. With lists it is a part of the wave's.
void WaveTracer::CountCast() {
    if (!_hasLists) {
        CountIterations(1);
    }
}

void WaveTracer::CountIterations(std::uint32_t iterations) {
    ++_statistics->casts;
    _statistics->iterations += iterations;
    _statistics->maxIterationsPerCast = std::max(_statistics->maxIterationsPerCast, iterations);
}

void WaveTracer::Trace(std::uint32_t numSlots, const Generate& generate, const Shade& shade) {
    if (_hasLists) {
        TraceWithLists(numSlots, generate, shade);
    } else {
        generate(0, numSlots, _queues[_present], 0);
        TraceInStep(numSlots, shade);
    }
}

/// Traces the paths of queue _present, bounce by bounce, until all have ended.
void WaveTracer::TraceInStep(std::uint32_t active, const Shade& shade) {
    std::uint32_t numShadows = 0;
    while (active + numShadows > 0) {
        CastNext(active, numShadows);
        const Counts counts = ShadeNext(active, shade);
        active = counts[HDS_COUNTER_ACTIVE];
        numShadows = counts[HDS_COUNTER_SHADOW];
    }
}

/// Traces slots [0, numSlots), which are not in step: when few go on, new ones or, after a service
/// of pages, those that have waited join them.
void WaveTracer::TraceWithLists(std::uint32_t numSlots, const Generate& generate,
                                const Shade& shade) {
    ClearCounter(HDS_COUNTER_WAITING_RAYS, NumWaiting);
    ClearCounter(HDS_COUNTER_READY);
    _waitSide = 0;
    Counts counts{};
    std::uint32_t numBegun = 0;
    std::uint32_t iterations = 1;
    while (true) {
        std::uint32_t active = counts[HDS_COUNTER_ACTIVE];
        const std::uint32_t numShadows = counts[HDS_COUNTER_SHADOW];
        const bool isAlone = active + numShadows < _tileSize / kCompanyPart;
        const bool begins = isAlone && numBegun < numSlots;
        if (begins) {
            const std::uint32_t count = std::min(_tileSize, numSlots - numBegun);
            generate(numBegun, count, _queues[_present], active);
            numBegun += count;
            active += count;
        }
        if (active + numShadows > 0) {
            CastNext(active, numShadows);
            counts = ShadeNext(active, shade);
        }
        const auto waiting = counts.begin() + HDS_COUNTER_WAITING_RAYS;
        const bool isAnyWaiting = std::any_of(waiting, waiting + NumWaiting,
                                              [](std::uint32_t count) { return count > 0; });
        if (isAnyWaiting && isAlone && !begins) {
            counts = ServiceAndResume(counts, shade);
            ++iterations;
        } else if (counts[HDS_COUNTER_READY] > 0) {
            counts = ShadeReady(counts, nullptr, 0, shade);
        } else if (!isAnyWaiting && numBegun == numSlots &&
                   counts[HDS_COUNTER_ACTIVE] + counts[HDS_COUNTER_SHADOW] == 0) {
            break;
        }
    }
    CountIterations(iterations);
}

/// Shades items of a queue, again where texels were missing; paths that go on come to `next`.
void WaveTracer::ShadeItems(const Buffer& queue, std::uint32_t count, const Buffer& next,
                            const Shade& shade) {
    const Buffer& waiting = WaitQueue(WaitingHits);
    shade(queue, count, waiting, next);
    _texels.Finish(count, [&](const Buffer& items, std::uint32_t numItems) {
        shade(items, numItems, waiting, next);
    });
}

/// Shades the paths of queue _present, which becomes the queue of those that go on.
WaveTracer::Counts WaveTracer::ShadeNext(std::uint32_t active, const Shade& shade) {
    const Timer timer;
    const double serviceSeconds = ServiceSeconds();
    ClearCounter(HDS_COUNTER_ACTIVE);
    ClearCounter(HDS_COUNTER_SHADOW);
    if (_buffers->IsStreaming() && !_hasLists) {
        IterateWithPages(WaitingHits, _queues[_present], active,
                         [&](const Buffer& items, std::uint32_t count, const Buffer& waiting) {
                             shade(items, count, waiting, _queues[1 - _present]);
                         });
    } else if (active > 0) {
        ShadeItems(_queues[_present], active, _queues[1 - _present], shade);
    }
    const Counts counts = ReadCounters();
    _present = 1 - _present;
    _statistics->indirectRays += counts[HDS_COUNTER_ACTIVE];
    _statistics->shadeSeconds += timer.Seconds() - (ServiceSeconds() - serviceSeconds);
    return counts;
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
        LaunchRays(_queues[_present], active, 0);
        LaunchShadows(_queues[kShadowQueue], numShadows, kShadowQueue, 0);
        CountCast();
    }
    PassCandidates(numShadows, kShadowQueue);
    _device->Finish();
    _statistics->traceSeconds += timer.Seconds() - (ServiceSeconds() - serviceSeconds);
}

/// \param isResumed without lists: the rays have waited.
void WaveTracer::LaunchRays(const Buffer& queue, std::uint32_t count, std::uint32_t isResumed) {
    _kernels->intersect.Launch(count, _paths, _waveSize, queue, count, isResumed,
                               WaitQueue(WaitingRays), _counters);
}

/// \param shadowQueue candidates come to the queue after it.
void WaveTracer::LaunchShadows(const Buffer& queue, std::uint32_t count, std::uint32_t shadowQueue,
                               std::uint32_t isResumed) {
    _kernels->shadowCast.Launch(count, _paths, _waveSize, queue, count, isResumed,
                                WaitQueue(WaitingShadows), _queues[shadowQueue + 1], _ready,
                                _counters);
}

/// Sends shadow rays on that have met cut-out surfaces, until there are none.
/// \param numShadows 0: there cannot be any. \param shadowQueue for those that go on; candidates
/// are in the one after it.
void WaveTracer::PassCandidates(std::uint32_t numShadows, std::uint32_t shadowQueue) {
    const Buffer& shadows = _queues[shadowQueue];
    const Buffer& candidates = _queues[shadowQueue + 1];
    while (_hasCutouts && numShadows > 0) {
        const std::uint32_t numCandidates = ReadCounters()[HDS_COUNTER_SHADOW];
        if (numCandidates == 0) {
            return;
        }
        ClearCounter(HDS_COUNTER_SHADOW);
        const auto pass = [&](const Buffer& items, std::uint32_t count, const Buffer& waiting) {
            _kernels->shadowPass.Launch(count, _paths, _waveSize, items, count, waiting, shadows,
                                        _ready, _counters);
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
            LaunchShadows(shadows, numShadows, shadowQueue, 0);
            CountCast();
        }
    }
}

/// Services pages and goes on with what waits for them. Appends to the paths and shadow rays that
/// go on already. \param counts as after the last launch. \return them now.
WaveTracer::Counts WaveTracer::ServiceAndResume(const Counts& counts, const Shade& shade) {
    std::array<std::uint32_t, NumWaiting> waiting{};
    std::copy_n(counts.begin() + HDS_COUNTER_WAITING_RAYS, NumWaiting, waiting.begin());
    _buffers->Streaming().Service();
    _statistics->raysRelaunched += waiting[WaitingRays] + waiting[WaitingShadows];
    const auto& queues = _waitQueues[_waitSide];
    _waitSide = 1 - _waitSide;
    ClearCounter(HDS_COUNTER_WAITING_RAYS, NumWaiting);
    const Timer timer;
    const double texelSeconds = _texels.Seconds();
    if (waiting[WaitingRays] > 0) {
        _kernels->intersectResume.Launch(waiting[WaitingRays], _paths, _waveSize,
                                         queues[WaitingRays], waiting[WaitingRays],
                                         WaitQueue(WaitingRays), _ready, _counters);
    }
    ResumeShadows(queues[WaitingShadows], waiting[WaitingShadows]);
    ResumeCandidates(queues[WaitingCandidates], waiting[WaitingCandidates]);
    Counts resumed = ReadCounters();
    _statistics->traceSeconds += timer.Seconds() - (_texels.Seconds() - texelSeconds);
    for (const std::uint32_t counter : {HDS_COUNTER_ACTIVE, HDS_COUNTER_SHADOW}) {
        resumed[counter] = counts[counter];
        _counters.Fill(counts[counter], sizeof(std::uint32_t), counter * sizeof(std::uint32_t));
    }
    return ShadeReady(resumed, &queues[WaitingHits], waiting[WaitingHits], shade);
}

/// Shades slots that have become ready, and hits that have waited. Appends to the paths and shadow
/// rays that go on already.
WaveTracer::Counts WaveTracer::ShadeReady(const Counts& counts, const Buffer* hits,
                                          std::uint32_t numHits, const Shade& shade) {
    const Timer timer;
    const double texelSeconds = _texels.Seconds();
    const std::uint32_t numReady = counts[HDS_COUNTER_READY];
    const Buffer& next = _queues[_present];
    if (numHits > 0) {
        ShadeItems(*hits, numHits, next, shade);
    }
    if (numReady > 0) {
        ShadeItems(_ready, numReady, next, shade);
        ClearCounter(HDS_COUNTER_READY);
    }
    const Counts after = ReadCounters();
    _statistics->indirectRays += after[HDS_COUNTER_ACTIVE] - counts[HDS_COUNTER_ACTIVE];
    _statistics->shadeSeconds += timer.Seconds() - (_texels.Seconds() - texelSeconds);
    return after;
}

void WaveTracer::ResumeShadows(const Buffer& queue, std::uint32_t count) {
    if (count == 0) {
        return;
    }
    ClearCounter(HDS_COUNTER_SHADOW);
    _kernels->shadowResume.Launch(count, _paths, _waveSize, queue, count, WaitQueue(WaitingShadows),
                                  _queues[kResumedQueue + 1], _ready, _counters);
    PassCandidates(count, kResumedQueue);
}

void WaveTracer::ResumeCandidates(const Buffer& queue, std::uint32_t count) {
    if (count == 0) {
        return;
    }
    ClearCounter(HDS_COUNTER_SHADOW);
    const auto pass = [&](const Buffer& items, std::uint32_t numItems) {
        _kernels->shadowPass.Launch(numItems, _paths, _waveSize, items, numItems,
                                    WaitQueue(WaitingCandidates), _queues[kResumedQueue], _ready,
                                    _counters);
    };
    pass(queue, count);
    _texels.Finish(count, pass);
    const std::uint32_t numShadows = ReadCounters()[HDS_COUNTER_SHADOW];
    _statistics->shadowRays += numShadows;
    ClearCounter(HDS_COUNTER_SHADOW);
    LaunchShadows(_queues[kResumedQueue], numShadows, kResumedQueue, 0);
    PassCandidates(numShadows, kResumedQueue);
}

/// One cast without lists: all rays are launched until none waits for a chunk. Both kinds share
/// what is loaded.
void WaveTracer::IterateCast(std::uint32_t active, std::uint32_t numShadows) {
    auto& pool = dynamic_cast<ReportPool&>(_buffers->Streaming());
    const Buffer* rays = &_queues[_present];
    const Buffer* shadows = &_queues[kShadowQueue];
    pool.BeginCast();
    std::uint32_t iterations = 0;
    while (active + numShadows > 0) {
        if (iterations > 0) {
            pool.ServiceCast();
        }
        const std::uint32_t isResumed = iterations > 0 ? 1 : 0;
        ClearCounter(HDS_COUNTER_WAITING_RAYS, NumWaiting);
        LaunchRays(*rays, active, isResumed);
        LaunchShadows(*shadows, numShadows, kShadowQueue, isResumed);
        const Counts counts = ReadCounters();
        active = counts[HDS_COUNTER_WAITING_RAYS];
        numShadows = counts[HDS_COUNTER_WAITING_SHADOWS];
        _statistics->raysRelaunched += active + numShadows;
        rays = &WaitQueue(WaitingRays);
        shadows = &WaitQueue(WaitingShadows);
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
