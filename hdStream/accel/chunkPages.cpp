// SPDX-License-Identifier: Apache-2.0
#include "hdStream/accel/chunkPages.h"

#include "hdStream/accel/bvh.h"
#include "hdStream/geometry/attributePage.h"

#include <atomic>
#include <utility>

namespace hds {

namespace {

/// Bytes of a page that do not grow with its triangles: header and root; slot word and padding.
constexpr std::uint64_t kFixedBytes = 128;

std::uint64_t NextIds() {
    static std::atomic<std::uint64_t> next{1};
    return next.fetch_add(ChunkPages::kNumPages, std::memory_order_relaxed);
}

std::uint64_t RoundUp(std::uint64_t bytes) {
    return (bytes + HDS_POOL_UNIT_BYTES - 1) / HDS_POOL_UNIT_BYTES * HDS_POOL_UNIT_BYTES;
}

} // namespace

ChunkPages::ChunkPages(std::shared_ptr<const ChunkedMesh> mesh, std::uint32_t chunk)
    : _mesh(std::move(mesh)), _chunk(chunk), _firstId(NextIds()) {
    const std::uint64_t count = _mesh->plan.counts[chunk];
    const TriangleBytes& bytes = _mesh->source->BoundBytes();
    // Each block of attributes is padded.
    const std::uint64_t padding = kFixedBytes * (1 + _mesh->source->Attributes().size());
    _bytes[HDS_PAGE_GEOMETRY] = RoundUp(count * bytes.geometry + kFixedBytes);
    _bytes[HDS_PAGE_ATTRIBUTES] = RoundUp(count * bytes.attributes + padding);
}

void ChunkPages::Build() {
    const ChunkPlan& plan = _mesh->plan;
    ChunkGeometry chunk = _mesh->source->Gather(plan.units.data() + plan.begin[_chunk],
                                                plan.begin[_chunk + 1] - plan.begin[_chunk]);
    _data[HDS_PAGE_GEOMETRY] = BuildGeometryPage(chunk).bytes;
    _data[HDS_PAGE_ATTRIBUTES] = BuildAttributePage(chunk);
    for (std::uint32_t page = 0; page < kNumPages; ++page) {
        _bytes[page] = _data[page].size();
    }
    _isExact = true;
}

} // namespace hds
