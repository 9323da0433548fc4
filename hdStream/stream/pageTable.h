// SPDX-License-Identifier: Apache-2.0
// Where the pages of a streaming pool lie, and the words of the residency table that tell kernels
// so. Knows no device. Explained in docs/streaming.md.
#pragma once

#include "hdStream/stream/poolRanges.h"

#include <cstdint>
#include <vector>

namespace hds {

/// The places of numbered pages in the buffers of a pool. A page that has a place is published by a
/// call of its own, once its bytes are there: kernels believe the words. Externally synchronised.
class PageTable {
public:
    /// In place of a page's number: there is no such page.
    static constexpr std::uint32_t kNoPage = 0xffffffffU;

    /// Numbers pages anew. Pages that were there before (by id) keep their places, those of all
    /// others are free again. \return the number that each page had before, or kNoPage.
    std::vector<std::uint32_t> Renumber(const std::vector<std::uint64_t>& ids);

    /// Begins with other buffers, in which no page has a place. \param pinnedBytes of them are set
    /// apart for pinned pages.
    void SetBuffers(const std::vector<std::uint64_t>& sizes, std::uint64_t pinnedBytes);

    std::uint32_t NumPages() const { return static_cast<std::uint32_t>(_pages.size()); }
    std::uint32_t NumBuffers() const { return _ranges.NumBuffers(); }

    /// Whether a page stays once it has found a place among the pinned ones.
    void SetPinned(std::uint32_t page, bool isPinned) { _pages[page].isPinned = isPinned; }
    /// Bytes that are set apart for pinned pages, and how many of them are taken.
    std::uint64_t PinLimit() const { return _ranges.ApartBytes(); }
    std::uint64_t PinnedBytes() const { return _ranges.PinnedBytes(); }
    /// Takes the places of pages that lie among the pinned ones and are pinned no more.
    /// \return how many.
    std::uint32_t RemoveUnpinned();

    /// Whether a page has a place, and where it is.
    bool HasPlace(std::uint32_t page) const { return _pages[page].range.bytes > 0; }
    const PoolRange& Place(std::uint32_t page) const { return _pages[page].range; }
    /// Bytes of all pages that have one, and how many these are.
    std::uint64_t PlacedBytes() const { return _placedBytes; }
    std::uint32_t NumPlaced() const { return _numPlaced; }
    /// Finds a place for a page that has none. \return false when there is no room.
    bool FindPlace(std::uint32_t page, std::uint64_t bytes);
    /// Takes a page's place; its word says so at once.
    void Remove(std::uint32_t page);

    /// The page's word says where it is.
    void Publish(std::uint32_t page);
    /// Whether a page is published and may be removed to make room.
    bool MayLeave(std::uint32_t page) const {
        return _words[page] != HDS_NOT_RESIDENT && !_ranges.IsPinned(_words[page]);
    }
    /// The residency table (kernels/shared/residency.h).
    const std::vector<std::uint32_t>& Words() const { return _words; }

private:
    struct Entry {
        PoolRange range; ///< bytes 0: it has no place
        bool isPinned = false;
    };

    PoolRanges _ranges;
    std::vector<std::uint64_t> _ids;
    std::vector<Entry> _pages;
    std::vector<std::uint32_t> _words;
    std::uint64_t _placedBytes = 0;
    std::uint32_t _numPlaced = 0;
};

/// Sorts what is kept of each page by its new numbers. \param previous as of PageTable::Renumber.
template <typename T>
void RenumberPages(const std::vector<std::uint32_t>& previous, std::vector<T>* values) {
    std::vector<T> renumbered(previous.size());
    for (std::size_t page = 0; page < previous.size(); ++page) {
        if (previous[page] != PageTable::kNoPage) {
            renumbered[page] = (*values)[previous[page]];
        }
    }
    *values = std::move(renumbered);
}

} // namespace hds
