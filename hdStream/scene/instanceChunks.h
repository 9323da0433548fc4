// SPDX-License-Identifier: Apache-2.0
// Instance records of a group, or of the TLAS, in chunks that stream as geometry does: a chunk's
// page is a BVH over records, made from the arrays as authored when rays ask for it. On the host an
// instance takes 4 bytes, its place in the order of the chunks. Explained in docs/streaming.md,
// "Instances that stream".
#pragma once

#include "hdStream/accel/chunkPlan.h"
#include "hdStream/accel/pageMaker.h"
#include "hdStream/scene/groupRecords.h"

#include <memory>
#include <vector>

namespace hds {

/// Shares records out over chunks, which are compact in space. \param inTable records that are left
/// out, ascending. \param bounds hold the boxes of all others. \param chunkBytes about what the
/// page of a chunk takes at most. \param numOfAll about so many records lie in chunks, of all
/// groups. \return a plan whose groups are records.
ChunkPlan PlanInstanceChunks(const GroupRecords& records, const std::vector<std::uint32_t>& inTable,
                             const Bounds& bounds, std::uint64_t chunkBytes,
                             std::uint64_t numOfAll);

/// The pages of a plan's chunks.
class InstanceChunks final : public PageMaker {
public:
    /// \param records which do not move. \param object the group that they belong to.
    /// \param store for pages that are to be mapped; may be null.
    InstanceChunks(GroupRecords records, ChunkPlan plan, std::uint32_t object,
                   std::shared_ptr<PageStore> store);

    std::uint32_t NumChunks() const { return static_cast<std::uint32_t>(_plan.NumChunks()); }

    std::uint32_t NumRecords(std::uint32_t chunk) const { return _plan.counts[chunk]; }

    std::array<std::uint64_t, 2> BoundBytes(std::uint32_t chunk) const override;
    ChunkBytes Make(std::uint32_t chunk) const override;
    PageStore* Store() const override { return _store.get(); }
    std::optional<PageKey> Key(std::uint32_t /*chunk*/, std::uint32_t /*page*/) const override {
        return std::nullopt;
    }

private:
    GroupRecords _records;
    ChunkPlan _plan;
    std::uint32_t _object;
    std::shared_ptr<PageStore> _store;
};

} // namespace hds
