// SPDX-License-Identifier: Apache-2.0
// Whatever happens to the bytes of a segment: each page is right or absent, and can be saved again.
#include "testenv/unit/persist/pageFixtures.h"

#include "hdStream/persist/file.h"
#include "hdStream/persist/pageFormat.h"

#include <cstddef>
#include <cstring>

namespace hds {
namespace {

constexpr std::uint64_t kPages = 4;
constexpr std::size_t kPageBytes = 100; // takes 128 in the file

class PageDamageTest : public PageStoreTest {
protected:
    /// A folder with one file of kPages pages.
    std::filesystem::path MakeSegment() {
        std::filesystem::remove_all(folder);
        PageStore store(Options(), &warnings);
        for (std::uint64_t i = 0; i < kPages; ++i) {
            EXPECT_TRUE(Save(&store, i, kPageBytes));
        }
        return OnlyFile();
    }
    std::uint64_t Present(PageStore* store) {
        std::uint64_t present = 0;
        for (std::uint64_t i = 0; i < kPages; ++i) {
            present += Has(store, i, kPageBytes) ? 1 : 0;
        }
        return present;
    }
    /// What a renderer does: makes again what is absent. Then the next process finds everything.
    void ExpectRepaired() {
        {
            PageStore store(Options(), &warnings);
            for (std::uint64_t i = 0; i < kPages; ++i) {
                if (!Has(&store, i, kPageBytes)) {
                    EXPECT_TRUE(Save(&store, i, kPageBytes));
                }
            }
        }
        PageStore store(Options(), &warnings);
        EXPECT_EQ(Present(&store), kPages);
        EXPECT_EQ(store.Statistics().pagesSaved, 0U);
    }
};

TEST_F(PageDamageTest, AFlippedByteOfTheHeaderRemovesTheFile) {
    for (std::uint64_t at = 0; at < sizeof(SegmentHeader); ++at) {
        const auto path = MakeSegment();
        FlipByte(path, at);
        PageStore store(Options(), &warnings);
        EXPECT_EQ(Present(&store), 0U) << at;
        EXPECT_FALSE(std::filesystem::exists(path)) << at;
    }
    ExpectRepaired();
}

TEST_F(PageDamageTest, AFlippedByteOfTheIndexCostsItsPageOnly) {
    for (std::uint64_t at = kSlotBytes; at < (1 + kPages) * kSlotBytes; ++at) {
        FlipByte(MakeSegment(), at);
        const std::uint64_t damaged = at / kSlotBytes - 1;
        PageStore store(Options(), &warnings);
        for (std::uint64_t i = 0; i < kPages; ++i) {
            EXPECT_EQ(Has(&store, i, kPageBytes), i != damaged) << at;
        }
        // A wrong last entry is taken for one that was being written.
        const bool isLast = damaged + 1 == kPages;
        EXPECT_EQ(store.Statistics().pagesRejected, isLast ? 0U : 1U) << at;
        EXPECT_TRUE(Save(&store, damaged, kPageBytes));
        EXPECT_EQ(Files().size(), isLast ? 1U : 2U) << at; // a damaged file is not continued
    }
    ExpectRepaired();
}

TEST_F(PageDamageTest, AnEntryCountsInItsOwnPlaceOnly) {
    const File file = File::Open(MakeSegment().string());
    IndexEntry entry{};
    ASSERT_TRUE(file.Read(kSlotBytes, &entry, sizeof(entry)));
    ASSERT_TRUE(file.Write(2 * kSlotBytes, &entry, sizeof(entry)));
    PageStore store(Options(), &warnings);
    EXPECT_EQ(store.Statistics().pagesRejected, 1U);
    EXPECT_EQ(Present(&store), kPages - 1);
}

TEST_F(PageDamageTest, AFlippedByteOfAPageIsFoundAndForgotten) {
    for (std::uint64_t at = 0; at < (kPages - 1) * 128 + kPageBytes; at += 9) {
        FlipByte(MakeSegment(), kBlockBytes + at);
        const bool isPadding = at % 128 >= kPageBytes;
        for (const bool isMapped : {false, true}) {
            PageStore store(Options(), &warnings);
            const PageKey key = TestKey(at / 128);
            // The second process finds the page marked as wrong in the index.
            EXPECT_EQ(store.Contains(key), isPadding || !isMapped);
            EXPECT_EQ(isMapped ? store.Locate(key).has_value() : Has(&store, at / 128, kPageBytes),
                      isPadding);
            EXPECT_EQ(store.Contains(key), isPadding);
            EXPECT_EQ(Present(&store), kPages - (isPadding ? 0 : 1));
            EXPECT_EQ(store.Statistics().pagesRejected, isPadding || isMapped ? 0U : 1U);
        }
        ExpectRepaired();
    }
}

TEST_F(PageDamageTest, LocatingVerifiesTheFirstTime) {
    FlipByte(MakeSegment(), kBlockBytes + 128 + 5);
    PageStore store(Options(), &warnings);
    EXPECT_TRUE(store.Locate(TestKey(0)).has_value());
    EXPECT_FALSE(store.Locate(TestKey(1)).has_value());
    EXPECT_FALSE(store.Contains(TestKey(1)));
    EXPECT_EQ(store.Statistics().pagesRejected, 1U);
}

TEST_F(PageDamageTest, PartsOfADamagedOrCutPageAreAbsent) {
    const auto path = MakeSegment();
    FlipByte(path, kBlockBytes + 128 + 5);
    PageStore store(Options(), &warnings);
    std::uint8_t byte = 0;
    EXPECT_TRUE(store.LoadPart(TestKey(0), 7, 1, &byte));
    EXPECT_EQ(byte, TestPage(0, kPageBytes)[7]);
    EXPECT_FALSE(store.LoadPart(TestKey(1), 90, 1, &byte)) << "the byte itself is right";
    EXPECT_TRUE(store.LoadPart(TestKey(2), 90, 1, &byte));
    std::filesystem::resize_file(path, kBlockBytes + 128);
    EXPECT_FALSE(store.LoadPart(TestKey(2), 90, 1, &byte)) << "though it was verified before";
    EXPECT_EQ(store.Statistics().pagesRejected, 2U);
}

TEST_F(PageDamageTest, AnOpenedPageIsVerifiedOnceAndReadAsLongAsItsFileIsThere) {
    const auto path = MakeSegment();
    FlipByte(path, kBlockBytes + 128 + 5);
    PageStore store(Options(), &warnings);
    EXPECT_EQ(store.Open(TestKey(1)), nullptr) << "damaged";
    EXPECT_EQ(store.Open(TestKey(100)), nullptr) << "unknown";
    EXPECT_EQ(store.Statistics().pagesRejected, 1U);
    const auto page = store.Open(TestKey(2));
    const auto cut = store.Open(TestKey(3));
    ASSERT_NE(page, nullptr);
    ASSERT_NE(cut, nullptr);
    std::vector<std::uint8_t> part(40);
    for (const std::size_t offset : {0U, 1U, 60U}) {
        ASSERT_TRUE(page->Read(offset, part.size(), part.data()));
        const std::vector<std::uint8_t> whole = TestPage(2, kPageBytes);
        EXPECT_TRUE(std::equal(part.begin(), part.end(),
                               whole.begin() + static_cast<std::ptrdiff_t>(offset)));
    }
    EXPECT_FALSE(page->Read(61, part.size(), part.data())) << "the next page's bytes";
    EXPECT_FALSE(page->Read(~std::uint64_t{0}, part.size(), part.data()));
    std::filesystem::resize_file(path, kBlockBytes + 3 * 128);
    EXPECT_FALSE(cut->Read(0, 1, part.data()));
    EXPECT_TRUE(page->Read(0, 1, part.data()));
    store.Clear();
    EXPECT_EQ(store.Open(TestKey(2)), nullptr);
    EXPECT_TRUE(page->Read(60, part.size(), part.data())) << "its file is still open";
}

TEST_F(PageDamageTest, AFileThatIsCutIsNotAppendedTo) {
    const auto path = MakeSegment();
    std::uint8_t byte = 0;
    PageStore store(Options(), &warnings);
    EXPECT_TRUE(store.LoadPart(TestKey(3), 90, 1, &byte));
    std::filesystem::resize_file(path, kBlockBytes + 128);
    EXPECT_TRUE(Save(&store, 100, 4096));
    EXPECT_TRUE(Has(&store, 100, 4096));
    EXPECT_EQ(std::filesystem::file_size(path), kBlockBytes + 128);
    EXPECT_EQ(Files().size(), 2U) << "a new segment";
    EXPECT_FALSE(store.LoadPart(TestKey(3), 90, 1, &byte)) << "not zeros of a hole";
    EXPECT_TRUE(Save(&store, 3, kPageBytes));
    EXPECT_TRUE(Has(&store, 3, kPageBytes));
    EXPECT_TRUE(warnings.Lines().empty());
}

TEST_F(PageDamageTest, RejectingAPageDoesNotMakeACutFileLonger) {
    constexpr std::uint64_t kCount = 1100; // the last ones are in a second block of the index
    {
        PageStore store(Options(), &warnings);
        for (std::uint64_t i = 0; i < kCount; ++i) {
            ASSERT_TRUE(Save(&store, i, 64));
        }
    }
    PageStore store(Options(), &warnings);
    std::uint8_t byte = 0;
    EXPECT_TRUE(store.LoadPart(TestKey(500), 0, 1, &byte));
    std::filesystem::resize_file(OnlyFile(), kBlockBytes + 128);
    EXPECT_FALSE(store.LoadPart(TestKey(kCount - 1), 0, 1, &byte));
    EXPECT_EQ(std::filesystem::file_size(OnlyFile()), kBlockBytes + 128);
    EXPECT_FALSE(store.LoadPart(TestKey(500), 0, 1, &byte)) << "not zeros of a hole";
}

TEST_F(PageDamageTest, ATruncatedFileKeepsTheWholePages) {
    const std::uint64_t full = kBlockBytes + (kPages - 1) * 128 + kPageBytes;
    EXPECT_EQ(std::filesystem::file_size(MakeSegment()), full);
    for (std::uint64_t size = 0; size < full; size += size < 400 ? 13 : (size < 65000 ? 5000 : 7)) {
        std::filesystem::resize_file(MakeSegment(), size);
        const std::uint64_t payload = size > kBlockBytes ? size - kBlockBytes : 0;
        {
            PageStore store(Options(), &warnings);
            const std::uint64_t whole = (payload + 128 - kPageBytes) / 128;
            EXPECT_EQ(store.Contains(TestKey(whole)), false) << size;
            EXPECT_EQ(Present(&store), whole) << size;
        }
        ExpectRepaired();
    }
}

TEST_F(PageDamageTest, AFileCutWhileItIsMappedOrOpenGivesNoSignal) {
    const auto path = MakeSegment();
    PageStore store(Options(), &warnings);
    ASSERT_NE(store.SegmentData(0), nullptr);
    std::filesystem::resize_file(path, kBlockBytes + 128);
    EXPECT_TRUE(store.Locate(TestKey(0)).has_value());
    EXPECT_FALSE(store.Locate(TestKey(2)).has_value());
    EXPECT_FALSE(Has(&store, 3, kPageBytes));
    EXPECT_EQ(store.Statistics().pagesRejected, 2U);
}

/// A header that is sound but not this version's, or not this machine's.
SegmentHeader ForeignHeader(bool isOtherVersion) {
    SegmentHeader header = MakeSegmentHeader(1U << 20U);
    if (isOtherVersion) {
        ++header.version;
    } else {
        header.endianMark = 0x04030201U;
    }
    header.checksum = PayloadChecksum(&header, offsetof(SegmentHeader, checksum));
    return header;
}

TEST_F(PageDamageTest, OtherVersionsAndByteOrdersAreRemovedUnlessHeld) {
    for (const bool isOtherVersion : {true, false}) {
        const auto path = MakeSegment();
        const SegmentHeader header = ForeignHeader(isOtherVersion);
        ASSERT_TRUE(File::Open(path.string()).Write(0, &header, sizeof(header)));
        {
            const File other = File::Open(path.string());
            ASSERT_EQ(other.TryLock(0, 1, true), LockResult::Acquired);
            PageStore store(Options(), &warnings);
            EXPECT_EQ(Present(&store), 0U);
            EXPECT_TRUE(std::filesystem::exists(path));
        }
        PageStore store(Options(), &warnings);
        EXPECT_EQ(Present(&store), 0U);
        EXPECT_FALSE(std::filesystem::exists(path));
    }
    EXPECT_TRUE(warnings.Lines().empty());
}

TEST_F(PageDamageTest, ALostLinkCostsTheBlocksBehindIt) {
    const std::uint64_t count = 2 * kBlockSlots;
    {
        PageStore store(Options(), &warnings);
        for (std::uint64_t i = 0; i < count; ++i) {
            ASSERT_TRUE(Save(&store, i, 100));
        }
    }
    FlipByte(OnlyFile(), kBlockBytes - kSlotBytes + 20); // in the last slot of the first block
    {
        PageStore store(Options(), &warnings);
        for (std::uint64_t i = 0; i < count; ++i) {
            EXPECT_EQ(Has(&store, i, 100), i < kBlockSlots - 2) << i;
            EXPECT_TRUE(Save(&store, i, 100));
        }
    }
    PageStore store(Options(), &warnings);
    for (std::uint64_t i = 0; i < count; ++i) {
        EXPECT_TRUE(Has(&store, i, 100)) << i;
    }
}

TEST_F(PageDamageTest, AnInterruptedSaveLeavesNoPageAndTheFileIsContinued) {
    constexpr std::uint64_t kCount = kBlockSlots * 3 / 2; // the second block is half full
    const auto path = MakeSegment();
    // The state between the two writes of a save: the payload is there, its entry is not; and the
    // state within the second: half an entry.
    const std::vector<std::uint8_t> garbage(3 * kBlockBytes, 0xaa);
    for (const std::size_t entryBytes : {0, 32}) {
        const std::uint64_t size = std::filesystem::file_size(path);
        {
            const File file = File::Open(path.string());
            ASSERT_TRUE(file.Write(AlignPage(size), garbage.data(), garbage.size()));
            ASSERT_TRUE(file.Write((1 + kPages) * kSlotBytes, garbage.data(), entryBytes));
        }
        PageStore store(Options(), &warnings);
        EXPECT_EQ(Present(&store), kPages);
        if (entryBytes == 32) {
            for (std::uint64_t i = kPages; i < kCount; ++i) { // needs a block of zeros
                ASSERT_TRUE(Save(&store, i, kPageBytes));
            }
        }
    }
    EXPECT_EQ(OnlyFile(), path);
    PageStore store(Options(), &warnings);
    for (std::uint64_t i = 0; i < kCount; ++i) {
        ASSERT_TRUE(Has(&store, i, kPageBytes)) << i;
    }
    EXPECT_EQ(store.Statistics().pagesRejected, 0U);
}

} // namespace
} // namespace hds
