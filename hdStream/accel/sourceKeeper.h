// SPDX-License-Identifier: Apache-2.0
// Bounds the host memory of what chunks are cut from: sources and plans of geometry, which can be
// made again. Explained in docs/memory-budgets.md.
#pragma once

#include <atomic>
#include <cstdint>
#include <list>
#include <memory>
#include <mutex>
#include <unordered_map>

namespace hds {

/// Keeps those of the objects that were used last, up to a bound. Others live as long as somebody
/// else holds them. Thread-safe.
class SourceKeeper {
public:
    /// \param bytes bound; the one used last is kept whatever it takes.
    void SetLimit(std::uint64_t bytes);
    /// Bytes of what is kept; the most at a time since BeginStatistics.
    std::uint64_t Bytes() const;
    std::uint64_t PeakBytes() const;
    /// Counts from 0 again, and the most from what is kept now.
    void BeginStatistics();
    /// Sources were made for pages so often since BeginStatistics.
    std::uint64_t NumMade() const { return _numMade; }
    void CountMade() { ++_numMade; }
    /// Chunks were made though nobody had asked for them yet, since BeginStatistics.
    std::uint64_t NumAhead() const { return _numAhead; }
    void CountAhead() { ++_numAhead; }

    /// Keeps `object`, which was used now, for `owner`.
    void Use(const void* owner, const std::shared_ptr<const void>& object, std::uint64_t bytes);
    /// The owner is no more.
    void Forget(const void* owner);

private:
    struct Kept {
        const void* owner;
        std::shared_ptr<const void> object;
        std::uint64_t bytes;
    };
    using Order = std::list<Kept>;

    void MakeRoom(Order* dropped);
    void Take(Order::iterator place, Order* dropped);

    mutable std::mutex _mutex;
    std::uint64_t _limit = ~std::uint64_t{0};
    std::uint64_t _bytes = 0;
    std::uint64_t _peakBytes = 0;
    std::atomic<std::uint64_t> _numMade{0};
    std::atomic<std::uint64_t> _numAhead{0};
    Order _order; ///< used last comes last
    std::unordered_map<const void*, Order::iterator> _places;
};

} // namespace hds
