// SPDX-License-Identifier: Apache-2.0
// The flat hierarchy of a scene whose pages are all in a pool: when it is worth its time and
// memory, and where it lies on the device. Explained in docs/accel.md.
#pragma once

#include "hdStream/accel/flatBvh.h"
#include "hdStream/device/device.h"
#include "hdStream/scene/commit.h"
#include "hdStream/stream/pagePool.h"

#include <cstdint>
#include <memory>

namespace hds {

/// Camera rays a triangle: docs/accel.md, "The flat hierarchy".
constexpr std::uint64_t kFlatRaysATriangleCpu = 3;
constexpr std::uint64_t kFlatRaysATriangleGpu = 100;

/// What a flat hierarchy may be.
struct FlatLimits {
    std::uint64_t cameraRays = 0; ///< that are still to be traced
    /// From which building pays: it is work of the host's cores, however fast the device is.
    std::uint64_t raysATriangle = kFlatRaysATriangleCpu;
    std::uint64_t bytes = 0; ///< of device memory
    bool isForced = false;   ///< whatever it costs
};

/// Triangles that are worth flattening: what rays save must pay for building.
std::uint64_t MaxFlatTriangles(const FlatLimits& limits);

/// Externally synchronised.
class FlatGeometry {
public:
    /// Builds it, unless it is there. Blocks. \pre all geometry pages of the scene are in the pool.
    /// \return whether it is there.
    bool Build(const std::shared_ptr<Device>& device, const CommittedScene& scene,
               const PagePool& pool, const FlatLimits& limits);
    /// Frees it; it is of another scene.
    void Clear();

    bool IsThere() const { return _flat.numTriangles > 0; }
    bool HasInstances() const { return _flat.hasInstances; }
    /// Placements of meshes that have trees of their own.
    std::uint64_t NumCopies() const { return _flat.numCopies; }
    std::uint64_t NumTriangles() const { return _flat.numTriangles; }
    std::uint64_t Bytes() const { return _buffer.Bytes(); }
    /// Of the last Build that built; 0 after Clear.
    double BuildSeconds() const { return _seconds; }
    /// HDS_FLAT_ARGS. \pre IsThere.
    const Buffer& DeviceBuffer() const { return _buffer; }

private:
    FlatBvh _flat; ///< CPU devices read it in place
    Buffer _buffer;
    double _seconds = 0.0;
};

} // namespace hds
