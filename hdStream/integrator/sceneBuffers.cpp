// SPDX-License-Identifier: Apache-2.0
#include "hdStream/integrator/sceneBuffers.h"

#include "hdStream/base/error.h"
#include "hdStream/integrator/settling.h"

#include <utility>

namespace hds {

namespace {

const char* const kLabels[] = {
    "top nodes", "instances",      "instances by path", "objects",
    "meshes",    "mesh materials", "materials",         "lights by material entry",
    "lights",    "light tree",     "light triangles",   "light distributions",
    "programs",  "motion keys"};

/// A table that has become smaller than this part of its buffer gets a smaller one.
constexpr std::uint64_t kShrinkFactor = 4;
constexpr std::uint64_t kSmallBytes = 64U << 10U;
/// Of what is missing, loaded between two questions whether to go on.
constexpr std::uint64_t kBatchBytes = 64U << 20U;

} // namespace

SceneBuffers::SceneBuffers(std::shared_ptr<Device> device, Store* store)
    : _device(std::move(device)), _textures(_device, store) {
    static_assert(std::size(kLabels) == NumTables, "a label for each table");
}

template <typename T>
void SceneBuffers::Upload(Table table, const std::vector<T>& values) {
    Buffer& buffer = _tables[table];
    const std::uint64_t bytes = values.size() * sizeof(T);
    const bool isTooLarge = buffer.Bytes() > kSmallBytes && bytes < buffer.Bytes() / kShrinkFactor;
    if (!buffer.IsValid() || buffer.Bytes() < bytes || isTooLarge) {
        buffer = Buffer(); // frees first
        buffer = Buffer(_device, kLabels[table], bytes, BufferAccess::ReadOnly);
    }
    if (bytes > 0) {
        buffer.Write(values.data(), bytes);
    }
}

ResidencyPlan SceneBuffers::Plan(const CommittedScene& scene,
                                 const ResidencyOptions& residency) const {
    return PlanResidency(residency, scene.pages->TotalBytes(), _device->Properties().memoryBytes);
}

void SceneBuffers::UpdateStreaming(const CommittedScene& scene, const ResidencyOptions& residency,
                                   std::uint64_t budget) {
    const bool wasSettled = std::exchange(_isSettled, false);
    _isScattered = false;
    if (!_streaming || !(_residency == residency)) {
        _streaming = nullptr; // frees first
        _streaming = std::make_unique<StreamingPool>(_device, "geometry", residency.eviction);
        _residency = residency;
    }
    _streaming->Update(scene.pages.get(), budget);
    if (wasSettled && SettlesAtOnce(_streaming->MissingBytes())) {
        while (MaySettle()) {
            LoadMissing();
        }
    }
}

bool SceneBuffers::MaySettle() const {
    return IsStreaming() && _residency.mode == ResidencyMode::Auto && !_isScattered &&
           _streaming->HasRoomForAll();
}

void SceneBuffers::LoadMissing() {
    if (!_streaming->LoadMissing(kBatchBytes)) {
        _isScattered = true;
    } else if (_streaming->MissingBytes() == 0) {
        _streaming->CountUsed(); // kernels keep no account from here on
        _streaming->Settle();
        _isSettled = true;
    }
}

bool SceneBuffers::UpdatePages(const CommittedScene& scene, const ResidencyOptions& residency) {
    const ResidencyPlan plan = Plan(scene, residency);
    if (plan.pool == PoolKind::Mapped) {
        UpdateMapped(scene);
        return true;
    }
    _mapped = nullptr;
    if (plan.pool == PoolKind::Streaming) {
        _resident = nullptr;
        UpdateStreaming(scene, residency, plan.budgetBytes);
        return true;
    }
    _streaming = nullptr;
    _isSettled = false;
    const bool isFirst = !_resident;
    if (isFirst) {
        _resident = std::make_unique<ResidentPool>(_device, "geometry");
    }
    if (_resident->Update(scene.pages.get())) {
        return true;
    }
    if (isFirst) {
        throw Error("geometry: " + std::to_string(scene.pages->TotalBytes()) +
                    " bytes do not fit the device's memory (" + std::to_string(kMaxPoolBuffers) +
                    " buffers of " + std::to_string(_resident->BufferLimit()) +
                    " bytes); --residency stream needs less");
    }
    return false;
}

void SceneBuffers::UpdateMapped(const CommittedScene& scene) {
    if (!_device->Properties().isCpu) {
        throw Error("--residency mapped: needs a CPU device, " + _device->Properties().name +
                    " is none");
    }
    _resident = nullptr;
    _streaming = nullptr;
    _isSettled = false;
    if (!_mapped) {
        _mapped = std::make_unique<MappedPool>(_device, "geometry");
    }
    _mapped->Update(scene.pages.get());
}

bool SceneBuffers::Update(const CommittedScene& scene, const ResidencyOptions& residency) {
    if (!UpdatePages(scene, residency)) {
        return false;
    }
    Upload(TopNodes, scene.topNodes);
    Upload(Instances, scene.instances);
    Upload(InstancesByPath, scene.instancesByPath);
    Upload(Objects, scene.objects);
    Upload(Meshes, scene.meshes);
    Upload(MeshMaterials, scene.meshMaterials);
    Upload(Materials, scene.materials);
    Upload(LightByEntry, scene.lightByEntry);
    Upload(Programs, scene.programs);
    Upload(MotionKeys, scene.motionKeys);
    _textures.Update(scene, residency);
    _hasPrograms = !scene.programs.empty();
    _hasTextures = !scene.textureTable.empty();
    if (_lights != scene.lights) {
        Upload(Lights, scene.lights->lights);
        Upload(LightNodes, scene.lights->nodes);
        Upload(LightTriangles, scene.lights->triangles);
        Upload(LightCdf, scene.lights->cdf);
        _lights = scene.lights;
        _numLights = static_cast<std::uint32_t>(scene.lights->lights.size());
    }
    return true;
}

std::uint32_t SceneBuffers::NumPoolBuffers() const {
    return _streaming  ? _streaming->NumBuffers()
           : _mapped   ? _mapped->NumBuffers()
           : _resident ? _resident->NumBuffers()
                       : 0;
}

std::uint64_t SceneBuffers::PoolBytes() const {
    return _streaming ? _streaming->Bytes() : _resident ? _resident->Bytes() : 0;
}

std::uint64_t SceneBuffers::PinnedBytes() const {
    return _streaming ? _streaming->PinnedBytes() : 0;
}

std::uint64_t SceneBuffers::PeakUsedBytes() const {
    return _streaming ? _streaming->PeakUsedBytes() : _resident ? _resident->PeakUsedBytes() : 0;
}

void SceneBuffers::BeginStatistics() {
    if (_streaming) {
        _streaming->BeginStatistics();
    }
    if (_resident) {
        _resident->BeginStatistics();
    }
    _textures.BeginStatistics();
}

void SceneBuffers::CountUsed() {
    if (IsStreaming()) {
        _streaming->CountUsed();
    }
}

StreamingStatistics SceneBuffers::PoolStatistics() const {
    StreamingStatistics statistics;
    if (_streaming) {
        statistics = _streaming->Statistics();
    } else if (_resident) {
        statistics.uploads = _resident->Uploads();
        statistics.uploadedBytes = _resident->UploadedBytes();
        statistics.uniqueBytes = statistics.uploadedBytes;
    }
    return statistics;
}

std::uint64_t SceneBuffers::TableBytes() const {
    std::uint64_t bytes = _streaming  ? _streaming->TableBytes()
                          : _mapped   ? _mapped->Addresses().Bytes()
                          : _resident ? _resident->Addresses().Bytes()
                                      : 0;
    for (const Buffer& buffer : _tables) {
        bytes += buffer.Bytes();
    }
    return bytes + _textures.TableBytes();
}

unsigned SceneBuffers::BindGeometry(Kernel* kernel, unsigned first, bool hasMotion) const {
    for (const Table table : {TopNodes, Instances, InstancesByPath, Objects}) {
        kernel->SetBuffer(first++, _tables[table]);
    }
    kernel->SetBuffer(first++, _streaming ? _streaming->Addresses()
                               : _mapped  ? _mapped->Addresses()
                                          : _resident->Addresses());
    for (std::uint32_t i = 0; i < kMaxPoolBuffers; ++i) {
        kernel->SetBuffer(first++, _streaming ? _streaming->PoolBuffer(i)
                                   : _mapped  ? _mapped->PoolBuffer(i)
                                              : _resident->PoolBuffer(i));
    }
    if (hasMotion) {
        kernel->SetBuffer(first++, _tables[MotionKeys]);
    }
    if (IsStreaming()) {
        kernel->SetBuffer(first++, _streaming->Uses());
    }
    return first;
}

unsigned SceneBuffers::BindScene(Kernel* kernel, unsigned first, bool hasMotion) const {
    first = BindGeometry(kernel, first, hasMotion);
    for (const Table table : {Meshes, MeshMaterials, Materials, LightByEntry, Lights, LightNodes,
                              LightTriangles, LightCdf}) {
        kernel->SetBuffer(first++, _tables[table]);
    }
    kernel->SetBytes(first++, &_numLights, sizeof(_numLights));
    if (_hasPrograms) {
        kernel->SetBuffer(first++, _tables[Programs]);
    }
    return _hasTextures ? _textures.Bind(kernel, first) : first;
}

bool SceneBuffers::SetMipBias(float bias) {
    const bool isNew = bias != _textures.MipBias();
    _textures.SetMipBias(bias);
    return isNew;
}

} // namespace hds
