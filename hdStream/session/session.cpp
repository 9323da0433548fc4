// SPDX-License-Identifier: Apache-2.0
#include "hdStream/session/session.h"

#include "hdStream/device/poclCache.h"
#include "hdStream/scene/cameraNumbers.h"
#include "hdStream/scene/dump.h"
#include "hdStream/scene/transforms.h"
#include "hdStream/session/sessionImpl.h"

#include <exception>
#include <utility>

namespace hds {

namespace {

/// Lines in the statistics, which are made for every image that is shown.
constexpr std::size_t kMaxWarnings = 1000;

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
    SceneDescription& scene = _impl->description;
    const auto prim = scene.geometry.find(path);
    const auto volume = scene.volumes.find(path);
    if (prim == scene.geometry.end() && volume == scene.volumes.end()) {
        throw Error(path + ": there is no geometry");
    }
    (prim != scene.geometry.end() ? prim->second.categories : volume->second.categories) =
        std::move(categories);
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
        _impl->LoseDevice();
    }
}

void Session::SetStageFile(const std::string& file) {
    _impl->stageFile = file;
}

RenderResult Session::Prepare(const Settings& settings, const ProgressCallback& onProgress,
                              PreparedAmount* amount) {
    CheckSettings(settings);
    const CameraPrim& camera = _impl->CameraOf(settings);
    _impl->hasFilm = false;
    try {
        const RenderResult result = _impl->Prepare(settings, camera, onProgress, amount);
        _impl->NotePages();
        return result;
    } catch (...) { // what is kept is of this stage too
        _impl->NotePages();
        throw;
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
    const CameraPrim& camera = impl.CameraOf(settings);
    if (!IsUsableTransform(camera.worldFromCamera)) {
        Warn(settings.camera,
             "a camera whose transform is singular or not finite; the picture says "
             "nothing of the scene");
    }
    CameraPrim mended = camera;
    for (const std::string& problem : MendCamera(&mended)) {
        Warn(settings.camera, problem);
    }
    impl.hasFilm = false;
    try {
        const RenderResult result = impl.Render(settings, camera, onProgress, start, watch);
        if (!settings.interactive) {
            impl.NotePages();
        }
        return result;
    } catch (...) {
        impl.hasFilm = false;
        impl.LoseDevice();
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
