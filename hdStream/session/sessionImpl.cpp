// SPDX-License-Identifier: Apache-2.0
#include "hdStream/session/sessionImpl.h"

#include "hdStream/base/machine.h"
#include "hdStream/device/kernelCompilers.h"
#include "hdStream/geometry/subdivSource.h"
#include "hdStream/integrator/sceneFeatures.h"
#include "hdStream/persist/stagePages.h"
#include "hdStream/session/frontEndArrays.h"
#include "hdStream/session/hostShares.h"
#include "hdStream/texture/texturePool.h"

#include <algorithm>
#include <chrono>
#include <utility>

namespace hds {

namespace {

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

/// Whether the camera decides how surfaces are diced.
bool IsDicedByCamera(const SceneDescription& scene, const CommitOptions& options) {
    return options.subdivision == Subdivision::Adaptive &&
           std::any_of(scene.geometry.begin(), scene.geometry.end(), [](const auto& entry) {
               const auto& geometry = entry.second.geometry;
               return geometry && IsSubdivisionScheme(geometry->subdivisionScheme);
           });
}

/// Textures of which all lines are made between two questions whether to go on.
constexpr std::uint32_t kTexturesAtOnce = 16;

} // namespace

void Session::Impl::ReadyDevice(const Settings& settings) {
    if (!device || deviceName != settings.device) {
        Discard();
        device.reset(); // frees its memory first
        device = Device::Reuse(settings.device);
        deviceName = settings.device;
    }
    ReadyStore(settings);
    if (device->Compilers() == nullptr && device->Properties().hasSlowBinaries) {
        ReadyCompilers();
    }
}

void Session::Impl::ReadyStore(const Settings& settings) {
    if (!store || cacheDirectory != settings.cacheDirectory || noCache != settings.noCache) {
        Discard(); // the tracer holds the store
        if (device) {
            device->SetCompilers(nullptr); // they write to the store
        }
        store = std::make_unique<Store>(StoreOptions{settings.cacheDirectory, !settings.noCache},
                                        &warnings);
        cacheDirectory = settings.cacheDirectory;
        noCache = settings.noCache;
        hasCaches = false;
    }
}

void Session::Impl::ReadyCaches(const Settings& settings) {
    if (!std::exchange(hasCaches, true)) {
        cache.prims.reset();
        cache.pages.Clear();
        pageStore = noCache
                        ? nullptr
                        : std::make_shared<PageStore>(PageStoreOptions{cacheDirectory}, &warnings);
        notedPages = 0;
        cache.geometry.SetPageStore(pageStore);
        cache.images.SetPageStore(pageStore);
        cache.textures = std::make_shared<TexturePreparer>(
            pageStore, &warnings, HostBytes(settings) / kKeptImagesDivisor);
        cache.grids = std::make_shared<GridPreparer>(pageStore, &warnings);
    }
}

void Session::Impl::ReadyCompilers() {
    auto compilers =
        std::make_unique<KernelCompilers>(device->Properties(), store.get(), &warnings);
    const ProgramSource anyScenes = TexturePool::KernelSource(*device);
    if (compilers->CanCompile() && !Program::IsInStore(anyScenes, *store)) {
        compilers->Begin({anyScenes});
        compilers->Warm();
    }
    device->SetCompilers(std::move(compilers));
}

void Session::Impl::Warm(const Settings& settings) {
    ReadyDevice(settings);
    ReadyTracer();
    tracer->WarmKernels(); // takes longer than the rest
    ReadyCaches(settings);
}

void Session::Impl::ReadyTracer() {
    if (!tracer) {
        tracer = std::make_unique<PathTracer>(device, store.get());
    }
}

void Session::Impl::Discard() {
    tracer.reset();
    scene.reset();
    committed.reset();
}

void Session::Impl::LoseDevice() {
    Discard();
    if (device) {
        device->LeaveNothing();
    }
    device.reset();
}

void Session::Impl::ShareHostMemory(const Settings& settings) {
    statistics.sceneBytes = sizes.DescribedBytes() + cache.geometry.Bytes();
    const HostShares shares =
        hds::ShareHostMemory(HostBytes(settings), statistics.sceneBytes + arrayBlockBytes);
    cache.pages.SetLimit(shares.pages);
    cache.geometry.Sources().SetLimit(shares.sources);
}

bool Session::Impl::NoteGrowth() {
    const std::uint64_t before = std::exchange(notedBytes, statistics.sceneBytes);
    return statistics.sceneBytes >= before + kLargeScene;
}

bool Session::Impl::MaySeeMended(const Settings& settings) {
    return settings.interactive && settings.traversal != "flat";
}

PrimCommit::Reshaped Session::Impl::MendCommit(const Settings& settings, const CommitKey& key,
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

CommitOptions Session::Impl::OptionsOfCommit(const Settings& settings,
                                             const RenderOptions& options) const {
    CommitOptions commitOptions = MakeCommitOptions(settings);
    commitOptions.dicingCamera = dicingCamera;
    commitOptions.shutter = options.shutter;
    return commitOptions;
}

std::unique_ptr<CommittedScene> Session::Impl::MakeScene(const Settings& settings,
                                                         const CommitOptions& commitOptions,
                                                         const CancelCallback& isCancelled) {
    ShareHostMemory(settings);
    const bool isMuchNew = NoteGrowth();
    if (isMuchNew) {
        ReturnFreeMemory();
    }
    cache.contentVersion = settings.interactive ? edits.Content() : 0;
    auto made = CommitScene(description, commitOptions, &cache, warnings, isCancelled);
    if (!made) {
        return nullptr;
    }
    ShareHostMemory(settings);
    if (isMuchNew) {
        ReturnFreeMemory();
    }
    return made;
}

bool Session::Impl::Commit(const Settings& settings, const RenderOptions& options,
                           const CancelCallback& isCancelled) {
    const CommitOptions commitOptions = OptionsOfCommit(settings, options);
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
    auto next = MakeScene(settings, commitOptions, isCancelled);
    if (!next) {
        return false;
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

void Session::Impl::ReadyDenoiser(const Settings& settings) {
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

void Session::Impl::BeginStatistics() {
    statistics.commitSeconds = 0.0;
    statistics.primsMended = 0;
    cache.pages.BeginStatistics();
    cache.geometry.Sources().BeginStatistics();
    cache.geometry.ForgetPlanned();
    chunksMade = {};
    texturesMade = {};
    statistics.arrayBytesReadBefore = ArraySource::Counts().readBytes;
    if (device) {
        device->BeginPeak();
    }
    if (tracer) {
        tracer->BeginStatistics();
    }
}

const CameraPrim& Session::Impl::CameraOf(const Settings& settings) const {
    const auto camera = description.cameras.find(settings.camera);
    if (camera == description.cameras.end()) {
        throw Error("--camera " + settings.camera + ": the stage has no such camera",
                    ErrorKind::Usage);
    }
    return camera->second;
}

CancelCallback Session::Impl::Reporting(const Settings& settings,
                                        const ProgressCallback& onProgress) {
    return [this, &settings, &onProgress] {
        Progress progress;
        progress.samplesTotal = settings.samples;
        progress.prims = cache.geometry.Planned();
        progress.chunks = chunksMade;
        progress.textures = texturesMade;
        return onProgress && !onProgress(progress);
    };
}

void Session::Impl::ReadyDicing(const Settings& settings, const RenderOptions& options) {
    const bool isOfKind = dicingCamera && dicingCamera->isStill != settings.cameraMoves;
    if (isOfKind &&
        (settings.cameraMoves || !IsDicedByCamera(description, MakeCommitOptions(settings)))) {
        return; // Another camera would be another commit.
    }
    dicingCamera = MakeDicingCamera(options);
    dicingCamera->isStill = !settings.cameraMoves;
}

RenderResult Session::Impl::Prepare(const Settings& settings, const CameraPrim& camera,
                                    const ProgressCallback& onProgress, PreparedAmount* amount) {
    ReadyStore(settings);
    ReadyCaches(settings);
    if (!pageStore || !pageStore->IsWriting()) {
        throw Error(settings.noCache ? "--noCache: nothing can be prepared without the cache"
                                     : "the cache cannot be written: " + store->Directory(),
                    settings.noCache ? ErrorKind::Usage : ErrorKind::Failure);
    }
    BeginStatistics();
    Discard(); // as much memory for pages as there is
    const CancelCallback isCancelled = Reporting(settings, onProgress);
    const RenderOptions options = MakeRenderOptions(settings, camera);
    ReadyDicing(settings, options);
    const std::uint64_t builtBefore = cache.textures->NumBuilt();
    const std::uint64_t notKeptBefore = pageStore->Statistics().pagesNotKept;
    const auto made = MakeScene(settings, OptionsOfCommit(settings, options), isCancelled);
    if (!made) {
        return RenderResult::Stopped;
    }
    const GeometryPages& pages = *made->pages;
    const auto mustStop = [&] {
        if (pageStore->Statistics().pagesNotKept > notKeptBefore) {
            throw Error((pageStore->IsWriting() ? "the cache has no room for all pages: "
                                                : "the cache cannot be written: ") +
                        store->Directory());
        }
        return isCancelled();
    };
    if (!made->pages->PrepareAll(mustStop, &chunksMade, pages.NumInstanceChunks())) {
        return RenderResult::Stopped;
    }
    const std::uint32_t numTextures = made->textureLines->NumTextures();
    for (std::uint32_t begin = 0; begin < numTextures; begin += kTexturesAtOnce) {
        const std::uint32_t end = std::min(numTextures, begin + kTexturesAtOnce);
        texturesMade = {begin, numTextures};
        if (mustStop()) {
            return RenderResult::Stopped;
        }
        made->textureLines->MakeAll(begin, end);
    }
    if (mustStop()) {
        return RenderResult::Stopped;
    }
    amount->chunks = pages.NumChunks() - pages.NumInstanceChunks();
    amount->chunksBuilt = cache.pages.NumBuilt();
    for (std::uint32_t page = pages.NumOuterPages(); page < pages.NumPages(); ++page) {
        amount->chunkBytes += pages.PageBytes(page);
    }
    amount->textures = numTextures;
    amount->texturesBuilt = cache.textures->NumBuilt() - builtBefore;
    return RenderResult::Complete;
}

void Session::Impl::NotePages() {
    if (!pageStore || stageFile.empty() || pageStore->NumUsed() == notedPages) {
        return;
    }
    notedPages = pageStore->NumUsed();
    Store notes({store->Directory()},
                nullptr); // of a folder that is read only, say, kernels are read on
    NoteStagePages(stageFile, *pageStore, &notes);
}

RenderResult Session::Impl::Render(const Settings& settings, const CameraPrim& camera,
                                   const ProgressCallback& onProgress,
                                   const std::vector<FilmSums>& film, const RenderWatch& watch) {
    const auto start = std::chrono::steady_clock::now();
    ReadyDevice(settings);
    ReadyCaches(settings);
    ReadyDenoiser(settings);
    isOpaque = settings.opaqueBackground;
    BeginStatistics();
    const CancelCallback isCancelled = Reporting(settings, onProgress);
    RenderOptions options = MakeRenderOptions(settings, camera);
    if (!denoisedAovs.empty()) {
        options.aovs = MakeAovLayout(WithDenoiserGuides(denoisedAovs));
    }
    ReadyDicing(settings, options);
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

} // namespace hds
