// SPDX-License-Identifier: Apache-2.0
// What kernels have told of each page (kernels/shared/residency.h): when one that is there was used
// last, how many ask for one that is missing. Knows no device. Explained in docs/streaming.md.
#pragma once

#include "hdStream/stream/pageTable.h"

#include <cstdint>
#include <vector>

namespace hds {

/// Pages come in groups of so many, with numbers that follow each other; shading needs a whole one.
constexpr std::uint32_t kGroupPages = 2;

inline std::uint32_t FirstOfGroup(std::uint32_t page) {
    return page / kGroupPages * kGroupPages;
}

/// A page that is missing.
struct PageRequest {
    std::uint32_t page = 0;
    std::uint32_t count = 0; ///< of those who ask for it
    bool isGroup = false;    ///< all of the page's group is asked for
};

/// The words of the uses as they were last read from the device and changed since. Externally
/// synchronised.
class PageUses {
public:
    /// Nobody has told of any of so many pages.
    void Reset(std::uint32_t numPages) { _words.assign(numPages, 0); }
    /// The words of pages without their header, to be read from the device and written to it.
    std::vector<std::uint32_t>& Words() { return _words; }
    const std::vector<std::uint32_t>& Words() const { return _words; }

    /// Stamps of uses are epochs, which the host counts.
    std::uint32_t Epoch() const { return _epoch; }
    void BeginEpoch() { ++_epoch; }
    /// Uses count for WasUsed from here on.
    void BeginStatistics() { _firstEpoch = _epoch; }

    /// The epoch in which a page that is there was used last, 0: it was not; and how many epochs
    /// ago that was.
    std::uint32_t Stamp(std::uint32_t page) const { return _words[page]; }
    std::uint32_t Age(std::uint32_t page) const { return _epoch - _words[page]; }
    /// \pre the page is there.
    bool WasUsed(std::uint32_t page) const { return _words[page] >= _firstEpoch; }
    /// Forgets what was told of a page.
    void Clear(std::uint32_t page) { _words[page] = 0; }

    /// The pages without a place that are asked for, most wanted first; clears the requests.
    /// \param withGroups whether pages of which the whole group is wanted stand for it.
    std::vector<PageRequest> TakeRequests(const PageTable& table, bool withGroups);

private:
    std::vector<std::uint32_t> _words;
    std::uint32_t _epoch = 1;
    std::uint32_t _firstEpoch = 1;
};

} // namespace hds
