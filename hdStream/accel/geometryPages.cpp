// SPDX-License-Identifier: Apache-2.0
#include "hdStream/accel/geometryPages.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <chrono>

namespace hds {

namespace {

/// Bytes of the chunks that are prepared between two questions whether to go on.
constexpr std::uint64_t kBatchBytes = 64U << 20U;

bool IsWhole(const ChunkPages& chunk) {
    return chunk.HasData(HDS_PAGE_GEOMETRY) && chunk.HasData(HDS_PAGE_ATTRIBUTES);
}

std::uint64_t BytesOf(const ChunkPages& chunk) {
    return chunk.Bytes(HDS_PAGE_GEOMETRY) + chunk.Bytes(HDS_PAGE_ATTRIBUTES);
}

} // namespace

void PreparedPages::Prepare(const std::vector<std::shared_ptr<ChunkPages>>& chunks) {
    const auto start = std::chrono::steady_clock::now();
    std::vector<std::shared_ptr<ChunkPages>> missing;
    std::uint64_t bytesToCome = 0;
    for (const auto& chunk : chunks) {
        const auto place = _places.find(chunk.get());
        if (place != _places.end() && IsWhole(*chunk)) {
            _order.splice(_order.end(), _order, place->second); // used last
            continue;
        }
        if (place != _places.end()) {
            Remove(place->second);
        }
        missing.push_back(chunk);
        bytesToCome += BytesOf(*chunk);
    }
    const std::size_t numKept = chunks.size() - missing.size();
    while (_bytes + bytesToCome > _limit && _order.size() > numKept) {
        Remove(_order.begin());
    }
    tbb::parallel_for(std::size_t{0}, missing.size(),
                      [&](std::size_t i) { missing[i]->Build(); });
    for (const auto& chunk : missing) {
        _bytes += chunk->DataBytes();
        _places[chunk.get()] = _order.insert(_order.end(), chunk);
    }
    _numBuilt += missing.size();
    _seconds += std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

void PreparedPages::Drop(const std::shared_ptr<ChunkPages>& chunk, std::uint32_t page) {
    const auto place = _places.find(chunk.get());
    if (place == _places.end()) {
        return;
    }
    _bytes -= chunk->Data(page).size();
    chunk->Drop(page);
    if (chunk->DataBytes() == 0) {
        Remove(place->second);
    }
}

/// Forgets what is left of a chunk.
void PreparedPages::Remove(Order::iterator place) {
    ChunkPages& chunk = **place;
    _bytes -= chunk.DataBytes();
    chunk.Drop(HDS_PAGE_GEOMETRY);
    chunk.Drop(HDS_PAGE_ATTRIBUTES);
    _places.erase(&chunk);
    _order.erase(place);
}

void PreparedPages::Clear() {
    while (!_order.empty()) {
        Remove(_order.begin());
    }
}

bool GeometryPages::PrepareAll(const std::function<bool()>& isCancelled) {
    std::vector<std::shared_ptr<ChunkPages>> batch;
    std::uint64_t bytes = 0;
    for (std::size_t i = 0; i <= _chunks.size(); ++i) {
        if (i == _chunks.size() || bytes >= kBatchBytes) {
            if (isCancelled && isCancelled()) {
                return false;
            }
            _prepared.Prepare(batch);
            batch.clear();
            bytes = 0;
        }
        // One whose size is known need not be made again only because it was forgotten.
        if (i < _chunks.size() && !_chunks[i]->IsExact()) {
            batch.push_back(_chunks[i]);
            bytes += BytesOf(*_chunks[i]);
        }
    }
    return true;
}

std::uint64_t GeometryPages::TotalBytes(bool* isExact) const {
    std::uint64_t bytes = 0;
    bool allExact = true;
    for (const auto& chunk : _chunks) {
        bytes += BytesOf(*chunk);
        allExact = allExact && chunk->IsExact();
    }
    if (isExact != nullptr) {
        *isExact = allExact;
    }
    return bytes;
}

void GeometryPages::Prepare(const std::vector<std::uint32_t>& pages) {
    std::vector<std::uint32_t> numbers;
    for (const std::uint32_t page : pages) {
        numbers.push_back(page / ChunkPages::kNumPages);
    }
    std::sort(numbers.begin(), numbers.end());
    numbers.erase(std::unique(numbers.begin(), numbers.end()), numbers.end());
    std::vector<std::shared_ptr<ChunkPages>> chunks;
    for (const std::uint32_t number : numbers) {
        chunks.push_back(_chunks[number]);
    }
    _prepared.Prepare(chunks);
}

} // namespace hds
