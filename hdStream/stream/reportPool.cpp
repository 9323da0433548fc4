// SPDX-License-Identifier: Apache-2.0
#include "hdStream/stream/reportPool.h"

#include <algorithm>
#include <utility>

namespace hds {

bool FlushOrder::Next(const PageTable& table, const PageUses& /*uses*/,
                      std::vector<std::uint32_t>* pages) {
    pages->clear();
    for (std::uint32_t page = 0; page < table.NumPages(); ++page) {
        if (table.MayLeave(page) && !IsProtected(page)) {
            pages->push_back(page);
        }
    }
    return !pages->empty();
}

bool ReportPool::Update(PageProvider* provider, std::uint64_t budgetBytes) {
    _isDone.assign(provider->NumPages(), false);
    return StreamingPool::Update(provider, budgetBytes);
}

void ReportPool::MakeResident(bool keepsBytes) {
    BeginBatch(); // kernels that do not stream know nothing of "done"
    StreamingPool::MakeResident(keepsBytes);
}

void ReportPool::BeginBatch() {
    BeginEpoch();
    if (std::find(_isDone.begin(), _isDone.end(), true) != _isDone.end()) {
        _isDone.assign(_isDone.size(), false);
        PublishTable();
    }
}

void ReportPool::ProcessBatchRequests() {
    for (std::uint32_t page = 0; page < _isDone.size(); ++page) {
        _isDone[page] = _isDone[page] || Table().HasPlace(page);
    }
    ProcessRound(false);
}

void ReportPool::PublishTable() {
    std::vector<std::uint32_t> words = Table().Words();
    for (std::uint32_t page = 0; page < words.size(); ++page) {
        words[page] |= _isDone[page] ? HDS_PAGE_DONE : 0U;
    }
    WriteWords(words);
}

std::unique_ptr<StreamingPool> MakeStreamingPool(std::shared_ptr<Device> device, std::string label,
                                                 Eviction eviction, bool requestsFirst) {
    std::unique_ptr<EvictionOrder> order;
    if (eviction == Eviction::Flush) {
        order = std::make_unique<FlushOrder>();
    }
    if (requestsFirst) {
        return std::make_unique<ReportPool>(std::move(device), std::move(label), std::move(order));
    }
    return std::make_unique<StreamingPool>(std::move(device), std::move(label), std::move(order));
}

} // namespace hds
