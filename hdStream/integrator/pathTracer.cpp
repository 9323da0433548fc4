// SPDX-License-Identifier: Apache-2.0
#include "hdStream/integrator/pathTracer.h"

#include "hdStream/base/timer.h"
#include "hdStream/integrator/cameraFrame.h"
#include "hdStream/integrator/filmBuffers.h"
#include "hdStream/integrator/kernelSets.h"
#include "hdStream/integrator/pixelOrder.h"
#include "hdStream/integrator/settling.h"
#include "hdStream/integrator/waveSize.h"
#include "hdStream/integrator/waveTracer.h"
#include "hdStream/scene/motion.h"
#include "hdStream/shading/pixelFilter.h"
#include "kernels/shared/frame.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <utility>

namespace hds {

namespace {

/// Fewest samples before the error estimate of a pixel is believed.
constexpr std::uint32_t kMinAdaptiveSamples = 2 * HDS_SAMPLE_BLOCK;

bool ChooseWide(const RenderOptions& options, const DeviceProperties& properties) {
    return options.traversal == TraversalForm::Auto ? properties.isCpu
                                                    : options.traversal == TraversalForm::Wide;
}

} // namespace

struct PathTracer::Impl {
    Impl(std::shared_ptr<Device> theDevice, Store* theStore)
        : device(std::move(theDevice)), kernelSets(device, theStore), buffers(device, theStore),
          film(device), tracer(device, &buffers, &statistics) {
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

    void Begin(RenderOptions newOptions, const std::vector<FilmSums>& start) {
        options = std::move(newOptions);
        statistics = {};
        previewStride = 0;
        if (buffers.SetMipBias(static_cast<float>(options.mipBias))) {
            ++sceneNumber;
        }
        ReadyKernels();
        ReadyPathState();
        const shared::HdsFrameParams params = MakeFrameParams(
            options, scene->centre, static_cast<std::uint32_t>(scene->lights->lights.size()));
        frame.Write(&params, sizeof(params));
        filter = UploadVector(device, "pixel filter",
                              BuildPixelFilterTable(options.pixelFilter, options.pixelFilterWidth));
        tracer.ClearCounters();
        film.Reset(options.aovs, options.imageWidth, options.imageHeight);
        statistics.filmBytes = film.Bytes();
        if (pixelOrder.empty() || orderWidth != options.imageWidth ||
            orderHeight != options.imageHeight) {
            orderWidth = options.imageWidth;
            orderHeight = options.imageHeight;
            pixelOrder = MakePixelOrder(orderWidth, orderHeight);
            previewOrder = MakePreviewOrder(pixelOrder, orderWidth);
        }
        LoadFilm(start);
    }

    /// The film begins with sums; \post the members `filmBegin`, `firstMissing`, `latePixels` and
    /// `lateEnd`.
    void LoadFilm(const std::vector<FilmSums>& start) {
        film.Load(kernels, start);
        filmBegin = start.empty() ? 0 : start.front().firstSample;
        firstMissing = start.empty() ? 0 : start.back().endSample;
        lateEnd = start.empty() ? 0 : start.back().MostSamples();
        latePixels.clear();
        if (lateEnd > firstMissing) {
            const std::vector<shared::HdsFilmPixel>& sums = start.back().pixels;
            std::copy_if(pixelOrder.begin(), pixelOrder.end(), std::back_inserter(latePixels),
                         [&](std::uint32_t i) { return sums[i].numSamples == firstMissing; });
        }
    }

    /// What kernels for the present scene and options have to be able to.
    KernelFeatures MakeFeatures(bool isStreaming) const {
        KernelFeatures features;
        features.cutouts = scene->hasCutouts;
        features.programs = buffers.HasPrograms();
        features.patterns = scene->hasPatterns;
        features.lobes = scene->lobes;
        features.textures = buffers.HasTextures();
        features.lightShaping = scene->lights->hasShaping;
        features.lightControls = scene->lights->hasControls;
        features.lightPortals = scene->lights->hasPortals;
        features.meshLights = scene->lights->hasMeshes;
        features.lightGlow = scene->lights->hasGlow;
        features.lightTree = scene->lights->lights.size() > HDS_LIGHT_LOOP_MAX;
        features.numTexturePools = buffers.Textures().NumBuffers() > 1 ? kMaxPoolBuffers : 1;
        features.textureStreaming = buffers.Textures().Pool() != nullptr;
        features.plainTextures = buffers.Textures().IsPlain();
        features.groups = scene->hasGroups;
        features.curves = scene->hasCurves;
        features.motion = scene->hasMotion || MovesOver(options.camera, options.shutter);
        features.wide = ChooseWide(options, device->Properties());
        features.firstHits = NeedsFirstHits(options.aovs);
        features.numPools = buffers.NumPoolBuffers() > 1 ? kMaxPoolBuffers : 1;
        features.streaming = isStreaming;
        features.requestsFirst = features.streaming && requestsFirst;
        return features;
    }

    void ReadyKernels() {
        const KernelFeatures features = MakeFeatures(buffers.IsStreaming());
        kernels = &kernelSets.Get(features, buffers, sceneNumber, &statistics.compileSeconds);
        statistics.isWideTraversal = features.wide;
    }

    void ReadyPathState() {
        const auto bytesPerSlot = [](const KernelFeatures& features) {
            return StageKernels::PathStateBytes(features) + WaveTracer::QueueBytes(features);
        };
        // Streamed, all together takes no more than resident geometry with its wave would.
        const std::uint64_t totalBytes = scene->pages->TotalBytes();
        const std::uint64_t savedBytes = totalBytes - std::min(totalBytes, buffers.PoolBytes());
        const std::uint64_t residentBytes =
            ResidentWaveSize(device->Properties()) * bytesPerSlot(MakeFeatures(false));
        const std::uint64_t affordable =
            (savedBytes + residentBytes) / bytesPerSlot(kernels->Features());
        const std::uint32_t waveSize =
            ChooseWaveSize(options, device->Properties(), buffers.IsStreaming() ? affordable : 0);
        tracer.Ready(kernels, scene->hasCutouts, waveSize, TileSize(device->Properties()),
                     options.shadeIterations);
        statistics.waveSize = waveSize;
    }

    void SetActivePixels(const std::vector<std::uint32_t>& list) {
        pixels = UploadVector(device, "active pixels", list);
        activePixels = list;
    }

    void RenderWave(const shared::HdsWave& wave) {
        const std::uint32_t numSlots = wave.numPixels * wave.numSamples;
        const Buffer& paths = tracer.Paths();
        const std::uint32_t waveSize = tracer.WaveSize();
        statistics.cameraRays += numSlots;
        tracer.Trace(
            numSlots,
            [&](std::uint32_t first, std::uint32_t count, const Buffer& queue,
                std::uint32_t queueFirst) {
                kernels->generateSample.Launch(count, frame, wave, first, count, paths, waveSize,
                                               pixels, filter, queue, queueFirst);
            },
            [&](const Buffer& queue, std::uint32_t count, const Buffer& waiting,
                const Buffer& next) {
                kernels->shade.Launch(count, frame, paths, waveSize, queue, count, waiting, next,
                                      tracer.ShadowQueue(), tracer.Counters());
            });
        kernels->resolve.Launch(wave.numPixels, wave, paths, waveSize, pixels, film.Film(),
                                tracer.Counters());
        device->Finish();
        CollectTexelCounts();
    }

    /// Before they overflow.
    void CollectTexelCounts() {
        if (TexturePool* pool = buffers.Textures().Pool()) {
            pool->CollectCounts();
        }
    }

    /// Samples [firstSample, firstSample + numSamples) of the active pixels [begin, end); true when
    /// all are done. \param[out] isStopped the render is to end.
    bool RenderPixels(std::uint32_t begin, std::uint32_t end, std::uint32_t firstSample,
                      std::uint32_t numSamples, const Timer& timer,
                      const ProgressCallback& onProgress, bool* isStopped) {
        const std::uint32_t pixelsPerWave = std::max(1U, tracer.WaveSize() / numSamples);
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

    /// A film that was loaded is a picture; the pass that was stopped in it, if any, is ended.
    bool GoOn(const Timer& timer, const ProgressCallback& onProgress, bool* isStopped) {
        previewStride = 1;
        statistics.firstImageSeconds = timer.Seconds();
        if (!latePixels.empty()) {
            SetActivePixels(latePixels);
            if (!RenderPixels(0, static_cast<std::uint32_t>(latePixels.size()), firstMissing,
                              lateEnd - firstMissing, timer, onProgress, isStopped)) {
                return false;
            }
        }
        SetActivePixels(pixelOrder);
        return true;
    }

    /// Where the pass after `done` samples ends: block by block; for those who look at pictures
    /// doubling inside the first block, so that pictures follow each other soon.
    std::uint32_t PassEnd(std::uint32_t done) const {
        const bool isDoubling = options.showsPreviews && done < HDS_SAMPLE_BLOCK;
        const std::uint32_t border =
            isDoubling ? 2 * done : (done / HDS_SAMPLE_BLOCK + 1) * HDS_SAMPLE_BLOCK;
        return std::min({options.samples, border, done + tracer.WaveSize()});
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
        progress.fraction =
            std::min(1.0, (samplesEquivalent - firstMissing) / (options.samples - firstMissing));
        progress.secondsElapsed = seconds;
        progress.previewStride = previewStride;
        progress.secondsLeft =
            progress.fraction > 0.0 ? seconds * (1.0 - progress.fraction) / progress.fraction : 0.0;
        if (options.timeLimit > 0.0) {
            progress.secondsLeft = std::min(progress.secondsLeft, options.timeLimit - seconds);
        }
        return onProgress(progress);
    }

    double TracingSeconds() const { return statistics.traceSeconds + statistics.shadeSeconds; }

    /// Between passes, after `done` samples: makes geometry that streams resident when that is
    /// worth it (settling.h). \param secondsPerSample of the last pass. \return false when the
    /// render is to end.
    bool SettleIfWorth(std::uint32_t done, double secondsPerSample, const Timer& timer,
                       const ProgressCallback& onProgress) {
        if (done == options.samples || !buffers.MaySettle()) {
            return true;
        }
        const StreamingStatistics pool = buffers.PoolStatistics();
        SettlingCosts costs;
        costs.secondsLeft = secondsPerSample * (options.samples - done);
        if (options.timeLimit > 0.0) {
            costs.secondsLeft = std::min(costs.secondsLeft, options.timeLimit - timer.Seconds());
        }
        costs.kernelSeconds = SecondsToGet(MakeFeatures(false));
        costs.missingBytes = buffers.Streaming().MissingBytes();
        costs.prepareSeconds = pool.prepareSeconds;
        costs.preparedBytes = pool.uploadedBytes;
        if (!IsWorthSettling(costs)) {
            return true;
        }
        while (buffers.MaySettle()) {
            buffers.LoadMissing();
            if (buffers.IsStreaming() && !Report(done, done, timer, onProgress)) {
                return false;
            }
        }
        if (!buffers.IsStreaming()) {
            ReadyKernels();
            ReadyPathState();
        }
        return true;
    }

    /// An estimate; 0: such kernels are there.
    double SecondsToGet(const KernelFeatures& features) const {
        if (kernelSets.Has(features)) {
            return 0.0;
        }
        return kernelSets.AreInStore(features) ? kSecondsOfCachedKernels : kSecondsOfBuiltKernels;
    }

    std::vector<float> RelativeErrors() {
        const auto count = static_cast<std::uint32_t>(activePixels.size());
        Buffer errors(device, "pixel errors", std::uint64_t{count} * sizeof(float));
        kernels->relativeError.Launch(
            count, film.Film(), static_cast<std::int32_t>(options.imageWidth),
            static_cast<std::int32_t>(options.imageHeight), pixels, count, errors);
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

    void CountAccuracy() {
        const auto values = tracer.ReadCounters();
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
    }

    RenderResult Render(const ProgressCallback& onProgress) {
        const Timer timer;
        bool isStopped = false;
        const bool isNew = firstMissing == 0 && latePixels.empty();
        const bool hasFirst = !isNew ? GoOn(timer, onProgress, &isStopped)
                              : options.showsPreviews
                                  ? RenderPreview(timer, onProgress, &isStopped)
                                  : RenderFirstSample(timer, onProgress, &isStopped);
        std::uint32_t done = firstMissing;
        double tracingSeconds = 0.0;
        const auto endPass = [&](std::uint32_t passEnd) {
            const double passSeconds = TracingSeconds() - tracingSeconds;
            const double secondsPerSample = passSeconds / (passEnd - done);
            tracingSeconds += passSeconds;
            done = passEnd;
            statistics.streamedSamples = buffers.IsStreaming() ? done : statistics.streamedSamples;
            isStopped = isStopped || !SettleIfWorth(done, secondsPerSample, timer, onProgress);
        };
        if (hasFirst && isNew) {
            endPass(1);
        } else if (hasFirst && !latePixels.empty()) {
            endPass(lateEnd);
        }
        while (done < options.samples && !activePixels.empty() && !isStopped) {
            const std::uint32_t passEnd = PassEnd(done);
            if (RenderPixels(0, static_cast<std::uint32_t>(activePixels.size()), done,
                             passEnd - done, timer, onProgress, &isStopped)) {
                endPass(passEnd);
            }
            if (options.noise > 0.0 && done >= kMinAdaptiveSamples &&
                done % HDS_SAMPLE_BLOCK == 0 && !isStopped) {
                DropConvergedPixels();
            }
        }
        statistics.renderSeconds = timer.Seconds();
        statistics.samples = done;
        CountAccuracy();
        buffers.CountUsed();
        const bool timeIsUp = options.timeLimit > 0.0 && timer.Seconds() >= options.timeLimit;
        if (isStopped && !timeIsUp) {
            return RenderResult::Stopped;
        }
        kernelSets.SaveBinaries();
        return RenderResult::Complete;
    }

    /// First-hit AOVs through pixel centres, wave by wave.
    void RenderFirstHits() {
        const shared::HdsAovOffsets offsets = film.FirstHitOffsets(scene->centre);
        const Buffer primvarSlots =
            UploadVector(device, "primvar slots", PrimvarSlots(options.aovs.primvars));
        const Buffer order = UploadVector(device, "all pixels", pixelOrder);
        const auto pixelCount = static_cast<std::uint32_t>(pixelOrder.size());
        const std::uint64_t indirectRays = statistics.indirectRays; // counts those of pictures
        const Buffer& paths = tracer.Paths();
        const std::uint32_t waveSize = tracer.WaveSize();
        for (std::uint32_t firstPixel = 0; firstPixel < pixelCount; firstPixel += waveSize) {
            const std::uint32_t numPixels = std::min(waveSize, pixelCount - firstPixel);
            const shared::HdsWave wave{firstPixel, numPixels, 0, 1};
            tracer.Trace(
                numPixels,
                [&](std::uint32_t first, std::uint32_t count, const Buffer& queue,
                    std::uint32_t queueFirst) {
                    kernels->generateCentre.Launch(count, frame, wave, first, count, paths,
                                                   waveSize, order, queue, queueFirst);
                },
                [&](const Buffer& queue, std::uint32_t count, const Buffer& waiting,
                    const Buffer& next) {
                    kernels->aov.Launch(count, frame, paths, waveSize, queue, count, waiting, next,
                                        tracer.Counters(), film.Floats(), film.Ints(), offsets,
                                        primvarSlots);
                });
        }
        statistics.indirectRays = indirectRays;
        CollectTexelCounts();
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

    std::shared_ptr<Device> device;
    KernelSets kernelSets;
    const CommittedScene* scene = nullptr;
    RenderOptions options;
    SceneBuffers buffers;
    bool requestsFirst = false;
    FilmBuffers film;
    std::uint64_t sceneNumber = 0;   ///< counts what kernels are bound to
    StageKernels* kernels = nullptr; ///< those of the present render
    std::vector<std::uint32_t> pixelOrder;
    PreviewOrder previewOrder;
    std::uint32_t orderWidth = 0;
    std::uint32_t orderHeight = 0;
    std::uint32_t previewStride = 0; ///< as Progress::previewStride
    std::uint32_t filmBegin = 0;     ///< first sample of the film
    std::uint32_t firstMissing = 0;  ///< first sample that some pixel of the loaded film lacks
    std::uint32_t lateEnd = 0;       ///< samples of the other pixels
    std::vector<std::uint32_t> latePixels; ///< that a stopped pass of the loaded film left out
    std::vector<std::uint32_t> activePixels;
    Buffer frame;
    Buffer filter;
    Buffer pixels;
    RenderStatistics statistics;
    WaveTracer tracer;
};

PathTracer::PathTracer(std::shared_ptr<Device> device, Store* store)
    : _impl(std::make_unique<Impl>(std::move(device), store)) {}

PathTracer::~PathTracer() = default;

bool PathTracer::NeedsAllPages(const CommittedScene& scene,
                               const ResidencyOptions& residency) const {
    if (residency.mode == ResidencyMode::Mapped) {
        return false; // it prepares what is in no file
    }
    return residency.budgetShare > 0.0 ||
           !_impl->buffers.WillStream(residency, scene.pages->TotalBytes());
}

bool PathTracer::SetScene(const CommittedScene& scene, const ResidencyOptions& residency) {
    return _impl->SetScene(scene, residency);
}

void PathTracer::Begin(RenderOptions options, const std::vector<FilmSums>& start) {
    _impl->Begin(std::move(options), start);
}

RenderResult PathTracer::Render(const ProgressCallback& onProgress) {
    return _impl->Render(onProgress);
}

std::vector<ImageLayer> PathTracer::Layers(bool withFirstHits) {
    return _impl->Layers(withFirstHits);
}

FilmSums PathTracer::Film() const {
    return _impl->film.Read(_impl->filmBegin, _impl->statistics.samples);
}

const RenderStatistics& PathTracer::Statistics() const {
    return _impl->statistics;
}

void PathTracer::BeginStatistics() {
    _impl->buffers.BeginStatistics();
}

const SceneBuffers& PathTracer::Buffers() const {
    return _impl->buffers;
}

} // namespace hds
