// SPDX-License-Identifier: Apache-2.0
// Which pages leave a streaming pool that is full. Knows no device. Explained in docs/streaming.md.
#pragma once

#include "hdStream/stream/pageUses.h"

#include <array>
#include <cstdint>
#include <tuple>
#include <vector>

namespace hds {

/// The order in which pages leave. Externally synchronised.
class EvictionOrder {
public:
    virtual ~EvictionOrder() = default;

    /// Numbers pages anew. \param previous as of PageTable::Renumber.
    void Renumber(const std::vector<std::uint32_t>& previous);
    /// Begins a round: no page is protected.
    virtual void BeginRound() { ++_round; }

    /// A page stays as long as the round lasts: it was loaded in it, or found needed.
    void Protect(std::uint32_t page) { _pages[page].protectedIn = _round; }
    bool IsProtected(std::uint32_t page) const { return _pages[page].protectedIn == _round; }
    /// How many asked for a page when it was loaded.
    void SetWanted(std::uint32_t page, std::uint32_t count) { _pages[page].wanted = count; }
    std::uint32_t Wanted(std::uint32_t page) const { return _pages[page].wanted; }

    /// Whether single pages are chosen. Then some may be pinned, and those that hardly any ask for
    /// make none leave.
    virtual bool IsSelective() const { return true; }
    /// The pages that leave next, of those in `table` that may leave. \return false when there are
    /// none.
    virtual bool Next(const PageTable& table, const PageUses& uses,
                      std::vector<std::uint32_t>* pages) = 0;

private:
    struct State {
        std::uint32_t wanted = 0;
        std::uint32_t protectedIn = 0; ///< number of a round
    };

    std::vector<State> _pages;
    std::uint32_t _round = 0;
};

/// One page at a time: that which was used least recently, of equally recent ones that which
/// fewest asked for.
class LastUseOrder : public EvictionOrder {
public:
    void BeginRound() override;
    bool Next(const PageTable& table, const PageUses& uses,
              std::vector<std::uint32_t>* pages) override;

private:
    /// A page that may leave. Ordered by what leaves first.
    struct Victim {
        std::uint32_t stamp = 0; ///< epoch of its last use
        std::uint32_t wanted = 0;
        std::uint32_t page = 0;

        bool operator>(const Victim& other) const {
            return std::tie(stamp, wanted, page) > std::tie(other.stamp, other.wanted, other.page);
        }
    };
    static constexpr std::uint32_t kNumAges = 256;

    void CountAges(const PageTable& table, const PageUses& uses);
    void ListVictims(const PageTable& table, const PageUses& uses);

    bool _isCounted = false; ///< in this round
    std::array<std::uint32_t, kNumAges>
        _numByAge{};              ///< of what may leave; the last: all older ones
    std::uint32_t _listedAge = 0; ///< this age and older ones are, or were, in the heap
    std::vector<Victim> _victims; ///< a heap, the first to leave on top
};

} // namespace hds
