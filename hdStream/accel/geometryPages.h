// SPDX-License-Identifier: Apache-2.0
// The geometry payload of the streaming layer: page 2 * chunk is the chunk's geometry page, page
// 2 * chunk + 1 its attribute page (kernels/shared/geometry.h).
#pragma once

#include "hdStream/accel/chunkPages.h"
#include "hdStream/base/workCount.h"
#include "hdStream/stream/pageProvider.h"

#include <algorithm>
#include <functional>
#include <list>
#include <memory>
#include <unordered_map>
#include <vector>

namespace hds {

/// Prepared pages in host memory, of all versions of a scene: those used last, up to a bound.
/// Externally synchronised.
class PreparedPages {
public:
    /// \param bytes bound; what is needed at once may exceed it.
    void SetLimit(std::uint64_t bytes) { _limit = bytes; }

    /// A chunk with those of its pages that are wanted.
    struct Wanted {
        std::shared_ptr<ChunkPages> chunk;
        std::array<bool, ChunkPages::kNumPages> isWanted{};
    };

    /// Makes pages ready, on all cores, and forgets others. Each chunk occurs once. When memory
    /// runs out it throws, and these are forgotten too. \param isCancelled asked by this thread
    /// between chunks that are made ahead (PageMaker::MakeAhead); those that are wanted are made.
    void Prepare(const std::vector<Wanted>& wanted, const std::function<bool()>& isCancelled = {});
    /// A chunk lost a page.
    void Drop(const std::shared_ptr<ChunkPages>& chunk, std::uint32_t page);

    void Clear();

    std::uint64_t Bytes() const { return _bytes; }
    /// Counts from 0 again.
    void BeginStatistics();
    /// Chunks built, chunks read from the store, and seconds spent with both, since
    /// BeginStatistics.
    std::uint64_t NumBuilt() const { return _numBuilt; }
    std::uint64_t NumLoaded() const { return _numLoaded; }
    double Seconds() const { return _seconds; }

private:
    using Order = std::list<std::shared_ptr<ChunkPages>>;
    void Remove(Order::iterator place);
    void Forget(ChunkPages& chunk, std::uint64_t countedBytes);

    std::uint64_t _limit = ~std::uint64_t{0};
    std::uint64_t _bytes = 0;
    Order _order; ///< used last comes last
    std::unordered_map<const ChunkPages*, Order::iterator> _places;
    std::uint64_t _numBuilt = 0;
    std::uint64_t _numLoaded = 0;
    double _seconds = 0.0;
};

/// Pages of all chunks of a scene version, in chunk order.
class GeometryPages final : public PageProvider {
public:
    /// \param prepared must outlive the object.
    explicit GeometryPages(PreparedPages* prepared) : _prepared(*prepared) {}

    void AddChunk(std::shared_ptr<ChunkPages> chunk) {
        _chunks.push_back(std::move(chunk));
        _shouldStay.push_back(false);
    }
    /// Puts a chunk in the place of another one.
    void ReplaceChunk(std::uint32_t index, std::shared_ptr<ChunkPages> chunk) {
        _chunks[index] = std::move(chunk);
    }
    /// Chunks of instances come before all others (PageProvider::NumOuterPages).
    void AddInstanceChunks(const std::vector<std::shared_ptr<ChunkPages>>& chunks) {
        _chunks.insert(_chunks.begin(), chunks.begin(), chunks.end());
        _shouldStay.insert(_shouldStay.begin(), chunks.size(), false);
        _numInstanceChunks += static_cast<std::uint32_t>(chunks.size());
    }
    /// The pages of chunks [first, first + count) are better kept once loaded.
    void Keep(std::uint32_t first, std::uint32_t count) {
        std::fill_n(_shouldStay.begin() + first, count, true);
    }

    /// Prepares all chunks once, so that all sizes are exact; what host memory cannot hold is
    /// forgotten again. \param made chunks of which pages are there, before each question; may be
    /// null. \param first number of the first chunk that counts. \return false when `isCancelled`
    /// said so.
    bool PrepareAll(const std::function<bool()>& isCancelled, WorkCount* made = nullptr,
                    std::uint32_t first = 0);

    /// Bytes of all pages. \param[out] isExact whether they are no upper bound.
    std::uint64_t TotalBytes(bool* isExact = nullptr) const;

    /// Chunks of instances come first, of which nothing is kept in the store.
    std::uint32_t NumInstanceChunks() const { return _numInstanceChunks; }
    std::uint32_t NumChunks() const { return static_cast<std::uint32_t>(_chunks.size()); }
    std::uint32_t NumPages() const override {
        return ChunkPages::kNumPages * static_cast<std::uint32_t>(_chunks.size());
    }
    std::uint32_t NumOuterPages() const override {
        return ChunkPages::kNumPages * _numInstanceChunks;
    }
    std::uint64_t PageBytes(std::uint32_t page) const override {
        return ChunkOf(page)->Bytes(page % ChunkPages::kNumPages);
    }
    bool IsExact(std::uint32_t page) const override { return ChunkOf(page)->IsExact(); }
    std::uint64_t PageId(std::uint32_t page) const override {
        return ChunkOf(page)->Id(page % ChunkPages::kNumPages);
    }
    bool ShouldStay(std::uint32_t page) const override {
        return _shouldStay[page / ChunkPages::kNumPages];
    }
    void Prepare(const std::vector<std::uint32_t>& pages,
                 const IsCancelled& isCancelled = {}) override;
    const std::uint8_t* Page(std::uint32_t page) const override {
        return ChunkOf(page)->Data(page % ChunkPages::kNumPages).data();
    }
    bool Locate(std::uint32_t page, MappedPage* mapped) override {
        return ChunkOf(page)->Locate(page % ChunkPages::kNumPages, mapped);
    }
    void Drop(std::uint32_t page) override {
        _prepared.Drop(ChunkOf(page), page % ChunkPages::kNumPages);
    }

private:
    const std::shared_ptr<ChunkPages>& ChunkOf(std::uint32_t page) const {
        return _chunks[page / ChunkPages::kNumPages];
    }

    PreparedPages& _prepared;
    std::vector<std::shared_ptr<ChunkPages>> _chunks;
    std::vector<bool> _shouldStay; ///< by chunk
    std::uint32_t _numInstanceChunks = 0;
};

} // namespace hds
