// SPDX-License-Identifier: Apache-2.0
// Streaming mode: a pool of fixed size holds those pages that kernels
// have asked for; others leave when room is needed. Explained in docs/streaming.md.
#pragma once

#include "hdStream/stream/evictionOrder.h"
#include "hdStream/stream/pageHash.h"
#include "hdStream/stream/pagePool.h"
#include "hdStream/stream/pageTable.h"
#include "hdStream/stream/pageUses.h"
#include "hdStream/stream/poolCounters.h"

#include <functional>
#include <memory>
#include <string>
#include <vector>

namespace hds {

/// Device memory that holds some pages of a provider. Pages come in groups of kGroupPages, which
/// shading needs together. Externally synchronised.
///
/// Launch; then, as long as items wait for pages, ProcessRequests and launch again over them. Each
/// round loads at least one page, or group, that was asked for.
///
/// Pages that should stay (PageProvider) are pinned: once loaded they leave with the scene only.
/// They have a range of their own of at most a quarter of the pool, which leaves room for the
/// largest group; those beyond it stream like all others.
class StreamingPool : public PagePool {
public:
    /// An empty pool. \param order in which pages leave; null: LastUseOrder. \param bufferLimit
    /// most bytes of one buffer, if the device does not ask for less.
    StreamingPool(std::shared_ptr<Device> device, std::string label,
                  std::unique_ptr<EvictionOrder> order = nullptr,
                  std::uint64_t bufferLimit = kMaxPoolBufferBytes);

    /// From the next Update on: where pages are reached through others (PageProvider), and there
    /// are more of them, kernels look them up in a hash table of so many entries (PageHash).
    /// 0: where that takes less of the device than a word for each page, of as many as the pool
    /// warrants.
    void SetHashEntries(std::uint32_t count) { _hashEntries = count; }
    /// Whether they do.
    bool HasPageHash() const { return _hash != nullptr; }

    /// Groups that may not fit are prepared, so that their sizes are known. \return true.
    /// \throws Error that names the option --LABELMemory when the largest group does not fit.
    bool Update(PageProvider* provider, std::uint64_t budgetBytes) override;

    void BeginStatistics() override;
    StreamingStatistics Statistics() const override { return _counters.Statistics(); }
    /// Adds groups that were used without being loaded to chunksUsed. Blocks.
    void CountUsed();

    /// Bytes of pages that are not resident; an upper bound while sizes are.
    std::uint64_t MissingBytes() const;
    /// Whether all pages fit, as far as their sizes are known.
    bool HasRoomForAll() const;
    /// Loads pages that nobody has asked for, about `bytes` of them; none leaves. Blocks.
    /// \return false when the room that is left is too scattered.
    bool LoadMissing(std::uint64_t bytes);
    /// All pages are resident and stay: kernels may read them without asking. \param keepsBytes the
    /// provider, too, may keep them; otherwise it drops them. \pre MissingBytes() is 0.
    virtual void MakeResident(bool keepsBytes);

    using IsCancelled = PageProvider::IsCancelled;

    /// Loads what was asked for most: pages, and whole groups by the page that asks for them.
    /// Blocks. \param isCancelled asked between batches of pages that are prepared together: when
    /// it says so, the others are not loaded. The provider may ask it too.
    void ProcessRequests(const IsCancelled& isCancelled = {});

    /// What kernels tell of each page (kernels/shared/residency.h).
    const Buffer& Uses() const { return _useTable; }
    std::uint32_t NumBuffers() const override { return _table.NumBuffers(); }
    std::uint64_t Bytes() const override { return _bytes; }
    std::uint64_t TableBytes() const override { return _addresses.Bytes() + _useTable.Bytes(); }
    std::uint64_t PinnedBytes() const override { return _table.PinnedBytes(); }
    std::uint64_t PeakUsedBytes() const override { return _counters.Held().Peak(); }

protected:
    const PageTable& Table() const { return _table; }
    void BeginEpoch();
    /// ProcessRequests without a new epoch. \param withGroups whether whole groups may be asked
    /// for.
    void ProcessRound(bool withGroups, const IsCancelled& isCancelled = {});
    /// Publishes the words of the table.
    virtual void PublishTable();
    void WriteWords(const std::vector<std::uint32_t>& words);
    /// Whether its kernels may look pages up in hash tables.
    virtual bool MayHash() const { return true; }

private:
    void Renumber();
    std::uint64_t GroupBytes(std::uint32_t first) const;
    std::uint64_t CheckFits(std::uint64_t budgetBytes);
    std::uint64_t PrepareLarge(std::uint32_t begin, std::uint32_t end, std::uint64_t limit);
    std::uint64_t PinLimit(std::uint64_t bytes, std::uint64_t largestGroup) const;
    std::uint64_t ChoosePinned(std::uint64_t limit);
    void AllocateBuffers(std::uint64_t bytes, std::uint64_t pinnedBytes);
    void ChooseHash(std::uint64_t bytes, std::uint64_t totalBytes);
    /// For one page more.
    bool HasEntry() const { return !_hash || _table.NumPlaced() < _hash->MostPages(); }
    /// For the pages that are there.
    bool HasEntries() const { return !_hash || _table.NumPlaced() <= _hash->MostPages(); }
    void MakeTables();
    void ReadUses();
    void PublishUses();
    void Prepare(const std::vector<std::uint32_t>& pages, const IsCancelled& isCancelled = {});
    void PlaceInBatches(const std::vector<PageRequest>& requests, bool withGroups,
                        const IsCancelled& isCancelled);
    bool PlaceRequest(const PageRequest& request);
    bool PlaceGroup(std::uint32_t first, std::uint32_t wanted);
    bool Place(std::uint32_t page);
    bool Evict();
    void WithdrawWay();
    std::vector<std::uint32_t> TakeWay();
    void PlaceWay(const std::vector<std::uint32_t>& pages, const IsCancelled& isCancelled);
    void RemoveAll();
    void Remove(std::uint32_t page);
    void LoadQueued(bool isAskedFor = true);

    std::uint64_t _bufferLimit;
    PageProvider* _provider = nullptr;
    std::uint64_t _bytes = 0;
    Buffer _useTable;
    PageTable _table;
    std::uint32_t _hashEntries = 0;
    std::unique_ptr<PageHash> _hash; ///< null: kernels have a word for each page
    PageUses _uses;
    std::unique_ptr<EvictionOrder> _order;
    PoolCounters _counters;
    std::vector<std::uint64_t> _pageBytes; ///< as the pool plans with them
    std::vector<std::uint32_t> _queued;    ///< placed and prepared, to be loaded
    std::vector<std::uint32_t> _leaving;   ///< as of EvictionOrder::Next
    std::uint64_t _placedBytes = 0;        ///< in this round
    bool _hasEvicted = false;              ///< room had to be made in this round
};

} // namespace hds
