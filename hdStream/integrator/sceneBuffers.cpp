// SPDX-License-Identifier: Apache-2.0
#include "hdStream/integrator/sceneBuffers.h"

#include "hdStream/base/error.h"

#include <utility>

namespace hds {

namespace {

const char* const kLabels[] = {"top nodes",
                               "instances",
                               "instances by path",
                               "objects",
                               "chunks",
                               "meshes",
                               "mesh materials",
                               "materials",
                               "lights by material entry",
                               "lights",
                               "light tree",
                               "light triangles",
                               "light distributions",
                               "dome texels"};

/// A table that has become smaller than this part of its buffer gets a smaller one.
constexpr std::uint64_t kShrinkFactor = 4;
constexpr std::uint64_t kSmallBytes = 64U << 10U;

} // namespace

SceneBuffers::SceneBuffers(std::shared_ptr<Device> device)
    : _device(std::move(device)), _pool(_device, "geometry") {
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

bool SceneBuffers::Update(const CommittedScene& scene) {
    const bool isFirst = _pool.NumBuffers() == 0;
    if (!_pool.Update(*scene.pages)) {
        if (isFirst) {
            throw Error("geometry: " + std::to_string(scene.counts.pageBytes) +
                        " bytes do not fit the device's memory (" +
                        std::to_string(kMaxPoolBuffers) + " buffers of " +
                        std::to_string(_pool.BufferLimit()) + " bytes)");
        }
        return false;
    }
    Upload(TopNodes, scene.topNodes);
    Upload(Instances, scene.instances);
    Upload(InstancesByPath, scene.instancesByPath);
    Upload(Objects, scene.objects);
    Upload(Chunks, scene.chunks);
    Upload(Meshes, scene.meshes);
    Upload(MeshMaterials, scene.meshMaterials);
    Upload(Materials, scene.materials);
    Upload(LightByEntry, scene.lightByEntry);
    if (_lights != scene.lights) {
        Upload(Lights, scene.lights->lights);
        Upload(LightNodes, scene.lights->nodes);
        Upload(LightTriangles, scene.lights->triangles);
        Upload(LightCdf, scene.lights->cdf);
        Upload(DomeTexels, scene.lights->domeTexels);
        _lights = scene.lights;
        _numLights = static_cast<std::uint32_t>(scene.lights->lights.size());
    }
    return true;
}

std::uint64_t SceneBuffers::TableBytes() const {
    std::uint64_t bytes = _pool.Addresses().Bytes();
    for (const Buffer& buffer : _tables) {
        bytes += buffer.Bytes();
    }
    return bytes;
}

unsigned SceneBuffers::BindGeometry(Kernel* kernel, unsigned first) const {
    for (const Table table : {TopNodes, Instances, Objects, Chunks}) {
        kernel->SetBuffer(first++, _tables[table]);
    }
    kernel->SetBuffer(first++, _pool.Addresses());
    for (std::uint32_t i = 0; i < kMaxPoolBuffers; ++i) {
        kernel->SetBuffer(first++, _pool.PoolBuffer(i));
    }
    return first;
}

unsigned SceneBuffers::BindScene(Kernel* kernel, unsigned first) const {
    first = BindGeometry(kernel, first);
    for (const Table table : {InstancesByPath, Meshes, MeshMaterials, Materials, LightByEntry,
                              Lights, LightNodes, LightTriangles, LightCdf, DomeTexels}) {
        kernel->SetBuffer(first++, _tables[table]);
    }
    kernel->SetBytes(first++, &_numLights, sizeof(_numLights));
    return first;
}

} // namespace hds
