// SPDX-License-Identifier: Apache-2.0
// What a hash table tells of pages is what the direct table tells, whatever the pages' numbers;
// what kernels write into it comes back by page.
#include "hdStream/stream/pageHash.h"

#include "kernels/shared/geometry.h"
#include "kernels/shared/residency.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>

namespace hds::test {
namespace {

/// Entry by entry from the page's bucket on, as kernels search (kernels/stream/pageHash.clh).
std::uint32_t Find(const std::vector<std::uint32_t>& table, std::uint32_t page) {
    const std::uint32_t mask = table[0];
    for (std::uint32_t bucket = HDS_HASH_BUCKET(page, mask);; bucket = (bucket + 1) & mask) {
        const auto first = HDS_HASH_HEADER + HDS_BUCKET_WORDS * bucket;
        for (std::uint32_t i = first; i < first + HDS_BUCKET_PAGES; ++i) {
            if (table[i] == page || table[i] == HDS_NONE) {
                return table[i] == page ? i : HDS_NONE;
            }
        }
    }
}

/// Direct words of `numPages` pages, of which those given are there.
std::vector<std::uint32_t> Words(std::uint32_t numPages, const std::vector<std::uint32_t>& there) {
    std::vector<std::uint32_t> words(numPages, HDS_NOT_RESIDENT);
    for (const std::uint32_t page : there) {
        words[page] = 3 * page + 1;
    }
    return words;
}

TEST(PageHash, TellsOfAllPagesWhatTheDirectTableTells) {
    constexpr std::uint32_t kPages = 100'000;
    std::mt19937 random(3);
    for (const std::uint32_t entries : {32U, 64U, 4096U}) {
        PageHash hash(entries);
        for (int round = 0; round < 5; ++round) { // the last one is as full as it may be
            std::vector<std::uint32_t> there;
            for (std::uint32_t i = 0; i < hash.MostPages() * (round + 1) / 5; ++i) {
                // Neighbours, as the two pages of a chunk, and others.
                there.push_back(i % 2 == 0 ? random() % kPages : (there.back() ^ 1U));
            }
            const std::vector<std::uint32_t> words = Words(kPages, there);
            hash.Enter(words);
            for (std::uint32_t page = 0; page < kPages; ++page) {
                const std::uint32_t entry = Find(hash.Addresses(), page);
                const std::uint32_t word = entry == HDS_NONE
                                               ? HDS_NOT_RESIDENT
                                               : hash.Addresses()[entry + HDS_BUCKET_PAGES];
                ASSERT_EQ(word, words[page]) << "page " << page << " of " << entries;
            }
        }
    }
}

TEST(PageHash, PagesOfOneBucketAllHaveAnEntry) {
    PageHash hash(64);
    std::vector<std::uint32_t> there;
    const std::uint32_t mask = 64 / HDS_BUCKET_PAGES - 1;
    for (std::uint32_t page = 0; there.size() < hash.MostPages(); ++page) {
        if (HDS_HASH_BUCKET(page, mask) == mask) { // the last one: the next is the first
            there.push_back(page);
        }
    }
    hash.Enter(Words(there.back() + 1, there));
    for (const std::uint32_t page : there) {
        EXPECT_NE(Find(hash.Addresses(), page), HDS_NONE);
    }
}

TEST(PageHash, UsesComeBackByPageAndRequestsOnce) {
    PageHash hash(64);
    constexpr std::uint32_t kPages = 500;
    const std::vector<std::uint32_t> there = {7, 90, 91, 400};
    hash.Enter(Words(kPages, there));
    std::vector<std::uint32_t> uses(kPages);
    for (const std::uint32_t page : there) {
        uses[page] = 1000 + page;
    }
    uses[8] = 5; // was asked for, and is told no more
    std::vector<std::uint32_t> device = hash.Write(uses);
    ASSERT_EQ(device.size(), hash.NumUseWords());
    // Two requests, as kernels write them.
    const std::uint32_t bucket = 64 + HDS_HASH_BUCKET(123U, hash.AskedMask()) * HDS_BUCKET_WORDS;
    device[bucket] = 123 + 1;
    device[bucket + HDS_BUCKET_PAGES] = 9 | HDS_ASKED_WHOLE;
    device[bucket + 1] = 499 + 1;
    device[bucket + 1 + HDS_BUCKET_PAGES] = 2;
    std::vector<std::uint32_t> read(kPages);
    hash.Read(device, &read);
    std::vector<std::uint32_t> wanted(kPages);
    for (const std::uint32_t page : there) {
        wanted[page] = 1000 + page;
    }
    wanted[123] = 9 | HDS_ASKED_WHOLE;
    wanted[499] = 2;
    EXPECT_EQ(read, wanted);
    // Of other pages that are there the uses are at other places.
    hash.Enter(Words(kPages, {400, 3}));
    std::vector<std::uint32_t> after(kPages);
    hash.Read(hash.Write(wanted), &after);
    EXPECT_EQ(after[400], 1400U);
    EXPECT_EQ(after[123], 0U);
}

TEST(PageHash, TakesABoundedPartOfThePool) {
    for (const std::uint64_t pool : {1ULL << 20U, 1ULL << 25U, 1ULL << 29U, 1ULL << 34U}) {
        const PageHash hash(PageHash::EntriesOf(pool));
        const std::uint64_t bytes =
            sizeof(std::uint32_t) * (hash.Addresses().size() + hash.NumUseWords());
        EXPECT_LE(bytes, pool / 256 + 64);
        EXPECT_GE(bytes, pool / 520); // the next one would be too large
    }
    EXPECT_EQ(PageHash::RoundUp(0), PageHash::kLeastEntries);
    EXPECT_EQ(PageHash::RoundUp(33), 64U);
    EXPECT_EQ(PageHash::RoundUp(~0ULL), PageHash::kMostEntries);
}

} // namespace
} // namespace hds::test
