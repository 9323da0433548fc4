// SPDX-License-Identifier: Apache-2.0
#include "hdStream/integrator/sceneBuffers.h"

namespace hds {

SceneBuffers::SceneBuffers(const std::shared_ptr<Device>& device, const CommittedScene& scene)
    : _pool(device, "geometry", *scene.pages) {
    const auto table = [&](const char* label, const auto& values) {
        return Table(device, label, values.data(), values.size() * sizeof(values[0]));
    };
    _topNodes = table("top nodes", scene.topNodes);
    _instances = table("instances", scene.instances);
    _instancesByPath = table("instances by path", scene.instancesByPath);
    _objects = table("objects", scene.objects);
    _chunks = table("chunks", scene.chunks);
    _meshes = table("meshes", scene.meshes);
    _meshMaterials = table("mesh materials", scene.meshMaterials);
    _materials = table("materials", scene.materials);
    _lightByEntry = table("lights by material entry", scene.lightByEntry);
    _lights = table("lights", scene.lights.lights);
    _lightNodes = table("light tree", scene.lights.nodes);
    _lightTriangles = table("light triangles", scene.lights.triangles);
    _lightCdf = table("light distributions", scene.lights.cdf);
    _domeTexels = table("dome texels", scene.lights.domeTexels);
    _numLights = static_cast<std::uint32_t>(scene.lights.lights.size());
    _tableBytes += _pool.Addresses().Bytes();
}

Buffer SceneBuffers::Table(const std::shared_ptr<Device>& device, const char* label,
                           const void* data, std::size_t bytes) {
    Buffer buffer(device, label, bytes, BufferAccess::ReadOnly);
    if (bytes > 0) {
        buffer.Write(data, bytes);
    }
    _tableBytes += buffer.Bytes();
    return buffer;
}

unsigned SceneBuffers::BindGeometry(Kernel* kernel, unsigned first) const {
    for (const Buffer* buffer :
         {&_topNodes, &_instances, &_objects, &_chunks, &_pool.Addresses()}) {
        kernel->SetBuffer(first++, *buffer);
    }
    for (std::uint32_t i = 0; i < kMaxPoolBuffers; ++i) {
        kernel->SetBuffer(first++, _pool.PoolBuffer(i));
    }
    return first;
}

unsigned SceneBuffers::BindScene(Kernel* kernel, unsigned first) const {
    first = BindGeometry(kernel, first);
    for (const Buffer* buffer :
         {&_instancesByPath, &_meshes, &_meshMaterials, &_materials, &_lightByEntry, &_lights,
          &_lightNodes, &_lightTriangles, &_lightCdf, &_domeTexels}) {
        kernel->SetBuffer(first++, *buffer);
    }
    kernel->SetBytes(first++, &_numLights, sizeof(_numLights));
    return first;
}

} // namespace hds
