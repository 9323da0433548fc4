// SPDX-License-Identifier: Apache-2.0
// What a pool counts: what it loads and gives away, how much it holds and has held at most. Knows
// no device. The keys of docs/statistics.md come from here.
#pragma once

#include <algorithm>
#include <cstdint>
#include <vector>

namespace hds {

/// What a pool has done since BeginStatistics. Bytes, seconds and counts of pages.
struct StreamingStatistics {
    std::uint64_t uploadedBytes = 0;
    std::uint64_t uploads = 0;
    std::uint64_t uniqueBytes = 0;  ///< of pages loaded at least once
    std::uint64_t groupUploads = 0; ///< of pages of groups that were asked for whole
    std::uint64_t evictions = 0;
    std::uint64_t requestsDropped = 0; ///< found no room in a table of requests, and were repeated
    std::uint64_t chunksUsed = 0;      ///< groups of which a page was asked for and loaded, or used
    double prepareSeconds = 0.0;       ///< making the bytes of pages
    double requestSeconds = 0.0;       ///< reading requests, choosing, publishing
    double transferSeconds = 0.0;
};

/// Bytes that are held, and the most that were held at a time.
class HeldBytes {
public:
    void Set(std::uint64_t bytes) {
        _bytes = bytes;
        _peak = std::max(_peak, bytes);
    }
    /// The peak begins anew with what is held.
    void BeginPeak() { _peak = _bytes; }
    std::uint64_t Bytes() const { return _bytes; }
    std::uint64_t Peak() const { return _peak; }

private:
    std::uint64_t _bytes = 0;
    std::uint64_t _peak = 0;
};

/// The statistics of a streaming pool, and what it takes to count each page and group once.
/// Externally synchronised.
class PoolCounters {
public:
    /// Numbers pages anew. \param previous as of PageTable::Renumber.
    void Renumber(const std::vector<std::uint32_t>& previous);
    /// Counts from 0 again; what is held remains.
    void Begin();

    /// A page was loaded. \param isAskedFor by kernels: its group is used.
    void CountLoad(std::uint32_t page, std::uint64_t bytes, bool isAskedFor);
    /// So many of the loads are of groups that were asked for whole.
    void CountGroupLoads(std::uint64_t count) { _statistics.groupUploads += count; }
    /// The group of a page was used.
    void CountUse(std::uint32_t page);
    /// So many pages have left that the scene still has.
    void CountEvictions(std::uint64_t count) { _statistics.evictions += count; }
    /// The loaded pages have so many bytes.
    void SetHeld(std::uint64_t bytes) { _held.Set(bytes); }

    /// So many requests have found no room.
    void CountDropped(std::uint64_t count) { _statistics.requestsDropped += count; }

    void AddPrepareSeconds(double seconds) { _statistics.prepareSeconds += seconds; }
    void AddRequestSeconds(double seconds) { _statistics.requestSeconds += seconds; }
    void AddTransferSeconds(double seconds) { _statistics.transferSeconds += seconds; }

    const StreamingStatistics& Statistics() const { return _statistics; }
    const HeldBytes& Held() const { return _held; }

private:
    struct State {
        bool wasLoaded = false; ///< since Begin
        bool wasUsed = false;   ///< the group that begins here is counted
    };

    std::vector<State> _pages;
    StreamingStatistics _statistics;
    HeldBytes _held;
};

} // namespace hds
