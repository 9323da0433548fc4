// SPDX-License-Identifier: Apache-2.0
#include "hdStream/accel/geometryPages.h"

#include "hdStream/base/callerQuestion.h"

#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <chrono>

namespace hds {

namespace {

/// Bytes of the chunks that are prepared between two questions whether to go on.
constexpr std::uint64_t kBatchBytes = 64U << 20U;

bool HasAll(const PreparedPages::Wanted& wanted) {
    for (std::uint32_t page = 0; page < ChunkPages::kNumPages; ++page) {
        if (wanted.isWanted[page] && !wanted.chunk->HasData(page)) {
            return false;
        }
    }
    return true;
}

std::uint64_t BytesOf(const ChunkPages& chunk) {
    return chunk.Bytes(HDS_PAGE_GEOMETRY) + chunk.Bytes(HDS_PAGE_ATTRIBUTES);
}

/// Says that several chunks of a maker are made.
class Making {
public:
    explicit Making(const PageMaker& maker) : _maker(maker) { _maker.BeginMaking(); }
    ~Making() { _maker.EndMaking(); }
    Making(const Making&) = delete;
    Making& operator=(const Making&) = delete;

private:
    const PageMaker& _maker;
};

/// Makes chunks, those of one maker together: what they are made of may be more than is kept, and
/// is made once.
std::vector<ChunkPages::Made> Make(const std::vector<const PreparedPages::Wanted*>& chunks,
                                   const std::function<bool()>& isCancelled) {
    std::vector<std::size_t> begins;
    for (std::size_t i = 0; i < chunks.size(); ++i) {
        if (i == 0 || &chunks[i]->chunk->Maker() != &chunks[i - 1]->chunk->Maker()) {
            begins.push_back(i);
        }
    }
    begins.push_back(chunks.size());
    std::vector<ChunkPages::Made> made(chunks.size());
    CallerQuestion isOver(isCancelled);
    tbb::parallel_for(std::size_t{0}, begins.size() - 1, [&](std::size_t group) {
        const PageMaker& maker = chunks[begins[group]]->chunk->Maker();
        const Making making(maker);
        // A thread that waits inside begins no other group: it would hold what both are made of.
        tbb::this_task_arena::isolate([&] {
            tbb::parallel_for(begins[group], begins[group + 1], [&](std::size_t i) {
                made[i] = chunks[i]->chunk->Prepare(chunks[i]->isWanted);
            });
            maker.MakeAhead([&isOver] { return isOver.Ask(); });
        });
    });
    return made;
}

} // namespace

void PreparedPages::Prepare(const std::vector<Wanted>& wanted,
                            const std::function<bool()>& isCancelled) {
    const auto start = std::chrono::steady_clock::now();
    std::vector<const Wanted*> missing;
    std::uint64_t bytesToCome = 0;
    for (const Wanted& one : wanted) {
        ChunkPages& chunk = *one.chunk;
        const auto place = _places.find(&chunk);
        if (place != _places.end()) {
            _order.splice(_order.end(), _order, place->second); // used last
        }
        if (!HasAll(one)) {
            missing.push_back(&one);
            bytesToCome += BytesOf(chunk) - chunk.DataBytes();
        }
    }
    const std::size_t numKept = wanted.size();
    while (_bytes + bytesToCome > _limit && _order.size() > numKept) {
        Remove(_order.begin());
    }
    std::vector<std::uint64_t> bytesBefore;
    for (const Wanted* one : missing) {
        bytesBefore.push_back(one->chunk->DataBytes());
    }
    std::vector<ChunkPages::Made> made;
    try {
        made = Make(missing, isCancelled);
    } catch (...) { // memory has run out: what was to be made is forgotten
        for (std::size_t i = 0; i < missing.size(); ++i) {
            Forget(*missing[i]->chunk, bytesBefore[i]);
        }
        throw;
    }
    for (std::size_t i = 0; i < missing.size(); ++i) {
        const std::shared_ptr<ChunkPages>& chunk = missing[i]->chunk;
        _bytes += chunk->DataBytes() - bytesBefore[i];
        if (_places.count(chunk.get()) == 0) {
            _places[chunk.get()] = _order.insert(_order.end(), chunk);
        }
        _numBuilt += made[i] == ChunkPages::Made::Built ? 1 : 0;
        _numLoaded += made[i] == ChunkPages::Made::Loaded ? 1 : 0;
    }
    _seconds += std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

void PreparedPages::BeginStatistics() {
    _numBuilt = 0;
    _numLoaded = 0;
    _seconds = 0.0;
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
    const std::shared_ptr<ChunkPages> chunk = *place;
    Forget(*chunk, chunk->DataBytes());
}

/// Forgets a chunk's pages, of which so many bytes are counted.
void PreparedPages::Forget(ChunkPages& chunk, std::uint64_t countedBytes) {
    _bytes -= countedBytes;
    chunk.Drop(HDS_PAGE_GEOMETRY);
    chunk.Drop(HDS_PAGE_ATTRIBUTES);
    const auto place = _places.find(&chunk);
    if (place != _places.end()) {
        _order.erase(place->second);
        _places.erase(place);
    }
}

void PreparedPages::Clear() {
    while (!_order.empty()) {
        Remove(_order.begin());
    }
}

bool GeometryPages::PrepareAll(const std::function<bool()>& isCancelled, WorkCount* made,
                               std::uint32_t first) {
    const std::size_t numChunks = _chunks.size() - first;
    CallerQuestion isOver(isCancelled);
    std::vector<PreparedPages::Wanted> batch;
    std::uint64_t bytes = 0;
    for (std::size_t i = first; i <= _chunks.size(); ++i) {
        if (i == _chunks.size() || bytes >= kBatchBytes) {
            if (made != nullptr) {
                *made = {i - first - batch.size(), numChunks};
            }
            if (isOver.Ask()) {
                return false;
            }
            _prepared.Prepare(batch, [&isOver] { return isOver.Ask(); });
            batch.clear();
            bytes = 0;
        }
        if (i == _chunks.size()) {
            break;
        }
        // One whose size is known need not be made only to be forgotten.
        _chunks[i]->FindSizes();
        if (!_chunks[i]->IsExact()) {
            batch.push_back({_chunks[i], {true, true}});
            bytes += BytesOf(*_chunks[i]);
        }
    }
    if (made != nullptr) {
        *made = {numChunks, numChunks};
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

void GeometryPages::Prepare(const std::vector<std::uint32_t>& pages,
                            const IsCancelled& isCancelled) {
    std::vector<std::uint32_t> sorted = pages;
    std::sort(sorted.begin(), sorted.end());
    std::vector<PreparedPages::Wanted> wanted;
    for (const std::uint32_t page : sorted) {
        if (wanted.empty() || wanted.back().chunk != ChunkOf(page)) {
            wanted.push_back({ChunkOf(page), {}});
        }
        wanted.back().isWanted[page % ChunkPages::kNumPages] = true;
    }
    _prepared.Prepare(wanted, isCancelled);
}

} // namespace hds
