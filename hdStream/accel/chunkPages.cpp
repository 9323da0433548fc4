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

ChunkPages::ChunkPages(std::shared_ptr<const ChunkedGeometry> geometry, std::uint32_t chunk)
    : _geometry(std::move(geometry)), _chunk(chunk), _firstId(NextIds()) {
    const GeometrySummary& summary = _geometry->Summary();
    const std::uint64_t count = summary.numInChunk[chunk];
    const TriangleBytes& bytes = summary.boundBytes;
    // Each block of attributes is padded.
    const std::uint64_t padding = kFixedBytes * (1 + summary.attributes.size());
    _bytes[HDS_PAGE_GEOMETRY] = RoundUp(count * bytes.geometry + kFixedBytes);
    _bytes[HDS_PAGE_ATTRIBUTES] = RoundUp(count * bytes.attributes + padding);
}

void ChunkPages::FindSizes() {
    if (!_geometry->Store() || _isExact) {
        return;
    }
    const auto geometry = _geometry->Store()->Bytes(KeyOf(HDS_PAGE_GEOMETRY));
    const auto attributes = _geometry->Store()->Bytes(KeyOf(HDS_PAGE_ATTRIBUTES));
    if (geometry && attributes) {
        _bytes = {*geometry, *attributes};
        _isExact = true;
    }
}

bool ChunkPages::Prepare(const std::array<bool, kNumPages>& isWanted) {
    if (Load(isWanted)) {
        return false;
    }
    Build();
    for (std::uint32_t page = 0; page < kNumPages && _geometry->Store(); ++page) {
        _geometry->Store()->Save(KeyOf(page), _data[page].data(), _data[page].size());
    }
    return true;
}

bool ChunkPages::Locate(std::uint32_t page, MappedPage* mapped) {
    if (!_geometry->Store()) {
        return false;
    }
    const auto location = _geometry->Store()->Locate(KeyOf(page));
    if (!location) {
        return false;
    }
    mapped->file = _geometry->Store()->SegmentData(location->segment);
    mapped->fileBytes = _geometry->Store()->SegmentBytes(location->segment);
    mapped->offset = location->offset;
    _bytes[page] = location->bytes;
    return mapped->file != nullptr;
}

/// \return whether all that is wanted is there now.
bool ChunkPages::Load(const std::array<bool, kNumPages>& isWanted) {
    FindSizes();
    for (std::uint32_t page = 0; page < kNumPages; ++page) {
        if (!isWanted[page] || HasData(page)) {
            continue;
        }
        if (!_geometry->Store() || !_geometry->Store()->Load(KeyOf(page), &_data[page])) {
            return false;
        }
        _bytes[page] = _data[page].size();
    }
    return true;
}

void ChunkPages::Build() {
    const ChunkPlan& plan = _geometry->Plan();
    ChunkGeometry chunk = _geometry->Source().Gather(plan.groups.data() + plan.begin[_chunk],
                                                     plan.begin[_chunk + 1] - plan.begin[_chunk]);
    _data[HDS_PAGE_GEOMETRY] = BuildGeometryPage(chunk).bytes;
    _data[HDS_PAGE_ATTRIBUTES] = BuildAttributePage(chunk);
    for (std::uint32_t page = 0; page < kNumPages; ++page) {
        _bytes[page] = _data[page].size();
    }
    _isExact = true;
}

} // namespace hds
