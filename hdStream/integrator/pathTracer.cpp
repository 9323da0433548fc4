// SPDX-License-Identifier: Apache-2.0
#include "hdStream/integrator/pathTracer.h"

#include "hdStream/integrator/cameraFrame.h"
#include "hdStream/integrator/pixelOrder.h"
#include "hdStream/integrator/stageKernels.h"
#include "hdStream/shading/pixelFilter.h"
#include "kernels/shared/frame.h"

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <utility>

namespace hds {

namespace {

/// Paths in flight when the user does not say. Measured: docs/performance.md, "Wave size".
constexpr std::uint32_t kWaveSizeCpu = 16U << 10U;
constexpr std::uint32_t kWaveSizeGpu = 1U << 20U;
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

std::uint32_t ChooseWaveSize(const RenderOptions& options, const DeviceProperties& properties) {
    const std::uint64_t pixels = std::uint64_t{options.imageWidth} * options.imageHeight;
    std::uint64_t size = options.waveSize;
    if (size == 0) {
        size = properties.isCpu ? kWaveSizeCpu : kWaveSizeGpu;
        size = std::min(size, std::max<std::uint64_t>(pixels * options.samples, HDS_SAMPLE_BLOCK));
    }
    return static_cast<std::uint32_t>(std::max<std::uint64_t>(size, HDS_SAMPLE_BLOCK));
}

bool ChooseWide(const RenderOptions& options, const DeviceProperties& properties) {
    return options.traversal == TraversalForm::Auto ? properties.isCpu
                                                    : options.traversal == TraversalForm::Wide;
}

/// AOVs that one ray through each pixel's centre gives.
const char* const kFirstHitAovs[] = {"depth",  "cameraDepth", "normal",     "Neye",     "position",
                                     "albedo", "primId",      "instanceId", "elementId"};

bool NeedsFirstHits(const AovLayout& layout) {
    return std::any_of(std::begin(kFirstHitAovs), std::end(kFirstHitAovs),
                       [&](const char* name) { return layout.Find(name) != nullptr; });
}

} // namespace

struct PathTracer::Impl {
    Impl(std::shared_ptr<Device> theDevice, Store* store, const CommittedScene& theScene,
         RenderOptions theOptions)
        : device(std::move(theDevice)), scene(theScene), options(std::move(theOptions)),
          waveSize(ChooseWaveSize(options, device->Properties())), buffers(device, scene),
          kernels(device, store, buffers,
                  {scene.hasCutouts, scene.hasGroups, ChooseWide(options, device->Properties()),
                   NeedsFirstHits(options.aovs)}) {
        numPixels = options.imageWidth * options.imageHeight;
        const shared::HdsFrameParams params = MakeFrameParams(
            options, scene.centre, static_cast<std::uint32_t>(scene.lights.lights.size()));
        frame = Buffer(device, "frame constants", sizeof(params), BufferAccess::ReadOnly);
        frame.Write(&params, sizeof(params));
        const std::vector<float> filterTable =
            BuildPixelFilterTable(options.pixelFilter, options.pixelFilterWidth);
        filter = UploadVector(device, "pixel filter", filterTable);
        paths = Buffer(device, "path state", std::uint64_t{waveSize} * kernels.PathStateBytes());
        for (Buffer& queue : queues) {
            queue = Buffer(device, "ray queue", std::uint64_t{waveSize} * sizeof(std::uint32_t));
        }
        counters = Buffer(device, "counters", HDS_NUM_COUNTERS * sizeof(std::uint32_t));
        counters.Fill(0, HDS_NUM_COUNTERS * sizeof(std::uint32_t));
        film = Buffer(device, "film", std::uint64_t{numPixels} * sizeof(shared::HdsFilmPixel));
        film.Fill(0, film.Bytes());
        SetActivePixels(MakePixelOrder(options.imageWidth, options.imageHeight));
        statistics.compileSeconds = kernels.BuildSeconds();
        statistics.waveSize = waveSize;
        statistics.isWideTraversal = ChooseWide(options, device->Properties());
        statistics.pathStateBytes = paths.Bytes();
        for (const Buffer& queue : queues) {
            statistics.pathStateBytes += queue.Bytes();
        }
        statistics.filmBytes = film.Bytes();
    }

    void SetActivePixels(std::vector<std::uint32_t> list) {
        pixels = UploadVector(device, "active pixels", list);
        activePixels = std::move(list);
    }

    /// Traces the active paths of queue `queue` to their closest hits.
    void Intersect(std::uint32_t queue, std::uint32_t count) {
        const Timer timer;
        kernels.intersect.Launch(count, paths, waveSize, queues[queue], count);
        device->Finish();
        statistics.traceSeconds += timer.Seconds();
        ++statistics.casts;
    }

    std::array<std::uint32_t, HDS_NUM_COUNTERS> ReadCounters() const {
        std::array<std::uint32_t, HDS_NUM_COUNTERS> values{};
        counters.Read(values.data(), sizeof(values));
        return values;
    }

    void ClearCounter(std::uint32_t counter) {
        counters.Fill(0, sizeof(std::uint32_t), counter * sizeof(std::uint32_t));
    }

    /// Casts shadow rays until each is decided; what arrives is added to the paths.
    void CastShadows(std::uint32_t count) {
        const Timer timer;
        std::uint32_t present = kShadowQueue;
        std::uint32_t next = kShadowQueue + 1;
        while (count > 0) {
            statistics.shadowRays += count;
            ++statistics.casts;
            if (!scene.hasCutouts) {
                kernels.shadowCast.Launch(count, paths, waveSize, queues[present], count,
                                          queues[next], counters);
                break;
            }
            ClearCounter(HDS_COUNTER_SHADOW);
            kernels.shadowCast.Launch(count, paths, waveSize, queues[present], count, queues[next],
                                      counters);
            const std::uint32_t candidates = ReadCounters()[HDS_COUNTER_SHADOW];
            ClearCounter(HDS_COUNTER_SHADOW);
            kernels.shadowPass.Launch(candidates, paths, waveSize, queues[next], candidates,
                                      queues[present], counters);
            count = candidates > 0 ? ReadCounters()[HDS_COUNTER_SHADOW] : 0;
        }
        device->Finish();
        statistics.traceSeconds += timer.Seconds();
    }

    void RenderWave(const shared::HdsWave& wave) {
        std::uint32_t present = 0;
        std::uint32_t active = wave.numPixels * wave.numSamples;
        kernels.generateSample.Launch(active, frame, wave, paths, waveSize, pixels, filter,
                                      queues[present]);
        statistics.cameraRays += active;
        bool isFirst = true;
        while (active > 0) {
            if (!isFirst) {
                statistics.indirectRays += active;
            }
            isFirst = false;
            Intersect(present, active);
            const Timer timer;
            ClearCounter(HDS_COUNTER_ACTIVE);
            ClearCounter(HDS_COUNTER_SHADOW);
            kernels.shade.Launch(active, frame, paths, waveSize, queues[present], active,
                                 queues[1 - present], queues[kShadowQueue], counters);
            const auto counts = ReadCounters();
            statistics.shadeSeconds += timer.Seconds();
            CastShadows(counts[HDS_COUNTER_SHADOW]);
            active = counts[HDS_COUNTER_ACTIVE];
            present = 1 - present;
        }
        kernels.resolve.Launch(wave.numPixels, wave, paths, waveSize, pixels, film, counters);
        device->Finish();
    }

    /// Samples [firstSample, firstSample + numSamples) of all active pixels; true when all are
    /// done. \param[out] isStopped the render is to end.
    bool RenderPass(std::uint32_t firstSample, std::uint32_t numSamples, const Timer& timer,
                    const ProgressCallback& onProgress, bool* isStopped) {
        const auto pixelCount = static_cast<std::uint32_t>(activePixels.size());
        const std::uint32_t pixelsPerWave = std::max(1U, waveSize / numSamples);
        for (std::uint32_t first = 0; first < pixelCount; first += pixelsPerWave) {
            const std::uint32_t count = std::min(pixelsPerWave, pixelCount - first);
            RenderWave({first, count, firstSample, numSamples});
            const double passFraction = static_cast<double>(first + count) / pixelCount;
            *isStopped =
                !Report(firstSample, firstSample + passFraction * numSamples, timer, onProgress);
            if (*isStopped && first + count < pixelCount) {
                return false;
            }
        }
        return true;
    }

    bool Report(std::uint32_t samplesDone, double samplesEquivalent, const Timer& timer,
                const ProgressCallback& onProgress) const {
        const double seconds = timer.Seconds();
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
        kernels.relativeError.Launch(count, film, pixels, count, errors);
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
            SetActivePixels(std::move(rest));
        }
    }

    RenderResult Render(const ProgressCallback& onProgress) {
        const Timer timer;
        std::uint32_t done = 0;
        bool isStopped = false;
        while (done < options.samples && !activePixels.empty() && !isStopped) {
            // One sample first, for a first image; then up to the border of the block, then blocks.
            const std::uint32_t border =
                done == 0 ? 1 : (done / HDS_SAMPLE_BLOCK + 1) * HDS_SAMPLE_BLOCK;
            const std::uint32_t passEnd = std::min({options.samples, border, done + waveSize});
            if (RenderPass(done, passEnd - done, timer, onProgress, &isStopped)) {
                done = passEnd;
            }
            if (done == 1 && statistics.firstImageSeconds == 0.0) {
                statistics.firstImageSeconds = timer.Seconds();
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
        SetActivePixels(MakePixelOrder(options.imageWidth, options.imageHeight));
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
    void RenderFirstHits(const Buffer& floats, const Buffer& ints,
                         const shared::HdsAovOffsets& offsets) {
        const auto pixelCount = static_cast<std::uint32_t>(activePixels.size());
        for (std::uint32_t first = 0; first < pixelCount; first += waveSize) {
            const std::uint32_t count = std::min(waveSize, pixelCount - first);
            const shared::HdsWave wave{first, count, 0, 1};
            kernels.generateCentre.Launch(count, frame, wave, paths, waveSize, pixels, queues[0]);
            std::uint32_t present = 0;
            std::uint32_t active = count;
            while (active > 0) {
                Intersect(present, active);
                ClearCounter(HDS_COUNTER_ACTIVE);
                kernels.aov.Launch(active, frame, paths, waveSize, queues[present], active,
                                   queues[1 - present], counters, floats, ints, offsets);
                active = ReadCounters()[HDS_COUNTER_ACTIVE];
                present = 1 - present;
            }
        }
    }

    std::vector<ImageLayer> Layers() {
        const Timer timer;
        const AovLayout& layout = options.aovs;
        Buffer floats(device, "AOV floats",
                      std::uint64_t{numPixels} * layout.floatsPerPixel * sizeof(float));
        Buffer ints(device, "AOV ids",
                    std::uint64_t{numPixels} * layout.intsPerPixel * sizeof(std::int32_t));
        const auto offset = [&](const char* name) {
            const AovSlot* slot = layout.Find(name);
            return slot != nullptr ? slot->offset : HDS_NONE;
        };
        kernels.develop.Launch(numPixels, film, numPixels, floats, layout.floatsPerPixel, ints,
                               layout.intsPerPixel, offset("color"), offset("alpha"),
                               offset("variance"), offset("sampleCount"));
        shared::HdsAovOffsets offsets{};
        offsets.floatStride = layout.floatsPerPixel;
        offsets.intStride = layout.intsPerPixel;
        offsets.depth = offset("depth");
        offsets.cameraDepth = offset("cameraDepth");
        offsets.normal = offset("normal");
        offsets.normalEye = offset("Neye");
        offsets.position = offset("position");
        offsets.albedo = offset("albedo");
        offsets.primId = offset("primId");
        offsets.instanceId = offset("instanceId");
        offsets.elementId = offset("elementId");
        offsets.centre[0] = static_cast<float>(scene.centre.x);
        offsets.centre[1] = static_cast<float>(scene.centre.y);
        offsets.centre[2] = static_cast<float>(scene.centre.z);
        if (NeedsFirstHits(layout)) {
            RenderFirstHits(floats, ints, offsets);
        }
        std::vector<float> hostFloats(std::size_t{numPixels} * layout.floatsPerPixel);
        std::vector<std::int32_t> hostInts(std::size_t{numPixels} * layout.intsPerPixel);
        device->Finish();
        floats.Read(hostFloats.data(), hostFloats.size() * sizeof(float));
        ints.Read(hostInts.data(), hostInts.size() * sizeof(std::int32_t));
        statistics.transferSeconds += timer.Seconds();
        return MakeLayers(layout, options.imageWidth, options.imageHeight, hostFloats.data(),
                          hostInts.data());
    }

    static constexpr std::uint32_t kShadowQueue = 2; ///< queues 0, 1: paths; 2, 3: shadow rays

    std::shared_ptr<Device> device;
    const CommittedScene& scene;
    RenderOptions options;
    std::uint32_t waveSize;
    SceneBuffers buffers;
    StageKernels kernels;
    std::uint32_t numPixels = 0;
    std::vector<std::uint32_t> activePixels;
    Buffer frame;
    Buffer filter;
    Buffer paths;
    std::array<Buffer, 4> queues;
    Buffer counters;
    Buffer film;
    Buffer pixels;
    RenderStatistics statistics;
};

PathTracer::PathTracer(std::shared_ptr<Device> device, Store* store, const CommittedScene& scene,
                       RenderOptions options)
    : _impl(std::make_unique<Impl>(std::move(device), store, scene, std::move(options))) {}

PathTracer::~PathTracer() = default;

RenderResult PathTracer::Render(const ProgressCallback& onProgress) {
    return _impl->Render(onProgress);
}

std::vector<ImageLayer> PathTracer::Layers() const {
    return _impl->Layers();
}

const RenderStatistics& PathTracer::Statistics() const {
    return _impl->statistics;
}

std::uint64_t PathTracer::PoolBytes() const {
    return _impl->buffers.Pool().Bytes();
}

std::uint64_t PathTracer::TableBytes() const {
    return _impl->buffers.TableBytes();
}

} // namespace hds
