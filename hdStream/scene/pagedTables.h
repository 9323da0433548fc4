// SPDX-License-Identifier: Apache-2.0
// What of the device's tables grows with the number of prims goes to where instances stream: an
// object of one chunk into the number by which records name it, what is said of a prim beside its
// records, and the material of a prim that has one into that (kernels/shared/instanceChunk.h).
// Explained in docs/streaming.md, "Instances that stream".
#pragma once

#include "hdStream/scene/commit.h"
#include "hdStream/scene/instanceChunks.h"

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <utility>
#include <vector>

namespace hds {

/// What has left the tables of a scene, and the numbers of what is left.
struct PagedTables {
    std::vector<std::uint32_t> objectNumbers; ///< by those that records had; of nothing HDS_NONE
    std::vector<std::uint32_t> primNumbers;   ///< by those that records had
    std::vector<shared::HdsPrim> prims;       ///< all, by their numbers
};

/// Takes what it can out of the tables. They keep what records in the table of instances name: of
/// the prims those come first now, and so do material entries of prims that have several.
/// \pre the tables are complete, and the scene has instance chunks.
PagedTables TakeFromTables(CommittedScene* scene);

/// The pages of instance chunks, with what the tables have no longer.
class PagedInstances final : public PageMaker {
public:
    /// \param tables may be filled later, before the first page is made.
    /// \param numPrims in the scene.
    PagedInstances(std::shared_ptr<const InstanceChunks> records,
                   std::shared_ptr<const PagedTables> tables, std::uint64_t numPrims)
        : _records(std::move(records)), _tables(std::move(tables)), _numPrims(numPrims) {}

    std::array<std::uint64_t, 2> BoundBytes(std::uint32_t chunk) const override;
    ChunkBytes Make(std::uint32_t chunk) const override;
    PageStore* Store() const override { return _records->Store(); }
    std::optional<PageKey> Key(std::uint32_t chunk, std::uint32_t page) const override {
        return _records->Key(chunk, page);
    }

private:
    std::shared_ptr<const InstanceChunks> _records;
    std::shared_ptr<const PagedTables> _tables;
    std::uint64_t _numPrims;
};

} // namespace hds
