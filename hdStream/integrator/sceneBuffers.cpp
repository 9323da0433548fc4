// SPDX-License-Identifier: Apache-2.0
#include "hdStream/integrator/sceneBuffers.h"

#include "hdStream/base/error.h"
#include "hdStream/integrator/makeResident.h"
#include "hdStream/shading/domeGuide.h"
#include "hdStream/stream/mappedPool.h"
#include "hdStream/stream/residentPool.h"

#include <utility>

namespace hds {

namespace {

const char* const kLabels[] = {"top nodes",
                               "instances",
                               "instances by path",
                               "objects",
                               "prims",
                               "prim materials",
                               "materials",
                               "lights by material entry",
                               "lights",
                               "light tree",
                               "light triangles",
                               "light distributions",
                               "programs",
                               "motion keys",
                               "volumes",
                               "grids",
                               "grid tiles",
                               "grid cells",
                               "bounds of bricks",
                               "terms of volumes",
                               "first instance slots",
                               "instance slots",
                               "instance values",
                               "catchers alone",
                               "media of meshes"};

/// A table that has become smaller than this part of its buffer gets a smaller one.
constexpr std::uint64_t kShrinkFactor = 4;
constexpr std::uint64_t kSmallBytes = 64U << 10U;
/// Elements of a table that are uploaded one by one; of more all are.
constexpr std::size_t kMostParts = 16;
/// Of what is missing, loaded between two questions whether to go on.
constexpr std::uint64_t kBatchBytes = 64U << 20U;

} // namespace

SceneBuffers::SceneBuffers(std::shared_ptr<Device> device, Store* store)
    : _device(std::move(device)), _textures(_device, store) {
    static_assert(std::size(kLabels) == NumTables, "a label for each table");
}

template <typename T>
void SceneBuffers::Upload(Table table, const std::vector<T>& values) {
    Upload(table, values.data(), values.size() * sizeof(T));
}

template <typename T>
void SceneBuffers::Upload(Table table, const HugeVector<T>& values) {
    const std::uint64_t bytes = values.size() * sizeof(T);
    if (std::exchange(_isInPlace[table], false)) {
        _tables[table] = Buffer(); // it is another scene's memory
    }
    if (bytes < kMinHugePageBytes || !_device->Properties().isCpu) {
        Upload(table, values.data(), bytes);
        return;
    }
    _tables[table] = Buffer(); // frees first
    _tables[table] = Buffer::OfHostMemory(_device, kLabels[table], values.data(), bytes,
                                          HostMemoryCount::AsDeviceMemory);
    _isInPlace[table] = true;
}

/// Without a pool nobody asks what bricks may hold: all of them are there. Of colours, velocities
/// and fields of terms nobody does.
void SceneBuffers::UploadBrickBounds(const CommittedVolumes& volumes) {
    const PreparedGrids grids = _textures.Pool() != nullptr ? volumes.bounded : PreparedGrids();
    if (_tables[BrickBounds].IsValid() && grids == _boundedGrids) {
        return;
    }
    std::vector<shared::HdsBrickBounds> all;
    for (const auto& grid : grids) {
        const std::vector<shared::HdsBrickBounds>& own = grid->description.bounds;
        all.insert(all.end(), own.begin(), own.end());
    }
    _boundedGrids.clear(); // until they are there
    Upload(BrickBounds, all);
    _boundedGrids = grids;
}

void SceneBuffers::Upload(Table table, const void* values, std::uint64_t bytes) {
    Buffer& buffer = _tables[table];
    const bool isTooLarge = buffer.Bytes() > kSmallBytes && bytes < buffer.Bytes() / kShrinkFactor;
    if (!buffer.IsValid() || buffer.Bytes() < bytes || isTooLarge) {
        buffer = Buffer(); // frees first
        buffer = Buffer(_device, kLabels[table], bytes, BufferAccess::ReadOnly);
    }
    if (bytes > 0) {
        buffer.Write(values, bytes);
    }
}

ResidencyPlan SceneBuffers::Plan(const CommittedScene& scene,
                                 const ResidencyOptions& residency) const {
    return PlanResidency(residency, scene.pages->TotalBytes(), _device->Properties().memoryBytes);
}

/// Makes an empty pool for geometry.
void SceneBuffers::MakePool(PoolKind kind, const ResidencyOptions& residency) {
    _streaming = nullptr;
    _pool = nullptr; // frees first
    const std::string label = "geometry";
    if (kind == PoolKind::Mapped) {
        _pool = std::make_unique<MappedPool>(_device, label);
    } else if (kind == PoolKind::Resident) {
        _pool = std::make_unique<ResidentPool>(_device, label);
    } else {
        auto pool = MakeStreamingPool(_device, label, residency.eviction, residency.requestsFirst);
        pool->SetHashEntries(residency.pageEntries);
        _streaming = pool.get();
        _pool = std::move(pool);
    }
    _poolKind = kind;
    _residency = residency;
}

bool SceneBuffers::MayBecomeResident() const {
    const bool isReport = _residency.mode == ResidencyMode::Stream && _residency.requestsFirst;
    return IsStreaming() && !isReport && !_isScattered && _streaming->HasRoomForAll();
}

void SceneBuffers::LoadMissing() {
    if (!_streaming->LoadMissing(kBatchBytes)) {
        _isScattered = true;
    } else if (_streaming->MissingBytes() == 0) {
        _streaming->CountUsed(); // kernels keep no account from here on
        // Who asks for streaming may ask for another pool next: prepared pages stay as they do
        // while geometry streams.
        _streaming->MakeResident(_residency.mode == ResidencyMode::Stream);
        _isFullyResident = true;
    }
}

/// Whether the pool is as an update for the scene would leave it.
bool SceneBuffers::ServesPages(const CommittedScene& scene, const ResidencyPlan& plan,
                               const ResidencyOptions& residency) const {
    return _pool && _pages == scene.pages && plan.pool == _poolKind &&
           (plan.pool != PoolKind::Streaming ||
            (_residency == residency && _budgetBytes == plan.budgetBytes));
}

bool SceneBuffers::UpdatePages(const CommittedScene& scene, const ResidencyOptions& residency) {
    const ResidencyPlan plan = Plan(scene, residency);
    if (ServesPages(scene, plan, residency)) {
        return true;
    }
    _pages = nullptr;
    const bool streams = plan.pool == PoolKind::Streaming;
    const bool wasFullyResident = std::exchange(_isFullyResident, false) && streams;
    _isScattered = false;
    if (!_pool || plan.pool != _poolKind || (streams && !(_residency == residency))) {
        MakePool(plan.pool, residency);
    }
    if (!_pool->Update(scene.pages.get(), plan.budgetBytes)) {
        return false;
    }
    if (wasFullyResident && BecomesResidentAtOnce(_streaming->MissingBytes())) {
        while (MayBecomeResident()) {
            LoadMissing();
        }
    }
    _pages = scene.pages;
    _budgetBytes = plan.budgetBytes;
    return true;
}

bool SceneBuffers::Flatten(const CommittedScene& scene, const FlatLimits& limits) {
    return !_flat.IsThere() && _flat.Build(_device, scene, *_pool, limits);
}

bool SceneBuffers::Update(const CommittedScene& scene, const ResidencyOptions& residency) {
    _flat.Clear();
    if (!UpdatePages(scene, residency)) {
        return false;
    }
    Upload(TopNodes, scene.topNodes);
    Upload(Instances, scene.instances);
    Upload(CatchersAlone, scene.catchersAlone);
    Upload(InstancesByPath, scene.instancesByPath);
    Upload(Objects, scene.objects);
    Upload(Prims, scene.prims);
    Upload(PrimMaterials, scene.primMaterials);
    Upload(Materials, scene.materials);
    Upload(LightByEntry, scene.lightByEntry);
    Upload(Programs, scene.programs);
    Upload(MotionKeys, scene.motionKeys);
    Upload(Volumes, scene.volumes.volumes);
    Upload(Grids, scene.volumes.grids);
    Upload(GridTiles, scene.volumes.tiles);
    Upload(GridCells, scene.volumes.cells);
    Upload(VolumeTerms, scene.volumes.terms);
    Upload(MeshMedia, scene.meshMedia);
    _numVolumes = static_cast<std::uint32_t>(scene.volumes.volumes.size());
    _textures.Update(scene, residency);
    UploadBrickBounds(scene.volumes);
    _hasPrograms = !scene.programs.empty();
    _hasTextures = scene.lines->NumTextures() > 0;
    Upload(FirstInstanceSlots, scene.instancePrimvars.firstSlots);
    Upload(InstanceSlots, scene.instancePrimvars.slots);
    Upload(InstanceValues, scene.instancePrimvars.values);
    _hasInstancePrimvars = !scene.instancePrimvars.slots.empty();
    UploadLights(scene);
    return true;
}

void SceneBuffers::UploadLights(const CommittedScene& scene) {
    if (_lights != scene.lights) {
        _lights = nullptr; // until all are there
        Upload(Lights, scene.lights->lights);
        Upload(LightNodes, scene.lights->nodes);
        Upload(LightTriangles, scene.lights->triangles);
        Upload(LightCdf, scene.lights->cdf);
        _lights = scene.lights;
        _numLights = static_cast<std::uint32_t>(scene.lights->lights.size());
        _hasDomeGuide = false;
    }
}

/// CPU devices read tables in place where those of the scene are: there nothing is to be done.
template <typename Values>
void SceneBuffers::UploadParts(Table table, const Values& values,
                               const std::vector<std::uint32_t>& parts) {
    using T = typename Values::value_type;
    if (_isInPlace[table] || parts.empty()) {
        return;
    }
    if (parts.size() > kMostParts) {
        _tables[table].Write(values.data(), values.size() * sizeof(T));
        return;
    }
    for (const std::uint32_t part : parts) {
        _tables[table].Write(&values[part], sizeof(T), std::uint64_t{part} * sizeof(T));
    }
}

bool SceneBuffers::TakePlaces(const CommittedScene& scene, const PlaceChanges& changes,
                              const ResidencyOptions& residency) {
    _flat.Clear();
    if (changes.arePages && !UpdatePages(scene, residency)) {
        return false;
    }
    UploadLights(scene);
    UploadParts(Materials, scene.materials, changes.materials);
    UploadParts(TopNodes, scene.topNodes, changes.nodes);
    if (!changes.areOthers) {
        UploadParts(Instances, scene.instances, changes.instances);
        return true;
    }
    const auto upload = [this](Table table, const auto& values) {
        if (!_isInPlace[table]) {
            _tables[table].Write(values.data(), values.size() * sizeof(values[0]));
        }
    };
    upload(Instances, scene.instances);
    upload(InstancesByPath, scene.instancesByPath);
    upload(Objects, scene.objects);
    return true;
}

bool SceneBuffers::SetDomeGuide(const std::array<float, 3>& camera,
                                const std::vector<std::uint32_t>& cells) {
    const std::shared_ptr<const LightTable> table = _lights;
    if (!table) {
        return false;
    }
    const bool hadGuide = std::exchange(_hasDomeGuide, false);
    if (!hadGuide && cells.empty()) {
        return false;
    }
    std::vector<float> cdf = table->cdf;
    std::vector<shared::HdsLight> lights = table->lights;
    for (shared::HdsLight& light : lights) {
        if (cells.empty() || !MayHaveGuide(light)) {
            continue;
        }
        const auto base = static_cast<std::uint32_t>(cdf.size());
        const std::vector<float> guide =
            BuildDomeGuide(camera, cells, LightOfCells(light, table->cdf), base);
        if (!guide.empty()) {
            cdf.insert(cdf.end(), guide.begin(), guide.end());
            light.flags |= HDS_LIGHT_GUIDED;
            light.params[0] = shared::FloatOfBits(base);
            _hasDomeGuide = true;
        }
    }
    if (!hadGuide && !_hasDomeGuide) {
        return false;
    }
    _lights = nullptr; // until both are there
    Upload(LightCdf, cdf);
    Upload(Lights, lights);
    _lights = table;
    return true;
}

void SceneBuffers::BeginStatistics() {
    if (_pool) {
        _pool->BeginStatistics();
    }
    _textures.BeginStatistics();
}

void SceneBuffers::CountUsed() {
    if (IsStreaming()) {
        _streaming->CountUsed();
    }
}

StreamingStatistics SceneBuffers::PoolStatistics() const {
    return _pool ? _pool->Statistics() : StreamingStatistics{};
}

std::uint64_t SceneBuffers::TableBytes() const {
    return GeometryTableBytes() + _textures.TableBytes();
}

std::uint64_t SceneBuffers::GeometryTableBytes() const {
    std::uint64_t bytes = _pool ? _pool->TableBytes() : 0;
    for (const Buffer& buffer : _tables) {
        bytes += buffer.Bytes();
    }
    return bytes + _flat.Bytes();
}

unsigned SceneBuffers::BindGeometry(Kernel* kernel, unsigned first,
                                    const KernelFeatures& features) const {
    HDS_VERIFY(_pool != nullptr, "no geometry was taken before");
    for (const Table table :
         {TopNodes, _showsCatchersAlone ? CatchersAlone : Instances, InstancesByPath, Objects}) {
        kernel->SetBuffer(first++, _tables[table]);
    }
    kernel->SetBuffer(first++, _pool->Addresses());
    for (std::uint32_t i = 0; i < kMaxPoolBuffers; ++i) {
        kernel->SetBuffer(first++, _pool->PoolBuffer(i));
    }
    if (features.motion) {
        kernel->SetBuffer(first++, _tables[MotionKeys]);
    }
    if (features.flat) {
        kernel->SetBuffer(first++, _flat.DeviceBuffer());
    }
    if (features.streaming) {
        kernel->SetBuffer(first++, _streaming->Uses());
    }
    return first;
}

unsigned SceneBuffers::BindScene(Kernel* kernel, unsigned first,
                                 const KernelFeatures& features) const {
    first = BindGeometry(kernel, first, features);
    for (const Table table : {Prims, PrimMaterials, Materials, LightByEntry, Lights, LightNodes,
                              LightTriangles, LightCdf}) {
        kernel->SetBuffer(first++, _tables[table]);
    }
    kernel->SetBytes(first++, &_numLights, sizeof(_numLights));
    if (features.programs) {
        kernel->SetBuffer(first++, _tables[Programs]);
    }
    if (features.instancePrimvars) {
        for (const Table table : {FirstInstanceSlots, InstanceSlots, InstanceValues}) {
            kernel->SetBuffer(first++, _tables[table]);
        }
    }
    if (features.textures) {
        first = _textures.Bind(kernel, first, features.textureStreaming);
    }
    if (features.volumes) {
        for (const Table table : {Volumes, Grids, GridTiles, GridCells}) {
            kernel->SetBuffer(first++, _tables[table]);
        }
        if (features.textureStreaming) {
            kernel->SetBuffer(first++, _tables[BrickBounds]);
        }
        const std::uint32_t numSeen = _showsCatchersAlone ? 0 : _numVolumes;
        kernel->SetBytes(first++, &numSeen, sizeof(numSeen));
        if (features.volumeTerms) {
            kernel->SetBuffer(first++, _tables[VolumeTerms]);
        }
    }
    if (features.mediaStack) {
        kernel->SetBuffer(first++, _tables[MeshMedia]);
    }
    return first;
}

bool SceneBuffers::SetMipBias(float bias) {
    const bool isNew = bias != _textures.MipBias();
    _textures.SetMipBias(bias);
    return isNew;
}

} // namespace hds
