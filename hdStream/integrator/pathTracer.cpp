// SPDX-License-Identifier: Apache-2.0
#include "hdStream/integrator/pathTracer.h"

#include "hdStream/integrator/ambientOcclusion.h"
#include "hdStream/integrator/catcherLight.h"
#include "hdStream/integrator/domeGuidePass.h"
#include "hdStream/integrator/filmBuffers.h"
#include "hdStream/integrator/firstHits.h"
#include "hdStream/integrator/frameConstants.h"
#include "hdStream/integrator/kernelSets.h"
#include "hdStream/integrator/onlooker.h"
#include "hdStream/integrator/pixelLists.h"
#include "hdStream/integrator/sampleSchedule.h"
#include "hdStream/integrator/sceneFeatures.h"
#include "hdStream/integrator/waveSize.h"
#include "hdStream/integrator/waveTracer.h"
#include "hdStream/shading/domeGuide.h"
#include "kernels/shared/frame.h"

#include <algorithm>
#include <array>
#include <optional>
#include <utility>

namespace hds {

struct PathTracer::Impl {
    Impl(std::shared_ptr<Device> theDevice, Store* theStore)
        : device(std::move(theDevice)), kernelSets(device, theStore), buffers(device, theStore),
          film(device), constants(device), pixelLists(device),
          tracer(device, &buffers, &statistics), catchers(device), occlusion(device) {}

    bool SetScene(const CommittedScene& newScene, const ResidencyOptions& newResidency) {
        scene = nullptr;
        if (!buffers.Update(newScene, newResidency)) {
            return false;
        }
        residency = newResidency;
        scene = &newScene;
        ++sceneNumber;
        return true;
    }

    void Begin(RenderOptions newOptions, const std::vector<FilmSums>& start) {
        options = std::move(newOptions);
        statistics = {};
        sceneNumber += buffers.SetMipBias(static_cast<float>(options.mipBias)) ? 1 : 0;
        sceneNumber += buffers.SetDomeGuide({}, {}) ? 1 : 0; // that of the last render
        ReadyHierarchy();
        kernelSets.EndWarm();
        ReadyKernels();
        if (remembersKernels) {
            kernelSets.Remember(kernels->Features());
        }
        ReadyPathState();
        constants.Ready(options, *scene);
        tracer.ClearCounters();
        film.Reset(options.aovs, options.deep, options.imageWidth, options.imageHeight);
        statistics.filmBytes = film.Bytes();
        film.Load(kernels, start);
        schedule.Begin(options, start);
        pixelLists.Begin(schedule);
        hasRest = start.empty();
        numBegun = 0;
        SetWaveLimits();
    }

    const DeviceProperties& Properties() const { return device->Properties(); }

    KernelFeatures MakeFeatures(bool isStreaming) const {
        return SceneFeatures(*scene, options, residency, buffers, Properties(), isStreaming);
    }

    /// Builds the flat hierarchy where rays will pay for it; hosts that edit wait for none.
    void ReadyHierarchy() {
        if (!buffers.IsStreaming() && MayBeFlat(*scene, options, residency) &&
            buffers.Flatten(*scene,
                            LimitsOfFlat(*scene, options, residency, buffers, Properties()))) {
            ++sceneNumber;
            statistics.flattenSeconds = buffers.Flat().BuildSeconds();
        }
    }

    void ReadyKernels() {
        const KernelFeatures features = PresentFeatures();
        kernels =
            &kernelSets.Get(Choose(features), buffers, sceneNumber, &statistics.compileSeconds);
        statistics.hasGeneralKernels = !(kernels->Features() == features);
        statistics.traversal = FormOf(features);
    }

    static std::uint64_t BytesPerSlot(const KernelFeatures& features) {
        return StageKernels::PathStateBytes(features) + WaveTracer::SlotQueueBytes(features);
    }

    /// Of a wave while geometry streams. \param evicts pages leave meanwhile.
    std::uint64_t AffordableSlots(bool evicts) const {
        const std::uint64_t residentSlots = ResidentWaveSize(Properties());
        // Tables of textures that stream are there besides.
        const std::uint64_t otherBytes =
            buffers.Textures().Pool() != nullptr ? buffers.Textures().TableBytes() : 0;
        const std::uint64_t pathBytes =
            StreamedPathBytes(scene->pages->TotalBytes(), buffers.PoolBytes(),
                              residentSlots * BytesPerSlot(MakeFeatures(false)), otherBytes);
        const KernelFeatures& features = kernels->Features();
        const std::uint64_t sumBytes = features.HasLists() ? StreamedPathsPerSlot(options, evicts) *
                                                                 WaveTracer::SumBytes(features)
                                                           : 0;
        const std::uint64_t slotBytes = BytesPerSlot(features) + sumBytes;
        const std::uint64_t stateBytes = StreamedStateBytes(
            buffers.PoolBytes(), residentSlots * slotBytes, buffers.GeometryTableBytes());
        return std::min(pathBytes, stateBytes) / slotBytes;
    }

    void ReadyPathState() {
        const bool hasLists = kernels->Features().HasLists();
        const bool evicts = hasLists && !buffers.Streaming().HasRoomForAll();
        const std::uint32_t numSlots = ChooseWaveSize(
            options, device->Properties(), buffers.IsStreaming() ? AffordableSlots(evicts) : 0);
        const std::uint32_t numPaths =
            hasLists ? StreamedWavePaths(options, numSlots, evicts) : numSlots;
        tracer.Ready(kernels, scene->hasCutouts, {numSlots, numPaths}, TileSize(Properties()),
                     options.shadeIterations);
        statistics.waveSize = numSlots;
        SetWaveLimits();
    }

    void SetWaveLimits() {
        const std::uint32_t most = tracer.MaxPaths();
        schedule.SetLimits(
            {most, LeastWaveSize(options, device->Properties(), most), buffers.IsStreaming()});
    }

    /// Pixels that have no sample yet, of which the film holds what it held before.
    void ClearRest() {
        if (std::exchange(hasRest, false)) {
            film.ClearRest(options.interactive ? schedule.Pixels(PixelList::Preview)
                                               : schedule.AllPixels(),
                           numBegun);
        }
    }

    WaveTracer::Generate GenerateSamples(const shared::HdsWave& wave) {
        return [this, wave](std::uint32_t first, std::uint32_t count, const Buffer& queue,
                            std::uint32_t queueFirst) {
            kernels->generateSample.Launch(count, constants.Frame(), wave, first, count,
                                           tracer.Paths(), tracer.NumSlots(), *pixels,
                                           constants.Filter(), queue, queueFirst);
        };
    }

    /// \return false when it was cancelled.
    bool TraceSamples(const shared::HdsWave& wave, const WaveTracer::IsCancelled& isCancelled) {
        const Buffer& paths = tracer.Paths();
        const std::uint32_t numSlots = tracer.NumSlots();
        return tracer.Trace(
            wave.numPixels * wave.numSamples, GenerateSamples(wave),
            [&](const Buffer& queue, std::uint32_t count, const Buffer& waiting,
                const Buffer& next) {
                kernels->shade.Launch(count, constants.Frame(), paths, numSlots, queue, count,
                                      waiting, next, tracer.ShadowQueue(), tracer.Counters());
            },
            isCancelled);
    }

    /// Traces another picture, whose samples nobody keeps. \return false when it was cancelled.
    bool TracePaths(const RenderOptions& picture, const WaveTracer::IsCancelled& isCancelled) {
        const Buffer others = UploadVector(device, "pixels of another picture", PixelsOf(picture));
        pixels = &others;
        constants.SetOptions(picture, *scene);
        const bool isDone = ForEachWave(picture, tracer.MaxPaths(), [&](const auto& wave) {
            return TraceSamples(wave, isCancelled);
        });
        pixels = nullptr; // RenderPass asks for a list
        constants.SetOptions(options, *scene);
        CollectTexelCounts();
        return isDone;
    }

    /// Learns the guide of domes, in a tenth of a limit of time; who edits does not wait for it.
    void LearnDomes(Onlooker* onlooker, bool isNeeded) {
        if (!isNeeded || options.interactive || !MayHaveGuide(*scene->lights)) {
            return;
        }
        const auto isCancelled = [&] {
            const auto& ask = onlooker->watch.isCancelled;
            onlooker->isStopped = onlooker->isStopped || (ask && ask());
            return onlooker->isStopped || schedule.IsTimeUp(10.0 * onlooker->timer.Seconds());
        };
        const RenderStatistics before = statistics; // counts are those of pictures
        LearnDomeGuide(options, constants.CameraPosition(), &tracer, &buffers,
                       [&](const auto& picture) { return TracePaths(picture, isCancelled); });
        statistics.TakeCounts(before);
        ++sceneNumber; // the tables of lights may be others
        ReadyKernels();
        ReadyPathState();
    }

    /// \return false when it was cancelled: the film is as before.
    bool RenderWave(const shared::HdsWave& wave, const WaveTracer::IsCancelled& isCancelled) {
        const std::uint32_t numPaths = wave.numPixels * wave.numSamples;
        const std::uint32_t numSlots = tracer.NumSlots();
        statistics.cameraRays += numPaths;
        statistics.streamedPaths += buffers.IsStreaming() ? numPaths : 0;
        const bool hasOcclusion = kernels->Features().occlusion;
        if (hasOcclusion &&
            !occlusion.Trace(kernels, &tracer, numPaths, constants.Frame(),
                             options.occlusionDistance, GenerateSamples(wave), isCancelled)) {
            return false;
        }
        const auto trace = [&] { return TraceSamples(wave, isCancelled); };
        const bool hasCatchers = kernels->Features().catchers;
        if (hasCatchers && !catchers.TraceAlone(kernels, &buffers, tracer, numPaths, trace)) {
            return false;
        }
        if (!trace()) {
            return false;
        }
        if (hasCatchers) {
            catchers.Add(kernels, wave, tracer, *pixels, film);
        }
        if (hasOcclusion) {
            occlusion.Add(kernels, wave, *pixels, film);
        }
        if (film.NumLightPaths() > 0) {
            kernels->addLightPaths.Launch(std::size_t{wave.numPixels} * film.NumLightPaths(), wave,
                                          tracer.Sums(), numSlots, tracer.MaxPaths(), *pixels,
                                          film.Film(), film.LightPaths(), film.NumPixels(),
                                          film.NumLightPaths());
        }
        kernels->resolve.Launch(wave.numPixels, wave, tracer.Sums(), numSlots, *pixels, film.Film(),
                                tracer.Counters());
        device->Finish();
        if (film.HasMattes() || film.HasDeep()) {
            CollectSurfaces(wave);
        }
        CollectTexelCounts();
        return true;
    }

    /// What paths of a wave keep, 16 bytes each: `field` of their state. \param sum with lists: the
    /// number of it in the sums.
    template <typename T>
    std::vector<std::array<T, 4>> ReadField(const shared::HdsWave& wave, const char* field,
                                            std::uint64_t sum) {
        std::vector<std::array<T, 4>> values(std::size_t{wave.numPixels} * wave.numSamples);
        const std::uint64_t bytes = values.size() * sizeof(values[0]);
        if (kernels->Features().HasLists()) {
            tracer.Sums().Read(values.data(), bytes, sum * tracer.MaxPaths() * sizeof(values[0]));
        } else {
            tracer.Paths().Read(values.data(), bytes,
                                StageKernels::FieldOffset(kernels->Features(), field) *
                                    tracer.NumSlots());
        }
        return values;
    }

    /// Counts what camera rays have met.
    void CollectSurfaces(const shared::HdsWave& wave) {
        const std::uint32_t* wavePixels = schedule.Pixels(presentList).data() + wave.firstPixel;
        const auto surfaces = ReadField<std::uint32_t>(wave, "matte", 1);
        if (film.HasMattes()) {
            film.AddMattes(*scene, wavePixels, wave.numSamples, surfaces);
        }
        if (film.HasDeep()) {
            film.AddDeep(wavePixels, wave.numSamples, surfaces,
                         ReadField<float>(wave, "radiance", 0));
            statistics.deepBytes = film.Deep().Bytes();
            statistics.deepCrowded = film.Deep().NumCrowded();
        }
    }

    /// Before they overflow.
    void CollectTexelCounts() {
        if (TexturePool* pool = buffers.Textures().Pool()) {
            pool->CollectCounts();
        }
    }

    /// \return whether all of the pass is rendered: it was not stopped before its last wave.
    bool RenderPass(const SamplePass& pass, Onlooker* onlooker) {
        pixels = &pixelLists.Get(schedule, pass.list);
        presentList = pass.list;
        std::uint32_t rendered = pass.begin;
        while (rendered < pass.end) {
            // One work-item adds all samples of a pixel that a pass makes, so they are in one wave.
            HDS_VERIFY(pass.numSamples <= tracer.MaxPaths(),
                       std::to_string(pass.numSamples) +
                           " samples of a pixel do not fit a wave of " +
                           std::to_string(tracer.MaxPaths()));
            const std::uint32_t count = schedule.WavePixels(pass, rendered);
            const std::uint32_t first = pass.FirstOfWave(rendered, count);
            const Timer timer;
            if (!RenderWave({first, count, pass.firstSample, pass.numSamples},
                            onlooker->watch.isCancelled)) {
                onlooker->isStopped = true;
                return false;
            }
            schedule.EndWave(count * pass.numSamples, timer.Seconds());
            rendered += count;
            numBegun = pass.firstSample == 0 ? rendered : numBegun;
            const double samplesEquivalent = schedule.Equivalent(pass, rendered);
            const bool hadRate = onlooker->rate.SecondsPerSample() > 0.0;
            onlooker->rate.EndWave(TracingSeconds(), samplesEquivalent);
            Report(samplesEquivalent, onlooker);
            if (rendered < pass.end) {
                MakeResidentIfWorth(samplesEquivalent, !hadRate, onlooker);
            }
            TakeOwnKernels(SecondsLeft(samplesEquivalent, *onlooker));
            if (onlooker->isStopped && rendered < pass.end) {
                return false;
            }
        }
        onlooker->rate.EndPass();
        return true;
    }

    /// Tells how far the render is, which may stop it.
    void Report(double samplesEquivalent, Onlooker* onlooker) {
        const double seconds = onlooker->timer.Seconds();
        statistics.renderSeconds = seconds;
        statistics.samples = schedule.Done();
        if (schedule.IsTimeUp(seconds) && schedule.Done() > 0) {
            onlooker->isStopped = true;
        } else if (onlooker->onProgress) {
            onlooker->isStopped =
                !onlooker->onProgress(schedule.MakeProgress(samplesEquivalent, seconds));
        }
    }

    double SecondsLeft(double samplesEquivalent, const Onlooker& onlooker) const {
        return schedule.SecondsLeft(onlooker.rate.SecondsPerSample(), samplesEquivalent,
                                    onlooker.timer.Seconds());
    }

    double TracingSeconds() const { return statistics.traceSeconds + statistics.shadeSeconds; }

    /// Between waves: makes geometry that streams resident when that is worth it (makeResident.h).
    /// \param isNews more is known than pages that were loaded since it was last asked for: while
    /// samples are rendered it is worth less and less.
    void MakeResidentIfWorth(double samplesEquivalent, bool isNews, Onlooker* onlooker) {
        if (onlooker->isStopped || samplesEquivalent >= options.samples || !buffers.IsStreaming()) {
            return;
        }
        const StreamingStatistics pool = buffers.PoolStatistics();
        const bool isAnyLoaded =
            std::exchange(onlooker->judgedUploads, pool.uploads) != pool.uploads;
        if (!(isNews || isAnyLoaded) || !buffers.MayBecomeResident()) {
            return;
        }
        MakeResidentCosts costs;
        costs.secondsLeft = SecondsLeft(samplesEquivalent, *onlooker);
        const KernelFeatures features = MakeFeatures(false);
        costs.kernelSeconds = SecondsToGet(kernelSets.PlaceOf(Choose(features)));
        costs.flatTriangles = features.flat ? scene->counts.triangles : 0;
        costs.missingBytes = buffers.Streaming().MissingBytes();
        costs.prepareSeconds = pool.prepareSeconds;
        costs.preparedBytes = pool.uploadedBytes;
        if (!IsWorthMakingResident(costs)) {
            return;
        }
        while (buffers.MayBecomeResident()) {
            buffers.LoadMissing();
            if (buffers.IsStreaming()) {
                Report(samplesEquivalent, onlooker);
            }
            if (onlooker->isStopped) {
                return;
            }
        }
        if (!buffers.IsStreaming()) {
            ReadyHierarchy();
            ReadyKernels();
            ReadyPathState();
        }
    }

    KernelFeatures PresentFeatures() const { return MakeFeatures(buffers.IsStreaming()); }

    /// The features of the kernels that render what asks for `features`.
    KernelFeatures Choose(const KernelFeatures& features) {
        return kernelSets.Choose(features, options.kernels, !options.interactive);
    }

    /// Between waves: kernels of the scene's own take the place of general ones.
    void TakeOwnKernels(double secondsLeft) {
        if (options.kernels == KernelChoice::Auto && statistics.hasGeneralKernels &&
            kernelSets.HaveOwnCome(PresentFeatures(), secondsLeft)) {
            ReadyKernels();
            ReadyPathState();
        }
    }

    void CountAccuracy(bool withError) {
        const auto values = tracer.ReadCounters();
        statistics.nanSamples = values[HDS_COUNTER_NAN];
        statistics.endedPasses = values[HDS_COUNTER_PASSES];
        statistics.endedWalks = values[HDS_COUNTER_STEPS];
        statistics.clampedSamples = values[HDS_COUNTER_CLAMPED];
        if (withError) {
            ClearRest();
            statistics.meanRelativeError =
                film.MeanRelativeError(kernels, pixelLists.All(schedule), film.NumPixels());
        }
    }

    RenderResult Render(const ProgressCallback& onProgress, const RenderWatch& watch) {
        Onlooker onlooker{onProgress, watch, {}};
        if (schedule.PreviewStride() > 0) { // the film that was loaded is a picture
            statistics.firstImageSeconds = onlooker.timer.Seconds();
        }
        std::optional<SamplePass> pass = schedule.Next();
        LearnDomes(&onlooker, pass.has_value());
        while (pass && !onlooker.isStopped && RenderPass(*pass, &onlooker)) {
            EndPass(*pass, &onlooker);
            pass = schedule.Next();
        }
        statistics.renderSeconds = onlooker.timer.Seconds();
        statistics.samples = schedule.Done();
        const bool isCut = onlooker.isStopped && !schedule.IsTimeUp(onlooker.timer.Seconds());
        CountAccuracy(!isCut || !watch.takesPictures); // who edits waits, and asks for no error
        buffers.CountUsed();
        if (isCut) {
            return RenderResult::Stopped;
        }
        if (statistics.hasGeneralKernels) {
            kernelSets.AddGeneralSeconds(PresentFeatures(), TracingSeconds());
        }
        kernelSets.SaveBinaries();
        return RenderResult::Complete;
    }

    void EndPass(const SamplePass& pass, Onlooker* onlooker) {
        const std::uint32_t before = schedule.Done();
        if (pass.isOfFirstPicture && pass.end == schedule.Pixels(pass.list).size()) {
            statistics.firstImageSeconds = onlooker->timer.Seconds();
            if (onlooker->watch.takesPictures && film.NeedsFirstHits() && !onlooker->isStopped) {
                RenderFirstHits(schedule.Equivalent(pass, pass.end), onlooker);
            }
        }
        schedule.Complete();
        const std::uint32_t done = schedule.Done();
        if (pass.isOfFirstPicture && !onlooker->isStopped) {
            Report(schedule.Equivalent(pass, pass.end), onlooker);
        }
        if (done > before) {
            if (std::exchange(onlooker->streamedPaths, statistics.streamedPaths) <
                statistics.streamedPaths) {
                statistics.streamedSamples = done;
            }
            MakeResidentIfWorth(done, true, onlooker);
        }
        if (schedule.MayDrop() && !onlooker->isStopped) {
            schedule.Drop(film.RelativeErrors(kernels, *pixels, pass.end));
        }
    }

    /// The AOVs of first hits. \param onlooker told after each wave that so many samples are done,
    /// and may stop it; null: nobody is.
    void RenderFirstHits(double samplesEquivalent, Onlooker* onlooker) {
        const auto goesOn = [&] {
            if (onlooker != nullptr) {
                Report(samplesEquivalent, onlooker);
            }
            return onlooker == nullptr || !onlooker->isStopped;
        };
        const auto numPixels = static_cast<std::uint32_t>(schedule.AllPixels().size());
        const std::uint64_t indirectRays = statistics.indirectRays; // counts those of pictures
        const bool isDone = TraceFirstHits(
            device, {scene, &options, &constants.Frame(), &pixelLists.All(schedule), numPixels},
            kernels, &tracer, &film, goesOn,
            onlooker != nullptr ? onlooker->watch.isCancelled : WaveTracer::IsCancelled());
        if (!isDone) {
            onlooker->isStopped = true;
            return;
        }
        statistics.indirectRays = indirectRays;
        CollectTexelCounts();
    }

    std::vector<ImageLayer> Layers(bool withFirstHits) {
        const Timer timer;
        if (withFirstHits && film.NeedsFirstHits() && !film.HasFirstHits() &&
            schedule.PreviewStride() > 0) {
            RenderFirstHits(0.0, nullptr);
        }
        std::vector<ImageLayer> layers = film.Develop(
            kernels, schedule.PreviewStride(), [this](MatteKind kind, const MatteSurface& surface) {
                return MatteName(*scene, kind, surface);
            });
        statistics.transferSeconds += timer.Seconds();
        return layers;
    }

    std::shared_ptr<Device> device;
    KernelSets kernelSets;
    const CommittedScene* scene = nullptr;
    RenderOptions options;
    SceneBuffers buffers;
    ResidencyOptions residency;
    bool remembersKernels = false; ///< somebody warms them
    FilmBuffers film;
    std::uint64_t sceneNumber = 0;   ///< counts what kernels are bound to
    StageKernels* kernels = nullptr; ///< those of the present render
    SampleSchedule schedule;
    PixelList presentList = PixelList::Active; ///< that `pixels` is
    FrameConstants constants;
    std::uint32_t numBegun = 0; ///< pixels that have a sample: the first ones of their list
    bool hasRest = false;       ///< the others are not black, but where a film was loaded
    PixelLists pixelLists;
    const Buffer* pixels = nullptr; ///< of the present pass
    RenderStatistics statistics;
    WaveTracer tracer;
    CatcherLight catchers;
    AmbientOcclusion occlusion;
};

PathTracer::PathTracer(std::shared_ptr<Device> device, Store* store)
    : _impl(std::make_unique<Impl>(std::move(device), store)) {}

PathTracer::~PathTracer() = default;

void PathTracer::WarmKernels() {
    _impl->kernelSets.Warm();
    _impl->remembersKernels = true;
}

bool PathTracer::NeedsAllPages(const CommittedScene& scene,
                               const ResidencyOptions& residency) const {
    return _impl->buffers.Plan(scene, residency).needsAllPages;
}

bool PathTracer::SetScene(const CommittedScene& scene, const ResidencyOptions& residency) {
    return _impl->SetScene(scene, residency);
}

bool PathTracer::TakePlaces(const PlaceChanges& changes) {
    _impl->sceneNumber += changes.arePages || changes.areLights ? 1 : 0; // in other buffers
    return _impl->buffers.TakePlaces(*_impl->scene, changes, _impl->residency);
}

void PathTracer::Begin(RenderOptions options, const std::vector<FilmSums>& start) {
    _impl->Begin(std::move(options), start);
}

RenderResult PathTracer::Render(const ProgressCallback& onProgress, const RenderWatch& watch) {
    return _impl->Render(onProgress, watch);
}

std::vector<ImageLayer> PathTracer::Layers(bool withFirstHits) {
    return _impl->Layers(withFirstHits);
}

DeepImage PathTracer::Deep() const {
    return _impl->film.HasDeep() ? _impl->film.Deep().Make() : DeepImage();
}

FilmSums PathTracer::Film() const {
    _impl->ClearRest();
    return _impl->film.Read(_impl->schedule.FilmBegin(), _impl->statistics.samples);
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
