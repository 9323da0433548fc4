// SPDX-License-Identifier: Apache-2.0
#include "hdStream/integrator/flatGeometry.h"

#include "hdStream/base/timer.h"

#include <algorithm>
#include <deque>
#include <limits>

namespace hds {

namespace {

/// Numbers of items have 32 bits.
constexpr std::uint64_t kMaxTriangles = 1U << 29U;

/// Where the host finds the geometry pages of a pool.
class PageViews {
public:
    PageViews(const CommittedScene& scene, const PagePool& pool)
        : _addresses(scene.pages->NumPages()) {
        pool.Addresses().Read(_addresses.data(), _addresses.size() * sizeof(_addresses[0]));
        for (std::uint32_t i = 0; i < pool.NumBuffers(); ++i) {
            _buffers.emplace_back(pool.PoolBuffer(i));
        }
    }

    const std::uint8_t* Page(std::uint32_t chunk) const {
        const std::uint32_t address = _addresses[2 * chunk + HDS_PAGE_GEOMETRY];
        const std::uint32_t unit = address & ((1U << HDS_POOL_BUFFER_SHIFT) - 1U);
        return _buffers[address >> HDS_POOL_BUFFER_SHIFT].Data() +
               std::uint64_t{unit} * HDS_POOL_UNIT_BYTES;
    }

private:
    std::vector<std::uint32_t> _addresses;
    std::deque<BufferView> _buffers;
};

} // namespace

std::uint64_t MaxFlatTriangles(const FlatLimits& limits) {
    const std::uint64_t affordable = std::min(limits.bytes / kFlatBytesATriangle, kMaxTriangles);
    return limits.isForced ? affordable
                           : std::min(affordable, limits.cameraRays / limits.raysATriangle);
}

bool FlatGeometry::Build(const std::shared_ptr<Device>& device, const CommittedScene& scene,
                         const PagePool& pool, const FlatLimits& limits) {
    FlatAmount amount;
    amount.maxTriangles = MaxFlatTriangles(limits);
    amount.maxBytes = static_cast<double>(limits.bytes);
    if (limits.isForced) {
        amount.maxCopies = std::numeric_limits<double>::infinity();
        amount.minShare = 0.0;
    }
    if (IsThere() || amount.maxTriangles == 0 || scene.pages->NumChunks() == 0) {
        return IsThere();
    }
    const Timer timer;
    const PageViews pages(scene, pool);
    FlatSource source;
    source.topNodes = scene.topNodes.data();
    source.instances = scene.instances.data();
    source.objects = &scene.objects;
    source.page = [&](std::uint32_t chunk) { return pages.Page(chunk); };
    source.hasInstanceChunks = scene.hasInstanceChunks;
    _flat = BuildFlatBvh(source, amount);
    if (!IsThere()) {
        _flat = {}; // of instances alone it would be no better than the TLAS
    } else {
        const std::string label = "flat hierarchy";
        const std::uint64_t bytes = _flat.buffer.size();
        if (device->Properties().isCpu && bytes >= kMinHugePageBytes) {
            _buffer = Buffer::OfHostMemory(device, label, _flat.buffer.data(), bytes,
                                           HostMemoryCount::AsDeviceMemory);
        } else {
            _buffer = Buffer(device, label, bytes, BufferAccess::ReadOnly);
            _buffer.Write(_flat.buffer.data(), bytes);
            _flat.buffer = {};
        }
    }
    _seconds = timer.Seconds();
    return IsThere();
}

void FlatGeometry::Clear() {
    _buffer = Buffer(); // frees first: it may be the memory of the other
    _flat = {};
    _seconds = 0.0;
}

} // namespace hds
