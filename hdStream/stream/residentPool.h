// SPDX-License-Identifier: Apache-2.0
// Resident mode: every page is uploaded once and stays as long as the scene
// has it. The address table has the form that the streaming pool will publish, so kernels see no
// difference. Explained in docs/architecture.md.
#pragma once

#include "hdStream/stream/pagePool.h"

#include <memory>
#include <string>
#include <unordered_map>
#include <vector>

namespace hds {

/// Device memory that holds all pages of a provider. Externally synchronised.
class ResidentPool : public PagePool {
public:
    /// An empty pool.
    ResidentPool(std::shared_ptr<Device> device, std::string label);

    /// Pages the provider lacks leave, new ones are prepared, uploaded and dropped from it. There
    /// is no budget. \throws Error when a pool that was empty cannot hold all pages.
    bool Update(PageProvider* provider, std::uint64_t budgetBytes) override;

    std::uint32_t NumBuffers() const override { return _ranges.NumBuffers(); }
    std::uint64_t Bytes() const override { return _bytes; }
    std::uint64_t PeakUsedBytes() const override { return _held.Peak(); }
    void BeginStatistics() override;
    StreamingStatistics Statistics() const override { return _statistics; }

private:
    bool LoadMissing(PageProvider* provider);
    void RemoveOthers(const PageProvider& provider);
    bool Upload(PageProvider* provider, const std::vector<std::uint32_t>& pages,
                std::uint64_t bytesToCome);
    bool Place(std::uint64_t bytes, std::uint64_t bytesToCome, PoolRange* range);
    bool AddBuffer(std::uint64_t bytes, std::uint64_t bytesToCome);

    std::uint64_t _bufferLimit;
    RangeAllocator _ranges;
    std::unordered_map<std::uint64_t, PoolRange> _pages; ///< by page id
    std::vector<std::uint32_t> _missing;                 ///< pages of this update
    std::uint64_t _bytes = 0;
    StreamingStatistics _statistics;
    HeldBytes _held;
};

} // namespace hds
