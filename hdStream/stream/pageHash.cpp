// SPDX-License-Identifier: Apache-2.0
#include "hdStream/stream/pageHash.h"

#include "hdStream/base/error.h"
#include "kernels/shared/geometry.h"
#include "kernels/shared/residency.h"

#include <algorithm>

namespace hds {

namespace {

/// Entries of the residency table for each of the table of requests: of what is there a round asks
/// for a part only.
constexpr std::uint32_t kEntriesPerAsked = 4;
/// Part of the bytes of a pool that its tables may take.
constexpr std::uint64_t kPoolDivisor = 256;
/// Page, address and use of an entry, and its part of an entry for requests.
constexpr std::uint64_t kEntryBytes = 14;

} // namespace

PageHash::PageHash(std::uint32_t numEntries)
    : _addresses(HDS_HASH_HEADER + 2 * std::size_t{numEntries}), _pages(numEntries),
      _numAskedBuckets(numEntries / kEntriesPerAsked / HDS_BUCKET_PAGES) {
    static_assert(kLeastEntries == kEntriesPerAsked * HDS_BUCKET_PAGES, "one bucket for requests");
    HDS_VERIFY(RoundUp(numEntries) == numEntries, "entries of a page table");
}

std::uint32_t PageHash::EntriesOf(std::uint64_t poolBytes) {
    std::uint32_t entries = kLeastEntries;
    while (entries < kMostEntries && 2 * kEntryBytes * entries <= poolBytes / kPoolDivisor) {
        entries *= 2;
    }
    return entries;
}

std::uint32_t PageHash::RoundUp(std::uint64_t numEntries) {
    std::uint32_t entries = kLeastEntries;
    while (entries < kMostEntries && entries < numEntries) {
        entries *= 2;
    }
    return entries;
}

void PageHash::Enter(const std::vector<std::uint32_t>& words) {
    const std::uint32_t mask = NumEntries() / HDS_BUCKET_PAGES - 1;
    std::fill(_pages.begin(), _pages.end(), HDS_NONE);
    _addresses[0] = mask;
    std::fill(_addresses.begin() + HDS_HASH_HEADER, _addresses.end(), HDS_NONE);
    std::uint32_t numPages = 0;
    for (std::uint32_t page = 0; page < words.size(); ++page) {
        if (words[page] == HDS_NOT_RESIDENT) {
            continue;
        }
        HDS_VERIFY(++numPages <= MostPages(), "pages of a page table");
        std::uint32_t entry = HDS_HASH_BUCKET(page, mask) * HDS_BUCKET_PAGES;
        while (_pages[entry] != HDS_NONE) {
            entry = (entry + 1) % NumEntries(); // to the next bucket at the end of this one
        }
        _pages[entry] = page;
        std::uint32_t* const bucket = _addresses.data() + HDS_HASH_HEADER +
                                      entry / HDS_BUCKET_PAGES * HDS_BUCKET_WORDS +
                                      entry % HDS_BUCKET_PAGES;
        bucket[0] = page;
        bucket[HDS_BUCKET_PAGES] = words[page];
    }
}

std::uint32_t PageHash::NumUseWords() const {
    return NumEntries() + _numAskedBuckets * HDS_BUCKET_WORDS;
}

void PageHash::Read(const std::vector<std::uint32_t>& words,
                    std::vector<std::uint32_t>* uses) const {
    for (std::uint32_t entry = 0; entry < NumEntries(); ++entry) {
        if (_pages[entry] != HDS_NONE) {
            (*uses)[_pages[entry]] = words[entry];
        }
    }
    for (std::uint32_t bucket = 0; bucket < _numAskedBuckets; ++bucket) {
        const std::uint32_t* const asked = words.data() + NumEntries() + bucket * HDS_BUCKET_WORDS;
        for (std::uint32_t i = 0; i < HDS_BUCKET_PAGES && asked[i] != 0; ++i) {
            (*uses)[asked[i] - 1] = asked[HDS_BUCKET_PAGES + i];
        }
    }
}

std::vector<std::uint32_t> PageHash::Write(const std::vector<std::uint32_t>& uses) const {
    std::vector<std::uint32_t> words(NumUseWords());
    for (std::uint32_t entry = 0; entry < NumEntries(); ++entry) {
        words[entry] = _pages[entry] != HDS_NONE ? uses[_pages[entry]] : 0;
    }
    return words;
}

} // namespace hds
