// SPDX-License-Identifier: Apache-2.0
#include "hdStream/integrator/waveTracer.h"

#include "hdStream/base/timer.h"
#include "hdStream/integrator/reportLaunches.h"
#include "hdStream/integrator/shadowLaunches.h"
#include "kernels/shared/light.h"

#include <algorithm>
#include <array>
#include <cstring>
#include <numeric>
#include <utility>

namespace hds {

namespace {

std::uint32_t BitsOf(float value) {
    std::uint32_t bits = 0;
    std::memcpy(&bits, &value, sizeof(bits));
    return bits;
}

constexpr std::uint32_t kGuideCells = HDS_GUIDE_PLACES * HDS_GUIDE_ROWS * HDS_GUIDE_COLUMNS;

/// While rays keep lists: launches of less than this part of a tile wait for company. A launch and
/// the reading of its counters cost what some hundred rays do.
constexpr std::uint32_t kCompanyPart = 16;

/// Batches of fewer rays are traced and shaded without a wait in between, which takes as long as
/// tracing some hundred rays. Nobody needs to know which of the two took how long.
constexpr std::uint32_t kBriefBatch = 2048;

static_assert(HDS_COUNTER_SHADOW == HDS_COUNTER_ACTIVE + 1, "both are cleared at once");

} // namespace

WaveTracer::WaveTracer(std::shared_ptr<Device> device, SceneBuffers* buffers,
                       RenderStatistics* statistics)
    : _device(std::move(device)), _buffers(buffers), _statistics(statistics), _queues(_device),
      _texels(_device, buffers, statistics) {}

void WaveTracer::Ready(StageKernels* kernels, bool hasCutouts, Size size, std::uint32_t tileSize,
                       std::uint32_t shadeIterations) {
    _kernels = kernels;
    _maxPaths = size.numPaths;
    _hasCutouts = hasCutouts;
    _hasLists = kernels->Features().HasLists();
    // Tiles of equal size, so that no small one is left.
    const std::uint32_t numTiles = _hasLists ? (size.numSlots + tileSize - 1) / tileSize : 1;
    _tileSize = (size.numSlots + numTiles - 1) / numTiles;
    _texels.Ready(kernels, size.numSlots, shadeIterations);
    _queues.Ready(*kernels, size.numSlots, size.numPaths);
    _statistics->pathStateBytes = _queues.Bytes();
    _launches = MakeRayLaunches(kernels, _buffers, &_queues, &_texels, _statistics);
}

/// Seconds that rounds of requests have taken so far: part of the time of whatever waits for them.
double WaveTracer::RequestSeconds() const {
    if (!_buffers->IsStreaming()) {
        return _texels.Seconds();
    }
    const StreamingStatistics& pool = _buffers->Streaming().Statistics();
    return pool.requestSeconds + pool.prepareSeconds + pool.transferSeconds + _texels.Seconds();
}

void WaveTracer::BeginDomeGuide(const std::array<float, 3>& camera, float scale) {
    _queues.ResizeCounters(HDS_GUIDE_CELLS + kGuideCells);
    for (std::uint32_t axis = 0; axis < camera.size(); ++axis) {
        _queues.SetCounter(HDS_GUIDE_CAMERA + axis, BitsOf(camera[axis]));
    }
    _queues.SetCounter(HDS_GUIDE_SCALE, BitsOf(scale));
}

double WaveTracer::ReadDomeGuideShare() const {
    std::uint32_t escaped = 0;
    std::uint32_t ended = 0;
    _queues.ReadWords(HDS_GUIDE_ESCAPED, 1, &escaped);
    _queues.ReadWords(HDS_GUIDE_ENDED, 1, &ended);
    return ended == 0 ? 0.0 : double(escaped) / double(ended);
}

std::vector<std::uint32_t> WaveTracer::ReadDomeGuide() const {
    std::vector<std::uint32_t> cells(kGuideCells);
    _queues.ReadWords(HDS_GUIDE_CELLS, kGuideCells, cells.data());
    return cells;
}

bool WaveTracer::Trace(std::uint32_t numPaths, const Generate& generate, const Shade& shade,
                       const IsCancelled& isCancelled) {
    bool isOver = false; // once told, it is not asked again
    const IsCancelled isStopped = [&] {
        isOver = isOver || (isCancelled && isCancelled());
        return isOver;
    };
    _texels.Watch(isStopped);
    if (_hasLists) {
        TraceWithLists(numPaths, generate, shade, isStopped);
    } else {
        ClearBounce(); // takes no command while nothing is queued
        generate(0, numPaths, _queues.Queue(_present), 0);
        TraceInStep(numPaths, shade, isStopped);
    }
    _texels.Watch({});
    return !isOver; // the last to ask may have been those that wait for texels
}

/// Of what shading sends on.
void WaveTracer::ClearBounce() {
    _queues.ClearCounter(HDS_COUNTER_ACTIVE, 2);
}

/// Traces the paths of queue _present, bounce by bounce, until all have ended or it is cancelled.
/// Precondition: ClearBounce.
void WaveTracer::TraceInStep(std::uint32_t active, const Shade& shade,
                             const IsCancelled& isStopped) {
    std::uint32_t numShadows = 0;
    bool isCleared = true;
    Counts counts{};
    if (PassesShadowsAtOnce(_kernels->Features())) {
        _queues.ClearCounter(HDS_COUNTER_PASSED);
    }
    while (active + numShadows > 0 && !isStopped()) {
        if (IsBrief(active + numShadows)) {
            if (!isCleared) {
                ClearBounce();
            }
            counts = TraceAndShade(active, numShadows, shade);
        } else {
            TraceNextBatch(active, numShadows);
            counts = ShadeNext(active, shade);
        }
        isCleared = false;
        active = counts[HDS_COUNTER_ACTIVE];
        numShadows = counts[HDS_COUNTER_SHADOW];
    }
    if (PassesShadowsAtOnce(_kernels->Features())) {
        _statistics->shadowRays += counts[HDS_COUNTER_PASSED];
    }
}

/// Whether a batch may be shaded before anybody looks at what tracing it has found.
bool WaveTracer::IsBrief(std::uint32_t numRays) const {
    const bool mayHaveCandidates = _hasCutouts && !PassesShadowsAtOnce(_kernels->Features());
    return numRays < kBriefBatch && !mayHaveCandidates && !_buffers->IsStreaming();
}

/// TraceNextBatch and ShadeNext with one wait. Precondition: ClearBounce.
WaveTracer::Counts WaveTracer::TraceAndShade(std::uint32_t active, std::uint32_t numShadows,
                                             const Shade& shade) {
    const Timer timer;
    const double requestSeconds = RequestSeconds();
    _statistics->shadowRays += numShadows;
    ++_statistics->briefBatches;
    _launches->TraceBatch(_present, active, WaveQueues::kShadowQueue, numShadows);
    if (active > 0) {
        ShadeItems(_queues.Queue(_present), active, _queues.Queue(1 - _present), shade);
    }
    const Counts counts = _queues.ReadCounters();
    _present = 1 - _present;
    _statistics->indirectRays += counts[HDS_COUNTER_ACTIVE];
    _statistics->traceSeconds += timer.Seconds() - (RequestSeconds() - requestSeconds);
    return counts;
}

/// Traces paths [0, numPaths), which are not in step: when few go on, new ones or, after a round
/// of pages, those that have waited join them. Ends before when it is cancelled.
void WaveTracer::TraceWithLists(std::uint32_t numPaths, const Generate& generate,
                                const Shade& shade, const IsCancelled& isStopped) {
    _queues.ClearWaiting();
    _queues.ClearCounter(HDS_COUNTER_READY);
    Counts counts{};
    std::uint32_t numBegun = 0;
    std::uint32_t iterations = 1;
    while (true) {
        if (isStopped()) {
            return;
        }
        std::uint32_t active = counts[HDS_COUNTER_ACTIVE];
        const std::uint32_t numShadows = counts[HDS_COUNTER_SHADOW];
        const bool isAlone = active + numShadows < _tileSize / kCompanyPart;
        const bool begins = isAlone && numBegun < numPaths && HasSlotsFor(counts, numBegun);
        if (begins) {
            const std::uint32_t count = BeginPaths(counts, numBegun, numPaths, generate);
            numBegun += count;
            active += count;
        }
        if (active + numShadows > 0) {
            TraceNextBatch(active, numShadows);
            counts = ShadeNext(active, shade);
        }
        const auto waiting = counts.begin() + HDS_COUNTER_WAITING_RAYS;
        const bool isAnyWaiting = std::any_of(waiting, waiting + WaveQueues::NumWaiting,
                                              [](std::uint32_t count) { return count > 0; });
        if (isAnyWaiting && isAlone && !begins) {
            counts = ProcessRequestsAndResume(counts, shade, isStopped);
            ++iterations;
        } else if (counts[HDS_COUNTER_READY] > 0) {
            counts = ShadeReady(counts, nullptr, 0, shade);
        } else if (!isAnyWaiting && numBegun == numPaths &&
                   counts[HDS_COUNTER_ACTIVE] + counts[HDS_COUNTER_SHADOW] == 0) {
            break;
        }
    }
    std::vector<std::uint32_t> slots(std::min(numBegun, NumSlots()));
    std::iota(slots.begin(), slots.end(), 0U);
    _queues.WriteQueue(_present, slots, 0);
    KeepSums(0, static_cast<std::uint32_t>(slots.size()));
    _launches->CountIterations(iterations);
}

/// Whether there are slots for paths to begin in: some that no path has had yet, or a tile, or half
/// of all, of paths that have ended. Fewer would lie scattered between those that wait, and share
/// no cache lines. Where nothing waits and few go on there are.
bool WaveTracer::HasSlotsFor(const Counts& counts, std::uint32_t numBegun) const {
    std::uint32_t inUse =
        counts[HDS_COUNTER_ACTIVE] + counts[HDS_COUNTER_SHADOW] + counts[HDS_COUNTER_READY];
    for (std::uint32_t kind = 0; kind < WaveQueues::NumWaiting; ++kind) {
        inUse += counts[HDS_COUNTER_WAITING_RAYS + kind]; // a slot may be in two queues
    }
    return numBegun < NumSlots() || inUse + std::min(_tileSize, NumSlots() / 2) <= NumSlots();
}

/// Begins paths of the wave: a tile of them at most. They join the paths of queue _present.
/// \return how many.
std::uint32_t WaveTracer::BeginPaths(const Counts& counts, std::uint32_t numBegun,
                                     std::uint32_t numPaths, const Generate& generate) {
    const std::uint32_t most = std::min(_tileSize, numPaths - numBegun);
    const std::uint32_t active = counts[HDS_COUNTER_ACTIVE];
    const bool areNew = numBegun < NumSlots();
    std::vector<std::uint32_t> slots;
    if (areNew) {
        slots.resize(std::min(most, NumSlots() - numBegun));
        std::iota(slots.begin(), slots.end(), numBegun);
    } else {
        slots = _queues.EndedSlots(counts, _present, most);
    }
    _queues.WriteQueue(_present, slots, active);
    const auto count = static_cast<std::uint32_t>(slots.size());
    if (!areNew) {
        KeepSums(active, count);
    }
    generate(numBegun, count, _queues.Queue(_present), active);
    return count;
}

/// Of paths that have ended: keeps what they have gathered. \param first item of queue _present.
void WaveTracer::KeepSums(std::uint32_t first, std::uint32_t count) {
    _kernels->keepSums.Launch(count, _queues.Paths(), NumSlots(), _queues.Queue(_present), first,
                              count, _queues.Sums(), _maxPaths);
}

/// Shades items of a queue; paths that go on come to `next`.
void WaveTracer::ShadeItems(const Buffer& queue, std::uint32_t count, const Buffer& next,
                            const Shade& shade) {
    _launches->Launch(WaveQueues::WaitingHits, queue, count,
                      [&](const Buffer& items, std::uint32_t numItems, const Buffer& waiting) {
                          shade(items, numItems, waiting, next);
                      });
}

/// Shades the paths of queue _present, which becomes the queue of those that go on.
WaveTracer::Counts WaveTracer::ShadeNext(std::uint32_t active, const Shade& shade) {
    const Timer timer;
    const double requestSeconds = RequestSeconds();
    _queues.ClearCounter(HDS_COUNTER_ACTIVE);
    _queues.ClearCounter(HDS_COUNTER_SHADOW);
    if (active > 0) {
        ShadeItems(_queues.Queue(_present), active, _queues.Queue(1 - _present), shade);
    }
    const Counts counts = _queues.ReadCounters();
    _present = 1 - _present;
    _statistics->indirectRays += counts[HDS_COUNTER_ACTIVE];
    _statistics->shadeSeconds += timer.Seconds() - (RequestSeconds() - requestSeconds);
    return counts;
}

/// One ray batch: the paths of queue _present and of the shadow rays that shading has made. Shadow
/// rays that meet cut-out surfaces go on until each is decided or waits.
void WaveTracer::TraceNextBatch(std::uint32_t active, std::uint32_t numShadows) {
    const Timer timer;
    const double requestSeconds = RequestSeconds();
    _statistics->shadowRays += numShadows;
    _queues.ClearCounter(HDS_COUNTER_SHADOW); // counts candidates from here on
    _launches->TraceBatch(_present, active, WaveQueues::kShadowQueue, numShadows);
    PassCandidates(numShadows, WaveQueues::kShadowQueue);
    _device->Finish();
    _statistics->traceSeconds += timer.Seconds() - (RequestSeconds() - requestSeconds);
}

/// Sends shadow rays on that have met cut-out surfaces, until there are none.
/// \param numShadows 0: there cannot be any. \param shadowQueue for those that go on; candidates
/// are in the one after it.
void WaveTracer::PassCandidates(std::uint32_t numShadows, std::uint32_t shadowQueue) {
    if (PassesShadowsAtOnce(_kernels->Features())) {
        return; // there are none
    }
    while (_hasCutouts && numShadows > 0) {
        const std::uint32_t numCandidates = _queues.ReadCounters()[HDS_COUNTER_SHADOW];
        if (numCandidates == 0) {
            return;
        }
        LaunchPass(_queues.Queue(shadowQueue + 1), numCandidates, shadowQueue);
        numShadows = _queues.ReadCounters()[HDS_COUNTER_SHADOW];
        _statistics->shadowRays += numShadows;
        _queues.ClearCounter(HDS_COUNTER_SHADOW);
        _launches->TraceBatch(_present, 0, shadowQueue, numShadows);
    }
}

/// Dims shadow rays by their candidates; those that go on come to queue `shadowQueue`.
void WaveTracer::LaunchPass(const Buffer& queue, std::uint32_t count, std::uint32_t shadowQueue) {
    _queues.ClearCounter(HDS_COUNTER_SHADOW);
    _launches->Launch(WaveQueues::WaitingCandidates, queue, count,
                      [&](const Buffer& items, std::uint32_t numItems, const Buffer& waiting) {
                          _kernels->shadowPass.Launch(numItems, _queues.Paths(), _queues.NumSlots(),
                                                      items, numItems, waiting,
                                                      _queues.Queue(shadowQueue),
                                                      _queues.ReadySlots(), _queues.Counters());
                      });
}

/// Processes requests and goes on with what waits for them. Appends to the paths and shadow rays
/// that go on already. \param counts as after the last launch. \return them now.
WaveTracer::Counts WaveTracer::ProcessRequestsAndResume(const Counts& counts, const Shade& shade,
                                                        const IsCancelled& isStopped) {
    std::array<std::uint32_t, WaveQueues::NumWaiting> waiting{};
    std::copy_n(counts.begin() + HDS_COUNTER_WAITING_RAYS, waiting.size(), waiting.begin());
    const std::uint32_t numRays = waiting[WaveQueues::WaitingRays];
    const std::uint32_t numShadows = waiting[WaveQueues::WaitingShadows];
    _buffers->Streaming().ProcessRequests(isStopped);
    _statistics->raysRelaunched += numRays + numShadows;
    _queues.Turn();
    const Timer timer;
    const double texelSeconds = _texels.Seconds();
    if (numRays > 0) {
        _launches->ResumeRays(_queues.HaveWaited(WaveQueues::WaitingRays), numRays);
    }
    ResumeShadows(_queues.HaveWaited(WaveQueues::WaitingShadows), numShadows);
    ResumeCandidates(_queues.HaveWaited(WaveQueues::WaitingCandidates),
                     waiting[WaveQueues::WaitingCandidates]);
    Counts resumed = _queues.ReadCounters();
    _statistics->traceSeconds += timer.Seconds() - (_texels.Seconds() - texelSeconds);
    for (const std::uint32_t counter : {HDS_COUNTER_ACTIVE, HDS_COUNTER_SHADOW}) {
        resumed[counter] = counts[counter];
        _queues.SetCounter(counter, counts[counter]);
    }
    return ShadeReady(resumed, &_queues.HaveWaited(WaveQueues::WaitingHits),
                      waiting[WaveQueues::WaitingHits], shade);
}

/// Shades slots that have become ready, and hits that have waited. Appends to the paths and shadow
/// rays that go on already.
WaveTracer::Counts WaveTracer::ShadeReady(const Counts& counts, const Buffer* hits,
                                          std::uint32_t numHits, const Shade& shade) {
    const Timer timer;
    const double texelSeconds = _texels.Seconds();
    const std::uint32_t numReady = counts[HDS_COUNTER_READY];
    const Buffer& next = _queues.Queue(_present);
    if (numHits > 0) {
        ShadeItems(*hits, numHits, next, shade);
    }
    if (numReady > 0) {
        ShadeItems(_queues.ReadySlots(), numReady, next, shade);
        _queues.ClearCounter(HDS_COUNTER_READY);
    }
    const Counts after = _queues.ReadCounters();
    _statistics->indirectRays += after[HDS_COUNTER_ACTIVE] - counts[HDS_COUNTER_ACTIVE];
    _statistics->shadeSeconds += timer.Seconds() - (_texels.Seconds() - texelSeconds);
    return after;
}

void WaveTracer::ResumeShadows(const Buffer& queue, std::uint32_t count) {
    if (count == 0) {
        return;
    }
    _queues.ClearCounter(HDS_COUNTER_SHADOW);
    _launches->ResumeShadows(queue, count, WaveQueues::kResumedQueue);
    PassCandidates(count, WaveQueues::kResumedQueue);
}

void WaveTracer::ResumeCandidates(const Buffer& queue, std::uint32_t count) {
    if (count == 0) {
        return;
    }
    LaunchPass(queue, count, WaveQueues::kResumedQueue);
    const std::uint32_t numShadows = _queues.ReadCounters()[HDS_COUNTER_SHADOW];
    _statistics->shadowRays += numShadows;
    _queues.ClearCounter(HDS_COUNTER_SHADOW);
    _launches->TraceBatch(_present, 0, WaveQueues::kResumedQueue, numShadows);
    PassCandidates(numShadows, WaveQueues::kResumedQueue);
}

} // namespace hds
