// SPDX-License-Identifier: Apache-2.0
#include "hdStream/integrator/pathTracer.h"

#include "hdStream/integrator/cameraFrame.h"
#include "hdStream/integrator/filmBuffers.h"
#include "hdStream/integrator/pixelOrder.h"
#include "hdStream/integrator/stageKernels.h"
#include "hdStream/integrator/waveSize.h"
#include "hdStream/shading/pixelFilter.h"
#include "kernels/shared/frame.h"

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <iterator>
#include <utility>

namespace hds {

namespace {

/// Fewest samples before the error estimate of a pixel is believed.
constexpr std::uint32_t kMinAdaptiveSamples = 2 * HDS_SAMPLE_BLOCK;

class Timer {
public:
    double Seconds() const {
        return std::chrono::duration<double>(std::chrono::steady_clock::now() - _start).count();
    }

private:
    std::chrono::steady_clock::time_point _start = std::chrono::steady_clock::now();
};

bool ChooseWide(const RenderOptions& options, const DeviceProperties& properties) {
    return options.traversal == TraversalForm::Auto ? properties.isCpu
                                                    : options.traversal == TraversalForm::Wide;
}

} // namespace

struct PathTracer::Impl {
    Impl(std::shared_ptr<Device> theDevice, Store* theStore)
        : device(std::move(theDevice)), store(theStore), buffers(device), film(device) {
        counters = Buffer(device, "counters", HDS_NUM_COUNTERS * sizeof(std::uint32_t));
        frame = Buffer(device, "frame constants", sizeof(shared::HdsFrameParams),
                       BufferAccess::ReadOnly);
    }

    bool SetScene(const CommittedScene& newScene, const ResidencyOptions& newResidency) {
        scene = nullptr;
        if (!buffers.Update(newScene, newResidency)) {
            return false;
        }
        requestsFirst = newResidency.requestsFirst;
        scene = &newScene;
        ++sceneNumber;
        return true;
    }

    void Begin(RenderOptions newOptions) {
        options = std::move(newOptions);
        statistics = {};
        previewStride = 0;
        ReadyKernels();
        ReadyPathState();
        const shared::HdsFrameParams params = MakeFrameParams(
            options, scene->centre, static_cast<std::uint32_t>(scene->lights->lights.size()));
        frame.Write(&params, sizeof(params));
        filter = UploadVector(device, "pixel filter",
                              BuildPixelFilterTable(options.pixelFilter, options.pixelFilterWidth));
        counters.Fill(0, HDS_NUM_COUNTERS * sizeof(std::uint32_t));
        film.Reset(options.aovs, options.imageWidth, options.imageHeight);
        statistics.filmBytes = film.Bytes();
        if (pixelOrder.empty() || orderWidth != options.imageWidth ||
            orderHeight != options.imageHeight) {
            orderWidth = options.imageWidth;
            orderHeight = options.imageHeight;
            pixelOrder = MakePixelOrder(orderWidth, orderHeight);
            previewOrder = MakePreviewOrder(pixelOrder, orderWidth);
        }
    }

    void ReadyKernels() {
        KernelFeatures features;
        features.cutouts = scene->hasCutouts;
        features.groups = scene->hasGroups;
        features.wide = ChooseWide(options, device->Properties());
        features.firstHits = NeedsFirstHits(options.aovs);
        features.manyPools = buffers.NumPoolBuffers() > 1;
        features.streaming = buffers.IsStreaming();
        features.requestsFirst = features.streaming && requestsFirst;
        auto built = std::find_if(builtKernels.begin(), builtKernels.end(), [&](const auto& entry) {
            return entry.first->Features() == features;
        });
        if (built == builtKernels.end()) {
            builtKernels.emplace_back(std::make_unique<StageKernels>(device, store, features), 0);
            built = std::prev(builtKernels.end());
            statistics.compileSeconds = built->first->BuildSeconds();
        }
        kernels = built->first.get();
        if (built->second != sceneNumber) {
            kernels->Bind(buffers);
            built->second = sceneNumber;
        }
        statistics.isWideTraversal = features.wide;
    }

    void ReadyPathState() {
        // Path state, queues of rays and of those that wait.
        const std::uint64_t bytesPerSlot =
            kernels->PathStateBytes() + sizeof(std::uint32_t) * (queues.size() + waitQueues.size());
        const std::uint64_t totalBytes = scene->pages->TotalBytes();
        const std::uint64_t savedBytes = totalBytes - std::min(totalBytes, buffers.PoolBytes());
        waveSize = ChooseWaveSize(options, device->Properties(),
                                  buffers.IsStreaming() ? 1 + savedBytes / bytesPerSlot : 0);
        const std::uint64_t bytes = std::uint64_t{waveSize} * kernels->PathStateBytes();
        if (!paths.IsValid() || paths.Bytes() != bytes) {
            paths = Buffer(); // frees first
            paths = Buffer(device, "path state", bytes);
            for (Buffer& queue : queues) {
                queue =
                    Buffer(device, "ray queue", std::uint64_t{waveSize} * sizeof(std::uint32_t));
            }
        }
        const std::uint64_t waitBytes =
            buffers.IsStreaming() ? std::uint64_t{waveSize} * sizeof(std::uint32_t) : 0;
        for (Buffer& queue : waitQueues) {
            if (!queue.IsValid() || queue.Bytes() < waitBytes) {
                queue = Buffer(); // frees first
                queue = Buffer(device, "queue of waiting rays", waitBytes);
            }
        }
        statistics.waveSize = waveSize;
        statistics.pathStateBytes = paths.Bytes();
        for (const Buffer& queue : queues) {
            statistics.pathStateBytes += queue.Bytes();
        }
        for (const Buffer& queue : waitQueues) {
            statistics.pathStateBytes += queue.Bytes();
        }
    }

    void SetActivePixels(const std::vector<std::uint32_t>& list) {
        pixels = UploadVector(device, "active pixels", list);
        activePixels = list;
    }

    /// Launches a kernel that needs all pages of the chunks that were hit, over the items of
    /// `queue` until none waits for pages: launch(queue, count, waitQueue).
    template <typename Launch>
    void RunWithPages(const Buffer& queue, std::uint32_t count, Launch launch) {
        if (!buffers.IsStreaming()) {
            launch(queue, count, waitQueues[0]);
            return;
        }
        StreamingPool& pool = buffers.Streaming();
        const Buffer* items = &queue;
        for (std::uint32_t iteration = 0; count > 0; ++iteration) {
            const Buffer& waiting = waitQueues[iteration % 2];
            ClearCounter(HDS_COUNTER_WAITING);
            launch(*items, count, waiting);
            count = ReadCounters()[HDS_COUNTER_WAITING];
            items = &waiting;
            if (count > 0) {
                const std::uint64_t before = pool.Statistics().uploads;
                pool.ServiceGroups();
                statistics.shadingRefetches += pool.Statistics().uploads - before;
            }
        }
    }

    /// Rays of one kind in a cast, with the queues of those that wait for a chunk.
    struct CastRays {
        const Buffer* queue = nullptr;
        std::uint32_t count = 0;
        std::array<const Buffer*, 2> waiting{};
    };

    /// Launches what is left of `rays`; afterwards that is the rays that wait for a chunk.
    /// launch(queue, count, isResumed, waitQueue).
    template <typename Launch>
    void IterateCast(std::uint32_t iteration, CastRays* rays, Launch launch) {
        if (rays->count == 0) {
            return;
        }
        const Buffer& waiting = *rays->waiting[iteration % 2];
        if (!buffers.IsStreaming()) {
            launch(*rays->queue, rays->count, 0U, waiting);
            rays->count = 0;
            return;
        }
        ClearCounter(HDS_COUNTER_WAITING);
        launch(*rays->queue, rays->count, iteration > 0 ? 1U : 0U, waiting);
        rays->queue = &waiting;
        rays->count = ReadCounters()[HDS_COUNTER_WAITING];
        statistics.raysRelaunched += rays->count;
    }

    /// One cast: path rays to their closest hits and shadow rays to whatever is in their way, until
    /// none waits for a chunk. Both kinds share what is loaded.
    void Cast(const Buffer& pathQueue, std::uint32_t numPaths, const Buffer& shadowQueue,
              std::uint32_t numShadows, const Buffer& candidateQueue) {
        const Timer timer;
        const double serviceSeconds = ServiceSeconds();
        CastRays pathRays{&pathQueue, numPaths, {&waitQueues[0], &waitQueues[1]}};
        CastRays shadowRays{&shadowQueue, numShadows, {&waitQueues[2], &waitQueues[3]}};
        statistics.shadowRays += numShadows;
        ++statistics.casts;
        if (buffers.IsStreaming()) {
            buffers.Streaming().BeginCast();
        }
        ClearCounter(HDS_COUNTER_SHADOW); // counts candidates from here on
        std::uint32_t iterations = 0;
        while (pathRays.count + shadowRays.count > 0) {
            if (iterations > 0) {
                buffers.Streaming().ServiceCast();
            }
            IterateCast(iterations, &shadowRays,
                        [&](const Buffer& queue, std::uint32_t count, std::uint32_t isResumed,
                            const Buffer& waiting) {
                            kernels->shadowCast.Launch(count, paths, waveSize, queue, count,
                                                       isResumed, waiting, candidateQueue,
                                                       counters);
                        });
            IterateCast(iterations, &pathRays,
                        [&](const Buffer& queue, std::uint32_t count, std::uint32_t isResumed,
                            const Buffer& waiting) {
                            kernels->intersect.Launch(count, paths, waveSize, queue, count,
                                                      isResumed, waiting, counters);
                        });
            ++iterations;
        }
        device->Finish();
        statistics.iterations += iterations;
        statistics.maxIterationsPerCast = std::max(statistics.maxIterationsPerCast, iterations);
        statistics.traceSeconds += timer.Seconds() - (ServiceSeconds() - serviceSeconds);
    }

    /// Seconds that services have taken so far: part of the time of whatever waits for them.
    double ServiceSeconds() const {
        if (!buffers.IsStreaming()) {
            return 0.0;
        }
        const StreamingStatistics& pool = buffers.Streaming().Statistics();
        return pool.serviceSeconds + pool.prepareSeconds + pool.transferSeconds;
    }

    std::array<std::uint32_t, HDS_NUM_COUNTERS> ReadCounters() const {
        std::array<std::uint32_t, HDS_NUM_COUNTERS> values{};
        counters.Read(values.data(), sizeof(values));
        return values;
    }

    void ClearCounter(std::uint32_t counter) {
        counters.Fill(0, sizeof(std::uint32_t), counter * sizeof(std::uint32_t));
    }

    /// Casts the rays of queue `next` and the shadow rays that shading has made. Shadow rays that
    /// meet cut-out surfaces go on in casts of their own until each is decided.
    void CastNext(std::uint32_t next, std::uint32_t numPaths, std::uint32_t numShadows) {
        std::uint32_t present = kShadowQueue;
        std::uint32_t other = kShadowQueue + 1;
        Cast(queues[next], numPaths, queues[present], numShadows, queues[other]);
        while (scene->hasCutouts && numShadows > 0) {
            const std::uint32_t candidates = ReadCounters()[HDS_COUNTER_SHADOW];
            if (candidates == 0) {
                break;
            }
            const Timer timer;
            const double serviceSeconds = ServiceSeconds();
            ClearCounter(HDS_COUNTER_SHADOW);
            RunWithPages(queues[other], candidates,
                         [&](const Buffer& items, std::uint32_t count, const Buffer& waiting) {
                             kernels->shadowPass.Launch(count, paths, waveSize, items, count,
                                                        waiting, queues[present], counters);
                         });
            numShadows = ReadCounters()[HDS_COUNTER_SHADOW];
            statistics.traceSeconds += timer.Seconds() - (ServiceSeconds() - serviceSeconds);
            if (numShadows > 0) {
                Cast(queues[next], 0, queues[present], numShadows, queues[other]);
            }
        }
    }

    void RenderWave(const shared::HdsWave& wave) {
        std::uint32_t present = 0;
        std::uint32_t active = wave.numPixels * wave.numSamples;
        std::uint32_t numShadows = 0;
        kernels->generateSample.Launch(active, frame, wave, paths, waveSize, pixels, filter,
                                       queues[present]);
        statistics.cameraRays += active;
        while (active + numShadows > 0) {
            CastNext(present, active, numShadows);
            const Timer timer;
            const double serviceSeconds = ServiceSeconds();
            ClearCounter(HDS_COUNTER_ACTIVE);
            ClearCounter(HDS_COUNTER_SHADOW);
            RunWithPages(queues[present], active,
                         [&](const Buffer& items, std::uint32_t count, const Buffer& waiting) {
                             kernels->shade.Launch(count, frame, paths, waveSize, items, count,
                                                   waiting, queues[1 - present],
                                                   queues[kShadowQueue], counters);
                         });
            const auto counts = ReadCounters();
            statistics.shadeSeconds += timer.Seconds() - (ServiceSeconds() - serviceSeconds);
            active = counts[HDS_COUNTER_ACTIVE];
            numShadows = counts[HDS_COUNTER_SHADOW];
            statistics.indirectRays += active;
            present = 1 - present;
        }
        kernels->resolve.Launch(wave.numPixels, wave, paths, waveSize, pixels, film.Film(),
                                counters);
        device->Finish();
    }

    /// Samples [firstSample, firstSample + numSamples) of the active pixels [begin, end); true when
    /// all are done. \param[out] isStopped the render is to end.
    bool RenderPixels(std::uint32_t begin, std::uint32_t end, std::uint32_t firstSample,
                      std::uint32_t numSamples, const Timer& timer,
                      const ProgressCallback& onProgress, bool* isStopped) {
        const std::uint32_t pixelsPerWave = std::max(1U, waveSize / numSamples);
        for (std::uint32_t first = begin; first < end; first += pixelsPerWave) {
            const std::uint32_t count = std::min(pixelsPerWave, end - first);
            RenderWave({first, count, firstSample, numSamples});
            const double passFraction =
                static_cast<double>(first + count) / static_cast<double>(activePixels.size());
            *isStopped =
                !Report(firstSample, firstSample + passFraction * numSamples, timer, onProgress);
            if (*isStopped && first + count < end) {
                return false;
            }
        }
        return true;
    }

    /// The first sample of all pixels, from coarse to fine, so that there is a picture at once.
    bool RenderPreview(const Timer& timer, const ProgressCallback& onProgress, bool* isStopped) {
        SetActivePixels(previewOrder.pixels);
        std::uint32_t begin = 0;
        for (std::size_t i = 0; i < previewOrder.ends.size(); ++i) {
            const std::uint32_t end = previewOrder.ends[i];
            if (!RenderPixels(begin, end, 0, 1, timer, onProgress, isStopped)) {
                return false;
            }
            previewStride = kPreviewStrides[i];
            begin = end;
            const bool isWhole = end == activePixels.size();
            if (isWhole) {
                SetActivePixels(pixelOrder);
                statistics.firstImageSeconds = timer.Seconds();
            }
            if (!*isStopped) {
                const double fraction =
                    static_cast<double>(end) / static_cast<double>(previewOrder.pixels.size());
                *isStopped = !Report(isWhole ? 1 : 0, fraction, timer, onProgress);
            }
            if (*isStopped) {
                return isWhole;
            }
        }
        return true;
    }

    /// The first sample of all pixels at once, for those who look at no picture before the last.
    bool RenderFirstSample(const Timer& timer, const ProgressCallback& onProgress,
                           bool* isStopped) {
        SetActivePixels(pixelOrder);
        if (!RenderPixels(0, static_cast<std::uint32_t>(activePixels.size()), 0, 1, timer,
                          onProgress, isStopped)) {
            return false;
        }
        previewStride = 1;
        statistics.firstImageSeconds = timer.Seconds();
        *isStopped = *isStopped || !Report(1, 1.0, timer, onProgress);
        return true;
    }

    /// Where the pass after `done` samples ends: block by block; for those who look at pictures
    /// doubling inside the first block, so that pictures follow each other soon.
    std::uint32_t PassEnd(std::uint32_t done) const {
        const bool isDoubling = options.showsPreviews && done < HDS_SAMPLE_BLOCK;
        const std::uint32_t border =
            isDoubling ? 2 * done : (done / HDS_SAMPLE_BLOCK + 1) * HDS_SAMPLE_BLOCK;
        return std::min({options.samples, border, done + waveSize});
    }

    bool Report(std::uint32_t samplesDone, double samplesEquivalent, const Timer& timer,
                const ProgressCallback& onProgress) {
        const double seconds = timer.Seconds();
        statistics.renderSeconds = seconds;
        statistics.samples = samplesDone;
        if (options.timeLimit > 0.0 && seconds >= options.timeLimit && samplesDone > 0) {
            return false;
        }
        if (!onProgress) {
            return true;
        }
        Progress progress;
        progress.samplesDone = samplesDone;
        progress.samplesTotal = options.samples;
        progress.fraction = std::min(1.0, samplesEquivalent / options.samples);
        progress.secondsElapsed = seconds;
        progress.previewStride = previewStride;
        progress.secondsLeft =
            progress.fraction > 0.0 ? seconds * (1.0 - progress.fraction) / progress.fraction : 0.0;
        if (options.timeLimit > 0.0) {
            progress.secondsLeft = std::min(progress.secondsLeft, options.timeLimit - seconds);
        }
        return onProgress(progress);
    }

    std::vector<float> RelativeErrors() {
        const auto count = static_cast<std::uint32_t>(activePixels.size());
        Buffer errors(device, "pixel errors", std::uint64_t{count} * sizeof(float));
        kernels->relativeError.Launch(count, film.Film(), pixels, count, errors);
        std::vector<float> values(count);
        errors.Read(values.data(), values.size() * sizeof(float));
        return values;
    }

    /// Drops the pixels that have met the error; their samples stop at this block border.
    void DropConvergedPixels() {
        const std::vector<float> errors = RelativeErrors();
        std::vector<std::uint32_t> rest;
        for (std::size_t i = 0; i < errors.size(); ++i) {
            if (!(errors[i] <= static_cast<float>(options.noise))) {
                rest.push_back(activePixels[i]);
            }
        }
        if (rest.size() < activePixels.size()) {
            SetActivePixels(rest);
        }
    }

    RenderResult Render(const ProgressCallback& onProgress) {
        const Timer timer;
        bool isStopped = false;
        const bool hasFirst = options.showsPreviews
                                  ? RenderPreview(timer, onProgress, &isStopped)
                                  : RenderFirstSample(timer, onProgress, &isStopped);
        std::uint32_t done = hasFirst ? 1 : 0;
        while (done < options.samples && !activePixels.empty() && !isStopped) {
            const std::uint32_t passEnd = PassEnd(done);
            if (RenderPixels(0, static_cast<std::uint32_t>(activePixels.size()), done,
                             passEnd - done, timer, onProgress, &isStopped)) {
                done = passEnd;
            }
            if (options.noise > 0.0 && done >= kMinAdaptiveSamples &&
                done % HDS_SAMPLE_BLOCK == 0 && !isStopped) {
                DropConvergedPixels();
            }
        }
        statistics.renderSeconds = timer.Seconds();
        statistics.samples = done;
        const auto values = ReadCounters();
        statistics.nanSamples = values[HDS_COUNTER_NAN];
        statistics.endedPasses = values[HDS_COUNTER_PASSES];
        SetActivePixels(pixelOrder);
        const std::vector<float> errors = RelativeErrors();
        double sum = 0.0;
        for (const float error : errors) {
            sum += std::isfinite(error) ? error : 0.0;
        }
        statistics.meanRelativeError =
            errors.empty() ? 0.0 : sum / static_cast<double>(errors.size());
        const bool timeIsUp = options.timeLimit > 0.0 && timer.Seconds() >= options.timeLimit;
        return isStopped && !timeIsUp ? RenderResult::Stopped : RenderResult::Complete;
    }

    /// First-hit AOVs through pixel centres, wave by wave.
    void RenderFirstHits() {
        const shared::HdsAovOffsets offsets = film.FirstHitOffsets(scene->centre);
        const Buffer primvarSlots =
            UploadVector(device, "primvar slots", PrimvarSlots(options.aovs.primvars));
        const Buffer order = UploadVector(device, "all pixels", pixelOrder);
        const auto pixelCount = static_cast<std::uint32_t>(pixelOrder.size());
        for (std::uint32_t first = 0; first < pixelCount; first += waveSize) {
            const std::uint32_t count = std::min(waveSize, pixelCount - first);
            const shared::HdsWave wave{first, count, 0, 1};
            kernels->generateCentre.Launch(count, frame, wave, paths, waveSize, order, queues[0]);
            std::uint32_t present = 0;
            std::uint32_t active = count;
            while (active > 0) {
                Cast(queues[present], active, queues[kShadowQueue], 0, queues[kShadowQueue + 1]);
                ClearCounter(HDS_COUNTER_ACTIVE);
                RunWithPages(
                    queues[present], active,
                    [&](const Buffer& items, std::uint32_t numItems, const Buffer& waiting) {
                        kernels->aov.Launch(numItems, frame, paths, waveSize, items, numItems,
                                            waiting, queues[1 - present], counters, film.Floats(),
                                            film.Ints(), offsets, primvarSlots);
                    });
                active = ReadCounters()[HDS_COUNTER_ACTIVE];
                present = 1 - present;
            }
        }
        film.SetHasFirstHits();
    }

    /// [numMeshes][names.size()] attribute slot of each primvar, or HDS_NONE.
    std::vector<std::uint32_t> PrimvarSlots(const std::vector<std::string>& names) const {
        std::vector<std::uint32_t> slots;
        for (const std::vector<AttributeName>* attributes : scene->meshAttributes) {
            for (const std::string& name : names) {
                const auto found = std::find_if(
                    attributes->begin(), attributes->end(),
                    [&](const AttributeName& candidate) { return candidate.name == name; });
                const auto index = static_cast<std::uint32_t>(found - attributes->begin());
                slots.push_back(found == attributes->end() ? HDS_NONE : HDS_SLOT_USER + index);
            }
        }
        return slots;
    }

    std::vector<ImageLayer> Layers(bool withFirstHits) {
        const Timer timer;
        if (withFirstHits && film.NeedsFirstHits() && !film.HasFirstHits() && previewStride > 0) {
            RenderFirstHits();
        }
        std::vector<ImageLayer> layers = film.Develop(kernels, previewStride);
        statistics.transferSeconds += timer.Seconds();
        return layers;
    }

    static constexpr std::uint32_t kShadowQueue = 2; ///< queues 0, 1: paths; 2, 3: shadow rays

    std::shared_ptr<Device> device;
    Store* store;
    const CommittedScene* scene = nullptr;
    RenderOptions options;
    std::uint32_t waveSize = 0;
    SceneBuffers buffers;
    bool requestsFirst = false;
    FilmBuffers film;
    std::uint64_t sceneNumber = 0; ///< counts scenes
    /// Kernels of all features met so far, with the number of the scene they are bound to.
    std::vector<std::pair<std::unique_ptr<StageKernels>, std::uint64_t>> builtKernels;
    StageKernels* kernels = nullptr; ///< those of the present render
    std::vector<std::uint32_t> pixelOrder;
    PreviewOrder previewOrder;
    std::uint32_t orderWidth = 0;
    std::uint32_t orderHeight = 0;
    std::uint32_t previewStride = 0; ///< as Progress::previewStride
    std::vector<std::uint32_t> activePixels;
    Buffer frame;
    Buffer filter;
    Buffer paths;
    std::array<Buffer, 4> queues;
    std::array<Buffer, 4> waitQueues; ///< of rays that wait for chunks: path rays', shadow rays'
    Buffer counters;
    Buffer pixels;
    RenderStatistics statistics;
};

PathTracer::PathTracer(std::shared_ptr<Device> device, Store* store)
    : _impl(std::make_unique<Impl>(std::move(device), store)) {}

PathTracer::~PathTracer() = default;

bool PathTracer::NeedsAllPages(const CommittedScene& scene,
                               const ResidencyOptions& residency) const {
    return residency.budgetShare > 0.0 ||
           !_impl->buffers.WillStream(residency, scene.pages->TotalBytes());
}

bool PathTracer::SetScene(const CommittedScene& scene, const ResidencyOptions& residency) {
    return _impl->SetScene(scene, residency);
}

void PathTracer::Begin(RenderOptions options) {
    _impl->Begin(std::move(options));
}

RenderResult PathTracer::Render(const ProgressCallback& onProgress) {
    return _impl->Render(onProgress);
}

std::vector<ImageLayer> PathTracer::Layers(bool withFirstHits) {
    return _impl->Layers(withFirstHits);
}

const RenderStatistics& PathTracer::Statistics() const {
    return _impl->statistics;
}

std::uint64_t PathTracer::PoolBytes() const {
    return _impl->buffers.PoolBytes();
}

std::uint64_t PathTracer::UploadedBytes() const {
    return _impl->buffers.UploadedBytes();
}

const StreamingStatistics* PathTracer::Streaming() const {
    return _impl->buffers.IsStreaming() ? &_impl->buffers.Streaming().Statistics() : nullptr;
}

std::uint64_t PathTracer::TableBytes() const {
    return _impl->buffers.TableBytes();
}

} // namespace hds
