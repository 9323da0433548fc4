// SPDX-License-Identifier: Apache-2.0
// The residency table and the uses as hash tables of a size that does not grow with the pages that
// there are (kernels/shared/residency.h). Knows no device. Explained in docs/streaming.md.
#pragma once

#include <cstdint>
#include <vector>

namespace hds {

/// What kernels look up of pages that are there, and where they write what they ask for. Externally
/// synchronised.
class PageHash {
public:
    /// \param numEntries of the residency table: a power of two, at least kLeastEntries.
    explicit PageHash(std::uint32_t numEntries);

    static constexpr std::uint32_t kLeastEntries = 32;
    static constexpr std::uint32_t kMostEntries = 1U << 24U;
    /// Entries of tables for a pool: together they take less than 1/256 of its bytes.
    static std::uint32_t EntriesOf(std::uint64_t poolBytes);
    /// The power of two that is not less, within the bounds.
    static std::uint32_t RoundUp(std::uint64_t numEntries);

    /// Pages that may be there at a time, so that searches are short.
    std::uint32_t MostPages() const { return NumEntries() / 8 * 7; }

    /// Enters the pages that are there. \param words of the direct table (PageTable::Words).
    void Enter(const std::vector<std::uint32_t>& words);
    /// The residency table.
    const std::vector<std::uint32_t>& Addresses() const { return _addresses; }

    /// Words of the uses behind their header.
    std::uint32_t NumUseWords() const;
    /// Number of buckets for requests less 1.
    std::uint32_t AskedMask() const { return _numAskedBuckets - 1; }
    /// Sorts uses as kernels have left them by page. \param[in,out] uses of the direct table; those
    /// of pages that neither are there nor were asked for stay.
    void Read(const std::vector<std::uint32_t>& words, std::vector<std::uint32_t>* uses) const;
    /// Uses for kernels: nobody asks for anything. \param uses of the direct table.
    std::vector<std::uint32_t> Write(const std::vector<std::uint32_t>& uses) const;

private:
    std::uint32_t NumEntries() const { return static_cast<std::uint32_t>(_pages.size()); }

    std::vector<std::uint32_t> _addresses;
    std::vector<std::uint32_t> _pages; ///< by entry; HDS_NONE: none
    std::uint32_t _numAskedBuckets;
};

} // namespace hds
