// SPDX-License-Identifier: Apache-2.0
#include "hdStream/session/session.h"

#include "hdStream/base/machine.h"
#include "hdStream/device/kernelCompilers.h"
#include "hdStream/device/poclCache.h"
#include "hdStream/geometry/subdivSource.h"
#include "hdStream/integrator/dicingCamera.h"
#include "hdStream/integrator/pathTracer.h"
#include "hdStream/integrator/sceneFeatures.h"
#include "hdStream/persist/pageStore.h"
#include "hdStream/scene/cameraNumbers.h"
#include "hdStream/scene/dump.h"
#include "hdStream/scene/primCommit.h"
#include "hdStream/scene/sceneSizes.h"
#include "hdStream/scene/transforms.h"
#include "hdStream/session/denoising.h"
#include "hdStream/session/editCounts.h"
#include "hdStream/session/frontEndArrays.h"
#include "hdStream/session/hostShares.h"
#include "hdStream/session/settingsCheck.h"
#include "hdStream/session/statistics.h"
#include "hdStream/texture/texturePool.h"

#include <algorithm>
#include <chrono>
#include <exception>
#include <map>
#include <optional>
#include <utility>

namespace hds {

namespace {

/// Lines in the statistics, which are made for every image that is shown.
constexpr std::size_t kMaxWarnings = 1000;

/// Images whose lines are made one by one may take this part of the host's bytes beside them.
constexpr std::uint64_t kKeptImagesDivisor = 8;

/// Around the commit of a scene that takes as much, what is free in small pieces is given back.
constexpr std::uint64_t kLargeScene = std::uint64_t{64} << 20U;

/// Bytes of host memory that may be taken.
std::uint64_t HostBytes(const Settings& settings) {
    constexpr std::uint64_t kDivisor = 4;
    return settings.hostMemory > 0 ? settings.hostMemory : MachineMemoryBytes() / kDivisor;
}

double SecondsSince(std::chrono::steady_clock::time_point start) {
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

/// What the present commit was made of.
struct CommitKey {
    std::uint64_t sceneVersion = 0;
    CommitOptions options;
    ResidencyOptions residency;
};

/// Premultiplied colours over black.
void FillAlpha(std::vector<ImageLayer>* layers) {
    for (ImageLayer& layer : *layers) {
        const AovInfo* info = FindAov(layer.name);
        if (info != nullptr && info->isColor && layer.channels.back() == "A") {
            for (std::size_t i = 3; i < layer.values.size(); i += 4) {
                layer.values[i] = 1.0F;
            }
        }
    }
}

} // namespace

std::vector<DeviceInfo> ListDevices() {
    return ListDeviceProperties();
}

struct Session::Impl {
    explicit Impl(WarningSink onWarning) : warnings(std::move(onWarning)), cache(warnings) {}

    void ReadyDevice(const Settings& settings) {
        if (!device || deviceName != settings.device) {
            Discard();
            device.reset(); // frees its memory first
            device = Device::Create(settings.device);
            deviceName = settings.device;
        }
        if (!store || cacheDirectory != settings.cacheDirectory || noCache != settings.noCache) {
            Discard();                     // the tracer holds the store
            device->SetCompilers(nullptr); // they write to the store
            store = std::make_unique<Store>(
                StoreOptions{settings.cacheDirectory, !settings.noCache}, &warnings);
            cacheDirectory = settings.cacheDirectory;
            noCache = settings.noCache;
            hasCaches = false;
        }
        if (device->Compilers() == nullptr && device->Properties().hasSlowBinaries) {
            ReadyCompilers();
        }
    }

    /// What of a scene is kept in the folder of ReadyDevice.
    void ReadyCaches(const Settings& settings) {
        if (!std::exchange(hasCaches, true)) {
            cache.prims.reset();
            cache.pages.Clear();
            const auto pageStore =
                noCache ? nullptr
                        : std::make_shared<PageStore>(PageStoreOptions{cacheDirectory}, &warnings);
            cache.geometry.SetPageStore(pageStore);
            cache.images.SetPageStore(pageStore);
            cache.textures = std::make_shared<TexturePreparer>(
                pageStore, &warnings, HostBytes(settings) / kKeptImagesDivisor);
            cache.grids = std::make_shared<GridPreparer>(pageStore, &warnings);
        }
    }

    /// Processes that compile take a while to start: they do it now where no kernel at all is in
    /// the store.
    void ReadyCompilers() {
        auto compilers =
            std::make_unique<KernelCompilers>(device->Properties(), store.get(), &warnings);
        const ProgramSource anyScenes = TexturePool::KernelSource(*device);
        if (compilers->CanCompile() && !Program::IsInStore(anyScenes, *store)) {
            compilers->Begin({anyScenes});
            compilers->Warm();
        }
        device->SetCompilers(std::move(compilers));
    }

    void Warm(const Settings& settings) {
        ReadyDevice(settings);
        ReadyTracer();
        tracer->WarmKernels(); // takes longer than the rest
        ReadyCaches(settings);
    }

    void ReadyTracer() {
        if (!tracer) {
            tracer = std::make_unique<PathTracer>(device, store.get());
        }
    }

    /// Everything in device memory.
    void Discard() {
        tracer.reset();
        scene.reset();
        committed.reset();
    }

    /// Bounds what is kept besides the scene as it is now.
    void ShareHostMemory(const Settings& settings) {
        statistics.sceneBytes = sizes.DescribedBytes() + cache.geometry.Bytes();
        const HostShares shares =
            hds::ShareHostMemory(HostBytes(settings), statistics.sceneBytes + arrayBlockBytes);
        cache.pages.SetLimit(shares.pages);
        cache.geometry.Sources().SetLimit(shares.sources);
    }

    /// Notes the scene's size. \return whether it is much larger than that noted before. Of many
    /// prims front ends and planning leave as much free memory behind as the scene takes; edits
    /// leave little.
    bool NoteGrowth() {
        const std::uint64_t before = std::exchange(notedBytes, statistics.sceneBytes);
        return statistics.sceneBytes >= before + kLargeScene;
    }

    /// Whether a scene may have records that were hidden: the flat hierarchy would show them.
    static bool MaySeeMended(const Settings& settings) {
        return settings.interactive && settings.traversal != "flat";
    }

    /// Mends the scene and its tables where edits since the last commit allow it. \return Done;
    /// Cancelled; Otherwise: it has to be committed.
    PrimCommit::Reshaped MendCommit(const Settings& settings, const CommitKey& key,
                                    const CancelCallback& isCancelled) {
        using Result = PrimCommit::Reshaped;
        const auto start = std::chrono::steady_clock::now();
        const PrimCommit::Edits* mendable = edits.Mendable();
        if (mendable == nullptr || !cache.prims || cache.primsVersion != edits.Content()) {
            return Result::Otherwise;
        }
        const bool isShapes = !cache.reshaped.empty();
        const std::optional<CommitKey> before = std::exchange(committed, std::nullopt);
        PlaceChanges changes;
        const Result result = cache.prims->Mend(*mendable, scene.get(), &changes, isCancelled);
        if (result != Result::Done) {
            committed = result == Result::Cancelled ? before : std::nullopt;
            return result;
        }
        if (isShapes) {
            ShareHostMemory(settings);
            statistics.keptArrays = sizes.Arrays();
            const bool isEager =
                key.residency.preparesAll || tracer->NeedsAllPages(*scene, key.residency);
            if (isEager && !scene->pages->PrepareAll(isCancelled, &chunksMade)) {
                return Result::Cancelled;
            }
        }
        if (!tracer->TakePlaces(changes)) {
            return Result::Otherwise;
        }
        committed = key;
        isMended = isMended || !mendable->prims.empty();
        statistics.primsMended = mendable->prims.size();
        edits.NoteCommit();
        statistics.commitSeconds = SecondsSince(start);
        return result;
    }

    /// The scene in device memory. \return false when it was cancelled.
    bool Commit(const Settings& settings, const RenderOptions& options,
                const CancelCallback& isCancelled) {
        CommitOptions commitOptions = MakeCommitOptions(settings);
        commitOptions.dicingCamera = dicingCamera;
        commitOptions.shutter = options.shutter;
        ResidencyOptions residency = MakeResidencyOptions(settings);
        const CommitKey key{edits.Scene(), commitOptions, residency};
        const bool isSameMaking = tracer && committed && committed->options == commitOptions &&
                                  committed->residency == residency &&
                                  (!isMended || MaySeeMended(settings));
        if (isSameMaking && committed->sceneVersion == edits.Scene()) {
            return true;
        }
        if (isSameMaking && MaySeeMended(settings)) {
            const PrimCommit::Reshaped mended = MendCommit(settings, key, isCancelled);
            if (mended != PrimCommit::Reshaped::Otherwise) {
                return mended == PrimCommit::Reshaped::Done;
            }
        }
        committed.reset();
        ShareHostMemory(settings);
        const bool isMuchNew = NoteGrowth();
        if (isMuchNew) {
            ReturnFreeMemory();
        }
        cache.contentVersion = settings.interactive ? edits.Content() : 0;
        auto next = CommitScene(description, commitOptions, &cache, warnings, isCancelled);
        if (!next) {
            return false;
        }
        ShareHostMemory(settings);
        if (isMuchNew) {
            ReturnFreeMemory();
        }
        ReadyTracer();
        residency.preparesAll = residency.preparesAll ||
                                RaysPayForAllPages(*next, options, residency, device->Properties());
        const bool isEager = residency.preparesAll || tracer->NeedsAllPages(*next, residency);
        if (isEager && !next->pages->PrepareAll(isCancelled, &chunksMade)) {
            return false;
        }
        if (!tracer->SetScene(*next, residency)) {
            // Edits have scattered the pool: a new one has the same pages in fewer places.
            tracer.reset();
            tracer = std::make_unique<PathTracer>(device, store.get());
            if (!tracer->SetScene(*next, residency)) {
                throw Error("geometry: the scene does not fit the device's memory");
            }
        }
        scene = std::move(next);
        committed = key;
        isMended = false;
        edits.NoteCommit();
        statistics.commitSeconds = scene->seconds;
        statistics.keptArrays = sizes.Arrays();
        return true;
    }

    /// Without Open Image Denoise pictures stay as they are, with a warning.
    void ReadyDenoiser(const Settings& settings) {
        denoisedAovs.clear();
        if (!settings.denoise) {
            return;
        }
        try {
            if (!denoiser) {
                denoiser = std::make_unique<Denoiser>();
            }
            denoisedAovs = settings.aovs;
        } catch (const Error& error) {
            warnings.Add("", error.what());
        }
    }

    /// That of the picture, as in a fresh session; where the camera moves under someone's eyes, the
    /// first one.
    void ReadyDicingCamera(const Settings& settings, const RenderOptions& options) {
        const bool isOfKind = dicingCamera && dicingCamera->isStill != settings.cameraMoves;
        if (isOfKind && (settings.cameraMoves || !HasSubdivided())) {
            return; // Another camera would be another commit.
        }
        dicingCamera = MakeDicingCamera(options);
        dicingCamera->isStill = !settings.cameraMoves;
    }

    bool HasSubdivided() const {
        return std::any_of(description.geometry.begin(), description.geometry.end(),
                           [](const auto& entry) {
                               const auto& geometry = entry.second.geometry;
                               return geometry && IsSubdivisionScheme(geometry->subdivisionScheme);
                           });
    }

    /// What is counted is of the render that begins.
    void BeginStatistics() {
        statistics.commitSeconds = 0.0;
        statistics.primsMended = 0;
        cache.pages.BeginStatistics();
        cache.geometry.Sources().BeginPeak();
        cache.geometry.ForgetPlanned();
        chunksMade = {};
        statistics.arrayBytesReadBefore = ArraySource::Counts().readBytes;
        device->BeginPeak();
        if (tracer) {
            tracer->BeginStatistics();
        }
    }

    RenderResult Render(const Settings& settings, const CameraPrim& camera,
                        const ProgressCallback& onProgress, const std::vector<FilmSums>& film,
                        const RenderWatch& watch) {
        const auto start = std::chrono::steady_clock::now();
        ReadyDevice(settings);
        ReadyCaches(settings);
        ReadyDenoiser(settings);
        isOpaque = settings.opaqueBackground;
        BeginStatistics();
        const CancelCallback isCancelled = [&] {
            Progress progress;
            progress.samplesTotal = settings.samples;
            progress.prims = cache.geometry.Planned();
            progress.chunks = chunksMade;
            return onProgress && !onProgress(progress);
        };
        RenderOptions options = MakeRenderOptions(settings, camera);
        if (!denoisedAovs.empty()) {
            options.aovs = MakeAovLayout(WithDenoiserGuides(denoisedAovs));
        }
        ReadyDicingCamera(settings, options);
        if (!Commit(settings, options, isCancelled)) {
            return RenderResult::Stopped;
        }
        options.aovs.hasCatchers = scene->hasCatchers;
        if (options.deep && scene->hasCatchers) {
            warnings.Add("", "a deep picture shows nothing of shadow catchers");
        }
        CheckFilmSums(film, settings.imageWidth, settings.imageHeight, settings.samples,
                      options.aovs.hasMattes, options.aovs.SumNames());
        tracer->Begin(std::move(options), film);
        if (device->Compilers() != nullptr) {
            device->Compilers()->Rest();
        }
        hasFilm = true;
        const RenderStatistics& rendered = tracer->Statistics();
        statistics.device = device.get();
        statistics.scene = scene.get();
        statistics.pages = &cache.pages;
        statistics.sources = &cache.geometry.Sources();
        statistics.tracer = tracer.get();
        statistics.imageWidth = settings.imageWidth;
        statistics.imageHeight = settings.imageHeight;
        statistics.beforeRenderingSeconds = sinceStartSeconds + SecondsSince(start);
        const RenderResult result = tracer->Render(onProgress, watch);
        if (rendered.endedPasses > 0) {
            warnings.Add("", std::to_string(rendered.endedPasses) +
                                 " rays ended after passing the most cut-out surfaces that one "
                                 "ray may pass");
        }
        statistics.totalSeconds = sinceStartSeconds + SecondsSince(start);
        return result;
    }

    hds::Warnings warnings;
    SceneDescription description;
    SceneSizes sizes; ///< of `description`
    std::unique_ptr<Store> store;
    std::shared_ptr<Device> device; ///< its compilers write to the store
    std::string deviceName;         ///< what `device` was asked for by
    std::string cacheDirectory;     ///< what `store` was made with
    bool noCache = false;
    bool hasCaches = false; ///< `cache` is of that folder
    CommitCache cache;
    EditCounts edits{&cache};                 ///< of `description`
    std::optional<DicingCamera> dicingCamera; ///< ReadyDicingCamera
    std::unique_ptr<CommittedScene> scene;
    std::optional<CommitKey> committed; ///< what `scene` and the tracer's device tables hold
    bool isMended = false;              ///< `scene` is, since its commit
    std::unique_ptr<PathTracer> tracer;
    bool hasFilm = false;  ///< the tracer has begun a render
    WorkCount chunksMade;  ///< before the first ray of the present one
    bool isOpaque = false; ///< the background of the present render
    std::unique_ptr<Denoiser> denoiser;
    std::vector<std::string> denoisedAovs; ///< of the present render; empty: it is not denoised
    StatisticsInput statistics;
    std::uint64_t notedBytes = 0; ///< of the scene, as NoteGrowth has noted it
    double sinceStartSeconds = 0.0;
};

Session::Session(WarningSink onWarning) : _impl(std::make_unique<Impl>(std::move(onWarning))) {
    ReadyPoclEnvironment();
}

Session::~Session() = default;

void Session::EndThreads() {
    _impl->tracer.reset();
    _impl->device.reset(); // its compilers warn
}

void Session::SetGeometry(const std::string& path, GeometryPrim prim) {
    _impl->edits.Count(_impl->description.geometry, path, prim);
    _impl->sizes.Set(&_impl->description.geometry, path, std::move(prim));
}

void Session::SetCategories(const std::string& path, std::set<std::string> categories) {
    const auto prim = _impl->description.geometry.find(path);
    if (prim == _impl->description.geometry.end()) {
        throw Error(path + ": there is no geometry");
    }
    prim->second.categories = std::move(categories);
    _impl->edits.Count();
}

void Session::SetVolume(const std::string& path, VolumePrim prim) {
    _impl->description.volumes[path] = std::move(prim);
    _impl->edits.Count();
}

void Session::SetInstancer(const std::string& path, InstancerPrim prim) {
    _impl->edits.Count(_impl->description.instancers, path, prim);
    _impl->sizes.Set(&_impl->description.instancers, path, std::move(prim));
}

void Session::SetLight(const std::string& path, LightPrim prim) {
    _impl->edits.Count(_impl->description.lights, path, prim);
    _impl->description.lights[path] = std::move(prim);
}

void Session::SetMaterial(const std::string& path, std::shared_ptr<const MaterialNetwork> network) {
    _impl->edits.CountMaterial(_impl->description.materials, path);
    _impl->description.materials[path] = std::move(network);
}

void Session::SetCamera(const std::string& path, CameraPrim prim) {
    _impl->description.cameras[path] = std::move(prim); // no part of a commit
}

void Session::Remove(const std::string& path) {
    SceneDescription& scene = _impl->description;
    _impl->sizes.Erase(&scene.geometry, path);
    _impl->sizes.Erase(&scene.instancers, path);
    scene.lights.erase(path);
    scene.materials.erase(path);
    scene.cameras.erase(path);
    scene.volumes.erase(path);
    _impl->edits.Count();
}

void Session::Clear() {
    _impl->description = {};
    _impl->sizes = {};
    _impl->warnings.Clear();
    _impl->edits.Count();
    Redice();
}

void Session::Redice() {
    _impl->dicingCamera.reset(); // a part of what a commit is made of
}

const SceneDescription& Session::Scene() const {
    return _impl->description;
}

void Session::Warn(const std::string& subject, const std::string& text) {
    _impl->warnings.Add(subject, text);
}

std::vector<std::string> Session::Warnings() const {
    return _impl->warnings.Lines();
}

std::string Session::Dump() const {
    return DumpScene(_impl->description);
}

std::string Session::Info() const {
    CommitCache cache(_impl->warnings);
    const auto scene =
        CommitScene(_impl->description, MakeCommitOptions(Settings()), &cache, _impl->warnings);
    return MakeInfo(_impl->description, *scene, _impl->warnings.Lines());
}

void Session::Warm(const Settings& settings) {
    try {
        _impl->Warm(settings);
    } catch (const std::exception&) { // of memory and files too; Render meets it again
        _impl->Discard();
        _impl->device.reset();
    }
}

RenderResult Session::Render(const Settings& settings, const ProgressCallback& onProgress,
                             const std::vector<FilmSums>& start, const RenderWatch& watch) {
    Impl& impl = *_impl;
    CheckSettings(settings);
    if (!start.empty() && settings.noise > 0.0) {
        throw Error("--noise: adaptive samples cannot be split or continued", ErrorKind::Usage);
    }
    if (!start.empty() && settings.deep) {
        throw Error("--deep: samples of a deep picture cannot be split or continued",
                    ErrorKind::Usage);
    }
    const auto camera = impl.description.cameras.find(settings.camera);
    if (camera == impl.description.cameras.end()) {
        throw Error("--camera " + settings.camera + ": the stage has no such camera",
                    ErrorKind::Usage);
    }
    if (!IsUsableTransform(camera->second.worldFromCamera)) {
        Warn(settings.camera,
             "a camera whose transform is singular or not finite; the picture says "
             "nothing of the scene");
    }
    CameraPrim mended = camera->second;
    for (const std::string& problem : MendCamera(&mended)) {
        Warn(settings.camera, problem);
    }
    impl.hasFilm = false;
    try {
        return impl.Render(settings, camera->second, onProgress, start, watch);
    } catch (...) {
        // What is in device memory is not known, and contexts that ran out of it may be of no use.
        impl.hasFilm = false;
        impl.Discard();
        impl.device.reset();
        throw;
    }
}

std::vector<ImageLayer> Session::Layers(bool withFirstHits) const {
    if (!_impl->hasFilm) {
        throw Error("nothing has been rendered yet");
    }
    std::vector<ImageLayer> layers = _impl->tracer->Layers(withFirstHits);
    if (!_impl->denoisedAovs.empty()) {
        if (withFirstHits) {
            DenoiseColor(*_impl->denoiser, &layers);
        }
        // Without the guides that were added.
        layers.resize(MakeAovLayout(_impl->denoisedAovs).slots.size());
    }
    if (_impl->isOpaque) {
        FillAlpha(&layers);
    }
    return layers;
}

DeepImage Session::Deep() const {
    if (!_impl->hasFilm) {
        throw Error("nothing has been rendered yet");
    }
    DeepImage image = _impl->tracer->Deep();
    if (image.counts.empty()) {
        throw Error("the render has no deep picture: its settings ask for none");
    }
    return image;
}

FilmSums Session::Film() const {
    if (!_impl->hasFilm) {
        throw Error("nothing has been rendered yet");
    }
    return _impl->tracer->Film();
}

bool Session::HasImage() const {
    return _impl->hasFilm;
}

void Session::FlushTextures() {
    _impl->cache.images.Clear();
    _impl->cache.materials.clear();
    _impl->cache.lightKey = {};
    _impl->cache.lights.reset();
    _impl->edits.Count();
}

std::string Session::Statistics() const {
    if (!_impl->hasFilm) {
        throw Error("nothing has been rendered yet");
    }
    StatisticsInput input = _impl->statistics;
    input.warnings = _impl->warnings.Lines();
    if (input.warnings.size() > kMaxWarnings) {
        const std::size_t numMore = input.warnings.size() - kMaxWarnings;
        input.warnings.resize(kMaxWarnings);
        input.warnings.push_back("and " + std::to_string(numMore) + " more warnings");
    }
    return MakeStatistics(input);
}

void Session::SetFrontEndTimes(double loadSeconds, double translateSeconds,
                               double sinceStartSeconds) {
    _impl->statistics.loadSeconds = loadSeconds;
    _impl->statistics.translateSeconds = translateSeconds;
    _impl->sinceStartSeconds = sinceStartSeconds;
}

} // namespace hds
