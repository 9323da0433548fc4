// SPDX-License-Identifier: Apache-2.0
#include "hdStream/scene/instanceChunks.h"

#include "hdStream/accel/bvh.h"
#include "hdStream/base/error.h"

#include <glm/common.hpp>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cstring>
#include <string>
#include <utility>

namespace hds {

namespace {

/// What a record takes in its page about, with its share of the nodes; and at most: a node of the
/// collapsed tree and its inner children have more than nine children together.
constexpr std::uint64_t kMeanBytes = 100;
constexpr std::uint64_t kBoundBytes = 128;
constexpr std::uint64_t kFixedBytes = sizeof(shared::HdsPageHeader) + sizeof(shared::HdsBvhNode);

/// Records as PlanChunks takes them: all but some. Their boxes are computed whenever they are asked
/// for.
class RecordBoxes final : public PrimitiveGroups {
public:
    RecordBoxes(const GroupRecords& records, const std::vector<std::uint32_t>& leftOut,
                const Bounds& bounds)
        : _records(records), _leftOut(leftOut) {
        _numGroups = records.Size() - static_cast<std::uint32_t>(leftOut.size());
        _numTriangles = _numGroups;
        _bounds = bounds;
    }
    std::uint32_t GroupTriangles(std::uint32_t /*group*/) const override { return 1; }
    Bounds GroupBounds(std::uint32_t group) const override {
        return _records.BoxOf(RecordOf(group));
    }

    /// The record of that rank among those that are not left out.
    std::uint32_t RecordOf(std::uint32_t group) const {
        std::uint32_t before = 0; // of those left out, how many come before it
        auto end = static_cast<std::uint32_t>(_leftOut.size());
        while (before < end) {
            const std::uint32_t middle = before + (end - before) / 2;
            if (_leftOut[middle] - middle <= group) {
                before = middle + 1;
            } else {
                end = middle;
            }
        }
        return group + before;
    }

private:
    const GroupRecords& _records;
    const std::vector<std::uint32_t>& _leftOut;
};

} // namespace

ChunkPlan PlanInstanceChunks(const GroupRecords& records, const std::vector<std::uint32_t>& inTable,
                             const Bounds& bounds, std::uint64_t chunkBytes,
                             std::uint64_t numOfAll) {
    const RecordBoxes boxes(records, inTable, bounds);
    // Cutting a grid makes no more than four times as many chunks as have to be.
    const std::uint64_t numInChunks = std::max<std::uint64_t>(boxes.NumPrimitiveGroups(), numOfAll);
    const std::uint64_t least = 4 * numInChunks / HDS_MAX_INSTANCE_CHUNKS + 1;
    const std::uint64_t most = std::clamp<std::uint64_t>(std::max(least, chunkBytes / kMeanBytes),
                                                         1, HDS_MAX_CHUNK_RECORDS);
    ChunkPlan plan = PlanChunks(boxes, static_cast<std::uint32_t>(most));
    tbb::parallel_for(std::size_t{0}, plan.groups.size(),
                      [&](std::size_t i) { plan.groups[i] = boxes.RecordOf(plan.groups[i]); });
    return plan;
}

InstanceChunks::InstanceChunks(GroupRecords records, ChunkPlan plan, std::uint32_t object,
                               std::shared_ptr<PageStore> store)
    : _records(std::move(records)), _plan(std::move(plan)), _object(object),
      _store(std::move(store)) {
    for (const std::uint32_t count : _plan.counts) {
        HDS_VERIFY(count <= HDS_MAX_CHUNK_RECORDS, std::to_string(count));
    }
    _records.Keep();
}

std::array<std::uint64_t, 2> InstanceChunks::BoundBytes(std::uint32_t chunk) const {
    return {kFixedBytes + kBoundBytes * _plan.counts[chunk], 0};
}

ChunkBytes InstanceChunks::Make(std::uint32_t chunk) const {
    const std::uint32_t* first = _plan.groups.data() + _plan.begin[chunk];
    const std::uint32_t count = _plan.begin[chunk + 1] - _plan.begin[chunk];
    std::vector<Bounds> boxes(count);
    std::vector<shared::HdsInstance> records(count);
    _records.WriteWithBoxes(first, count, records.data(), boxes.data());
    BvhOptions options;
    options.maxLeafItems = 1;
    const Bvh tree = BuildBvh(std::move(boxes), options);
    const std::size_t nodeBytes = tree.nodes.size() * sizeof(shared::HdsBvhNode);
    shared::HdsPageHeader header{};
    header.triangles =
        static_cast<std::uint32_t>((sizeof(header) + nodeBytes) / HDS_POOL_UNIT_BYTES);
    header.primIds = _object;
    header.numTriangles = count | HDS_PRIMITIVE_INSTANCES << HDS_PRIMITIVE_SHIFT;
    ChunkBytes pages;
    std::vector<std::uint8_t>& page = pages[HDS_PAGE_GEOMETRY];
    page.resize(sizeof(header) + nodeBytes + count * sizeof(shared::HdsInstance));
    std::memcpy(page.data(), &header, sizeof(header));
    std::memcpy(page.data() + sizeof(header), tree.nodes.data(), nodeBytes);
    std::uint8_t* place = page.data() + sizeof(header) + nodeBytes;
    for (const std::uint32_t item : tree.order) {
        std::memcpy(place, &records[item], sizeof(shared::HdsInstance));
        place += sizeof(shared::HdsInstance);
    }
    return pages;
}

} // namespace hds
