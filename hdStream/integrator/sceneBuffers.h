// SPDX-License-Identifier: Apache-2.0
// A committed scene in device memory, and its place in the kernels' signatures.
#pragma once

#include "hdStream/device/program.h"
#include "hdStream/scene/commit.h"
#include "hdStream/stream/residentPool.h"

#include <memory>

namespace hds {

/// Buffers of all scene tables. Externally synchronised.
class SceneBuffers {
public:
    /// Uploads everything. Blocks. \throws Error when it does not fit.
    SceneBuffers(const std::shared_ptr<Device>& device, const CommittedScene& scene);

    /// Sets the arguments of HDS_GEOMETRY_ARGS from `first` on; returns the next free index.
    unsigned BindGeometry(Kernel* kernel, unsigned first) const;

    /// Sets the arguments of HDS_SCENE_ARGS (geometry, materials, lights) from `first` on.
    unsigned BindScene(Kernel* kernel, unsigned first) const;

    const ResidentPool& Pool() const { return _pool; }
    std::uint64_t TableBytes() const { return _tableBytes; }

private:
    Buffer Table(const std::shared_ptr<Device>& device, const char* label, const void* data,
                 std::size_t bytes);

    std::uint64_t _tableBytes = 0;
    ResidentPool _pool;
    Buffer _topNodes;
    Buffer _instances;
    Buffer _instancesByPath;
    Buffer _objects;
    Buffer _chunks;
    Buffer _meshes;
    Buffer _meshMaterials;
    Buffer _materials;
    Buffer _lightByEntry;
    Buffer _lights;
    Buffer _lightNodes;
    Buffer _lightTriangles;
    Buffer _lightCdf;
    Buffer _domeTexels;
    std::uint32_t _numLights = 0;
};

} // namespace hds
