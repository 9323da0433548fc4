// SPDX-License-Identifier: Apache-2.0
#include "hdStream/session/session.h"

#include "hdStream/integrator/pathTracer.h"
#include "hdStream/scene/dump.h"
#include "hdStream/session/settingsCheck.h"
#include "hdStream/session/statistics.h"

#include <chrono>
#include <utility>

namespace hds {

namespace {

double SecondsSince(std::chrono::steady_clock::time_point start) {
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

void CheckRendered(const PathTracer* tracer) {
    if (tracer == nullptr) {
        throw Error("nothing has been rendered yet");
    }
}

} // namespace

std::vector<DeviceInfo> ListDevices() {
    return ListDeviceProperties();
}

CacheState InspectCache(const std::string& directory) {
    const Store store({directory, true}, nullptr);
    return {store.Directory(), store.Size()};
}

std::uint64_t ClearCache(const std::string& directory) {
    return Store({directory, true}, nullptr).Clear();
}

struct Session::Impl {
    explicit Impl(WarningSink onWarning) : warnings(std::move(onWarning)) {}

    hds::Warnings warnings;
    SceneDescription description;
    std::shared_ptr<Device> device;
    std::string deviceName; ///< what `device` was asked for by
    std::unique_ptr<Store> store;
    std::unique_ptr<CommittedScene> scene;
    std::unique_ptr<PathTracer> tracer;
    StatisticsInput statistics;
    double sinceStartSeconds = 0.0;
};

Session::Session(WarningSink onWarning) : _impl(std::make_unique<Impl>(std::move(onWarning))) {}

Session::~Session() = default;

void Session::SetMesh(const std::string& path, MeshPrim prim) {
    _impl->description.meshes[path] = std::move(prim);
}

void Session::SetInstancer(const std::string& path, InstancerPrim prim) {
    _impl->description.instancers[path] = std::move(prim);
}

void Session::SetLight(const std::string& path, LightPrim prim) {
    _impl->description.lights[path] = std::move(prim);
}

void Session::SetMaterial(const std::string& path, MaterialNetwork network) {
    _impl->description.materials[path] = std::move(network);
}

void Session::SetCamera(const std::string& path, CameraPrim prim) {
    _impl->description.cameras[path] = std::move(prim);
}

void Session::SetStage(double metersPerUnit, const std::string& upAxis) {
    _impl->description.metersPerUnit = metersPerUnit;
    _impl->description.upAxis = upAxis;
}

void Session::Remove(const std::string& path) {
    SceneDescription& scene = _impl->description;
    scene.meshes.erase(path);
    scene.instancers.erase(path);
    scene.lights.erase(path);
    scene.materials.erase(path);
    scene.cameras.erase(path);
}

void Session::Clear() {
    _impl->description = {};
    _impl->warnings.Clear();
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
    const auto scene =
        CommitScene(_impl->description, MakeCommitOptions(Settings()), _impl->warnings);
    return MakeInfo(_impl->description, *scene, _impl->warnings.Lines());
}

RenderResult Session::Render(const Settings& settings, const ProgressCallback& onProgress) {
    Impl& impl = *_impl;
    const auto start = std::chrono::steady_clock::now();
    CheckSettings(settings);
    const auto camera = impl.description.cameras.find(settings.camera);
    if (camera == impl.description.cameras.end()) {
        throw Error("--camera " + settings.camera + ": the stage has no such camera",
                    ErrorKind::Usage);
    }
    RenderOptions options = MakeRenderOptions(settings, camera->second);

    impl.tracer.reset(); // frees the device memory of the last render first
    impl.scene.reset();
    if (!impl.device || impl.deviceName != settings.device) {
        impl.device = Device::Create(settings.device);
        impl.deviceName = settings.device;
    }
    impl.store = std::make_unique<Store>(StoreOptions{settings.cacheDirectory, !settings.noCache},
                                         &impl.warnings);
    impl.scene = CommitScene(impl.description, MakeCommitOptions(settings), impl.warnings);
    impl.tracer = std::make_unique<PathTracer>(impl.device, impl.store.get(), *impl.scene,
                                               std::move(options));
    const double beforeRendering = SecondsSince(start);
    const RenderResult result = impl.tracer->Render(onProgress);

    const RenderStatistics& rendered = impl.tracer->Statistics();
    if (rendered.endedPasses > 0) {
        impl.warnings.Add(
            "", std::to_string(rendered.endedPasses) +
                    " rays ended after passing the most cut-out surfaces that one ray may pass");
    }
    StatisticsInput& statistics = impl.statistics;
    statistics.device = impl.device.get();
    statistics.scene = impl.scene.get();
    statistics.render = &rendered;
    statistics.imageWidth = settings.imageWidth;
    statistics.imageHeight = settings.imageHeight;
    statistics.poolBytes = impl.tracer->PoolBytes();
    statistics.tableBytes = impl.tracer->TableBytes();
    statistics.firstPixelSeconds =
        impl.sinceStartSeconds + beforeRendering + rendered.firstImageSeconds;
    statistics.totalSeconds = impl.sinceStartSeconds + SecondsSince(start);
    return result;
}

std::vector<ImageLayer> Session::Layers() const {
    CheckRendered(_impl->tracer.get());
    return _impl->tracer->Layers();
}

std::string Session::Statistics() const {
    CheckRendered(_impl->tracer.get());
    StatisticsInput input = _impl->statistics;
    input.warnings = _impl->warnings.Lines();
    return MakeStatistics(input);
}

void Session::SetFrontEndTimes(double loadSeconds, double translateSeconds,
                               double sinceStartSeconds) {
    _impl->statistics.loadSeconds = loadSeconds;
    _impl->statistics.translateSeconds = translateSeconds;
    _impl->sinceStartSeconds = sinceStartSeconds;
}

} // namespace hds
