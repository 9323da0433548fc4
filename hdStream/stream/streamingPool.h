// SPDX-License-Identifier: Apache-2.0
// Streaming mode: a pool of fixed size holds those pages that kernels
// have asked for; others leave when room is needed. Explained in docs/streaming.md.
#pragma once

#include "hdStream/device/device.h"
#include "hdStream/stream/pageProvider.h"
#include "hdStream/stream/poolRanges.h"

#include <array>
#include <chrono>
#include <memory>
#include <string>
#include <tuple>
#include <vector>

namespace hds {

/// Which pages leave when there is no room.
enum class Eviction {
    Clock, ///< those that were used least recently; of equally recent ones those fewest asked for
    Flush, ///< all of them (the report's rule)
};

/// What a streaming pool has done since BeginStatistics. Bytes, seconds and counts of pages.
struct StreamingStatistics {
    std::uint64_t uploadedBytes = 0;
    std::uint64_t uploads = 0;
    std::uint64_t uniqueBytes = 0;  ///< of pages loaded at least once
    std::uint64_t groupUploads = 0; ///< of pages of groups that were asked for whole
    std::uint64_t evictions = 0;
    std::uint64_t chunksUsed = 0; ///< groups of which a page was asked for and loaded, or used
    double prepareSeconds = 0.0;  ///< making the bytes of pages
    double serviceSeconds = 0.0;  ///< reading requests, choosing, publishing
    double transferSeconds = 0.0;
};

/// Device memory that holds some pages of a provider. Pages come in groups of kGroupPages with
/// numbers that follow each other, which shading needs together. Externally synchronised.
///
/// Launch; then, as long as items wait for pages, Service and launch again over them. Rays that
/// walk again each time: BeginCast; launch; then ServiceCast instead. Each service loads at least
/// one page (group) that was asked for.
///
/// Pages that should stay (PageProvider) are pinned: once loaded they leave with the scene only.
/// They have a range of their own of at most a quarter of the pool, which leaves room for the
/// largest group; those beyond it stream like all others. Flush knows no pinned pages.
class StreamingPool {
public:
    static constexpr std::uint32_t kGroupPages = 2;

    /// An empty pool. \param label names it in error messages. \param bufferLimit most bytes of one
    /// buffer, if the device does not ask for less.
    StreamingPool(std::shared_ptr<Device> device, std::string label, Eviction eviction,
                  std::uint64_t bufferLimit = kMaxPoolBufferBytes);

    /// Serves the pages of `provider`, which must live until the next call, from at most
    /// `budgetBytes` of device memory. Pages that are resident stay (known by their ids). Groups
    /// that may not fit are prepared, so that their sizes are known.
    /// \throws Error that names the option --LABELMemory when the largest group does not fit.
    void Update(PageProvider* provider, std::uint64_t budgetBytes);

    /// Counts from 0 again.
    void BeginStatistics();
    /// Adds groups that were used without being loaded to chunksUsed. Blocks.
    void CountUsed();

    /// Bytes of pages that are not resident; an upper bound while sizes are.
    std::uint64_t MissingBytes() const;
    /// Whether all pages fit, as far as their sizes are known.
    bool HasRoomForAll() const;
    /// Loads pages that nobody has asked for, about `bytes` of them; none leaves. Blocks.
    /// \return false when the room that is left is too scattered.
    bool LoadMissing(std::uint64_t bytes);
    /// All pages are resident and stay: kernels may read them without asking, and their bytes need
    /// not be kept elsewhere. \pre MissingBytes() is 0.
    void Settle();

    /// Begins a cast: no page is done.
    void BeginCast();
    /// After an iteration: the pages that were resident in it are done, those asked for most are
    /// loaded. Blocks.
    void ServiceCast();
    /// Loads what was asked for most: a page, or by its last page a whole group. Nothing is done.
    /// Blocks.
    void Service();

    /// The residency table (kernels/shared/residency.h).
    const Buffer& Addresses() const { return _table; }
    /// What kernels tell of each page (likewise).
    const Buffer& Uses() const { return _useTable; }
    /// Buffer `i` of the signature; unused ones are tiny but valid.
    const Buffer& PoolBuffer(std::uint32_t i) const { return _buffers[i]; }
    std::uint32_t NumBuffers() const { return _ranges.NumBuffers(); }
    /// Bytes of device memory for pages, and for the tables that streaming needs.
    std::uint64_t Bytes() const { return _bytes; }
    std::uint64_t TableBytes() const;
    /// The most bytes of pages that were resident at a time since BeginStatistics.
    std::uint64_t PeakUsedBytes() const { return _peakUsedBytes; }
    /// Bytes of pinned pages that are resident.
    std::uint64_t PinnedBytes() const { return _ranges.PinnedBytes(); }
    const StreamingStatistics& Statistics() const { return _statistics; }

private:
    using Clock = std::chrono::steady_clock;
    struct Request {
        std::uint32_t page = 0;
        std::uint32_t count = 0;
        bool isGroup = false; ///< for all of the page's group
    };
    struct PageState {
        PoolRange range;               ///< bytes 0: not resident
        std::uint64_t bytes = 0;       ///< of the page
        std::uint32_t wanted = 0;      ///< how many asked for it when it was loaded
        std::uint32_t protectedIn = 0; ///< last service that loaded it or found it needed
        bool isDone = false;           ///< of the present cast
        bool isPinned = false;         ///< stays once it has found a place among the pinned ones
        bool wasLoaded = false;        ///< since BeginStatistics
        bool wasUsed = false;          ///< likewise: its group is counted
    };

    /// A page that may leave. Ordered by what leaves first.
    struct Victim {
        std::uint32_t stamp = 0; ///< cast of its last use
        std::uint32_t wanted = 0;
        std::uint32_t page = 0;

        bool operator>(const Victim& other) const {
            return std::tie(stamp, wanted, page) > std::tie(other.stamp, other.wanted, other.page);
        }
    };

    bool IsResident(std::uint32_t page) const { return _pages[page].range.bytes > 0; }
    std::uint64_t GroupBytes(std::uint32_t first) const;
    std::uint64_t CheckFits(std::uint64_t budgetBytes);
    std::uint64_t PinLimit(std::uint64_t bytes, std::uint64_t largestGroup) const;
    std::uint64_t ChoosePinned(std::uint64_t limit);
    void RemoveUnpinned();
    /// \param word of the residency table.
    bool MayLeave(std::uint32_t word) const {
        return (word & ~HDS_PAGE_DONE) != HDS_NOT_RESIDENT &&
               !_ranges.IsPinned(word & ~HDS_PAGE_DONE);
    }
    bool IsProtected(std::uint32_t page) const { return _pages[page].protectedIn == _service; }
    void Protect(std::uint32_t page) { _pages[page].protectedIn = _service; }
    void AllocateBuffers(std::uint64_t bytes, std::uint64_t pinnedBytes);
    void MakeTables();
    void ReadUses();
    std::vector<Request> TakeRequests(bool withGroups);
    void Prepare(const std::vector<std::uint32_t>& pages);
    void PlaceInBatches(const std::vector<Request>& requests, bool withGroups);
    bool PlaceRequest(const Request& request);
    void EndService(Clock::time_point start, const StreamingStatistics& before);
    void BeginEpoch();
    bool PlaceGroup(std::uint32_t first, std::uint32_t wanted);
    bool Place(std::uint32_t page);
    void CountVictims();
    void ListVictims();
    bool Evict();
    bool Remove(std::uint32_t page);
    void LoadQueued(bool isAskedFor = true);
    void CountGroup(std::uint32_t page);
    bool WasUsed(std::uint32_t page) const;
    void UpdateWord(std::uint32_t page);
    void PublishTable();
    void PublishUses();

    std::shared_ptr<Device> _device;
    std::string _label;
    Eviction _eviction;
    std::uint64_t _bufferLimit;
    PageProvider* _provider = nullptr;
    PoolRanges _ranges;
    std::array<Buffer, kMaxPoolBuffers> _buffers;
    std::uint64_t _bytes = 0;
    Buffer _table;
    Buffer _useTable;
    std::uint32_t _service = 0;        ///< counts services
    std::vector<std::uint32_t> _words; ///< of the residency table
    std::vector<std::uint32_t> _uses;  ///< as last read; in a service, as they will be published
    std::uint32_t _epoch = 1;          ///< counts casts and services
    std::uint32_t _firstEpoch = 1;     ///< since BeginStatistics
    std::vector<PageState> _pages;
    std::vector<std::uint64_t> _ids;
    static constexpr std::uint32_t kNumAges = 256;
    std::vector<Victim> _victims; ///< of this service: a heap, the first to leave on top
    bool _hasVictims = false;     ///< they are counted
    std::array<std::uint32_t, kNumAges> _numByAge{}; ///< resident pages; the last: all older ones
    std::uint32_t _listedAge = 0; ///< pages of this age and older ones are, or were, in the heap
    std::vector<std::uint32_t> _queued; ///< placed and prepared, to be loaded
    std::uint64_t _placedBytes = 0;     ///< in this service
    std::uint64_t _peakUsedBytes = 0;
    StreamingStatistics _statistics;
};

} // namespace hds
