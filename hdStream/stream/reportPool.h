// SPDX-License-Identifier: Apache-2.0
// The report's own streaming, which ours is measured against (docs/streaming.md, Report mode): all
// pages leave a full pool at once, and pages that all rays of a batch have visited are done.
#pragma once

#include "hdStream/stream/streamingPool.h"
#include "kernels/shared/reportPage.h"

#include <memory>
#include <string>
#include <vector>

namespace hds {

/// What leaves a pool that is full.
enum class Eviction {
    Lru,   ///< LastUseOrder
    Flush, ///< FlushOrder
};

/// All pages leave at once. No page is pinned.
class FlushOrder : public EvictionOrder {
public:
    bool IsSelective() const override { return false; }
    bool Next(const PageTable& table, const PageUses& uses,
              std::vector<std::uint32_t>* pages) override;
};

/// A pool for rays that walk again from the root: BeginBatch; launch; then, as long as rays wait,
/// ProcessBatchRequests and launch again. Words of the table carry HDS_PAGE_DONE besides.
class ReportPool : public StreamingPool {
public:
    using StreamingPool::StreamingPool;

    bool Update(PageProvider* provider, std::uint64_t budgetBytes) override;
    void MakeResident(bool keepsBytes) override;

    /// Begins a ray batch: no page is done.
    void BeginBatch();
    /// After an iteration: the pages that were resident in it are done, those asked for most are
    /// loaded. Blocks.
    void ProcessBatchRequests();

protected:
    void PublishTable() override;
    bool MayHash() const override { return false; }

private:
    std::vector<bool> _isDone; ///< of the present batch
};

/// A pool as --geometryEviction and --request choose it.
std::unique_ptr<StreamingPool> MakeStreamingPool(std::shared_ptr<Device> device, std::string label,
                                                 Eviction eviction, bool requestsFirst);

} // namespace hds
