// SPDX-License-Identifier: Apache-2.0
// Pages come back as they were saved, in this process and the next, by copy and through mappings.
#include "testenv/unit/persist/pageFixtures.h"

#include "hdStream/persist/pageFormat.h"

#include <algorithm>
#include <atomic>
#include <cstring>
#include <thread>

namespace hds {
namespace {

/// Sizes around every boundary of the format.
const std::vector<std::size_t> kSizes = {0, 1, 63, 64, 65, 100, 4096, 65535, 65536, 65537, 300000};

TEST_F(PageStoreTest, PagesComeBackInTheNextProcess) {
    {
        PageStore store(Options(), &warnings);
        for (std::size_t i = 0; i < kSizes.size(); ++i) {
            EXPECT_FALSE(store.Contains(TestKey(i)));
            EXPECT_TRUE(Save(&store, i, kSizes[i]));
            EXPECT_TRUE(Has(&store, i, kSizes[i]));
        }
        EXPECT_EQ(store.Statistics().pagesSaved, kSizes.size());
    }
    PageStore store(Options(), &warnings);
    for (std::size_t i = 0; i < kSizes.size(); ++i) {
        EXPECT_TRUE(store.Contains(TestKey(i)));
        EXPECT_EQ(store.Bytes(TestKey(i)), kSizes[i]);
        EXPECT_TRUE(Has(&store, i, kSizes[i]));
    }
    EXPECT_FALSE(store.Contains(TestKey(99)));
    EXPECT_FALSE(store.Bytes(TestKey(99)).has_value());
    EXPECT_FALSE(store.Locate(TestKey(99)).has_value());
    EXPECT_EQ(store.Statistics().pagesLoaded, kSizes.size());
    EXPECT_EQ(store.Statistics().pagesRejected, 0U);
    EXPECT_TRUE(warnings.Lines().empty());
}

TEST_F(PageStoreTest, IndexesOfManyBlocksAndSegmentsAreRead) {
    const std::uint64_t count = 3 * kBlockSlots + 17;
    {
        PageStore store(Options(512U << 10U), &warnings);
        for (std::uint64_t i = 0; i < count; ++i) {
            ASSERT_TRUE(Save(&store, i, 100 + i % 300));
        }
    }
    EXPECT_GE(Files().size(), 2U);
    PageStore store(Options(), &warnings);
    for (std::uint64_t i = 0; i < count; ++i) {
        ASSERT_TRUE(Has(&store, i, 100 + i % 300)) << i;
    }
}

TEST_F(PageStoreTest, ShortRunsContinueOneFile) {
    for (std::uint64_t run = 0; run < 20; ++run) {
        PageStore store(Options(), &warnings);
        EXPECT_TRUE(Save(&store, run, 1000));
    }
    OnlyFile();
    PageStore store(Options(), &warnings);
    for (std::uint64_t run = 0; run < 20; ++run) {
        EXPECT_TRUE(Has(&store, run, 1000));
    }
}

TEST_F(PageStoreTest, APageLargerThanASegmentIsKept) {
    PageStore store(Options(256U << 10U), &warnings);
    EXPECT_TRUE(Save(&store, 1, 3U << 20U));
    EXPECT_TRUE(Has(&store, 1, 3U << 20U));
}

TEST_F(PageStoreTest, APageThatIsThereIsNotWrittenAgain) {
    PageStore store(Options(), &warnings);
    EXPECT_TRUE(Save(&store, 1, 100000));
    const std::uint64_t size = store.Size();
    EXPECT_TRUE(Save(&store, 1, 100000));
    EXPECT_EQ(store.Size(), size);
    EXPECT_EQ(store.Statistics().pagesSaved, 1U);
}

TEST_F(PageStoreTest, ADisabledStoreIsEmptyAndTouchesNothing) {
    PageStoreOptions options = Options();
    options.enabled = false;
    PageStore store(options, &warnings);
    EXPECT_FALSE(Save(&store, 1, 100));
    EXPECT_FALSE(Has(&store, 1, 100));
    EXPECT_FALSE(std::filesystem::exists(folder));
    EXPECT_TRUE(warnings.Lines().empty());
}

TEST_F(PageStoreTest, OpeningAnAbsentFolderMakesNone) {
    PageStore store(Options(), &warnings);
    EXPECT_FALSE(Has(&store, 1, 100));
    EXPECT_EQ(store.Size(), 0U);
    EXPECT_FALSE(std::filesystem::exists(folder));
}

TEST_F(PageStoreTest, TheMappingHasThePagesAlsoThoseSavedLater) {
    {
        PageStore store(Options(), &warnings);
        EXPECT_TRUE(Save(&store, 1, 5000));
    }
    // The second store appends to the file of the first, with its mapping made before.
    PageStore store(Options(), &warnings);
    const auto first = store.Locate(TestKey(1));
    ASSERT_TRUE(first.has_value());
    const std::uint8_t* data = store.SegmentData(first->segment);
    ASSERT_NE(data, nullptr);
    EXPECT_TRUE(Save(&store, 2, 70000));
    for (std::uint64_t number : {1, 2}) {
        const auto page = store.Locate(TestKey(number));
        ASSERT_TRUE(page.has_value());
        EXPECT_EQ(page->segment, first->segment);
        EXPECT_EQ(page->offset % 64, 0U);
        ASSERT_LE(page->offset + page->bytes, store.SegmentBytes(page->segment));
        const auto expected = TestPage(number, page->bytes);
        EXPECT_EQ(std::memcmp(data + page->offset, expected.data(), expected.size()), 0);
    }
    EXPECT_EQ(store.SegmentData(first->segment), data);
    EXPECT_EQ(store.SegmentData(first->segment + 1), nullptr);
}

TEST_F(PageStoreTest, PartsOfPagesAreReadByThemselves) {
    constexpr std::size_t kBytes = 1000;
    const auto whole = TestPage(1, kBytes);
    {
        PageStore store(Options(), &warnings);
        ASSERT_TRUE(Save(&store, 1, kBytes));
    }
    PageStore store(Options(), &warnings);
    std::vector<std::uint8_t> part(100);
    for (const std::size_t offset : {0U, 1U, 512U, 900U}) {
        ASSERT_TRUE(store.LoadPart(TestKey(1), offset, part.size(), part.data()));
        EXPECT_TRUE(std::equal(part.begin(), part.end(),
                               whole.begin() + static_cast<std::ptrdiff_t>(offset)));
    }
    EXPECT_FALSE(store.LoadPart(TestKey(1), 901, part.size(), part.data()));
    EXPECT_FALSE(store.LoadPart(TestKey(1), ~std::uint64_t{0}, part.size(), part.data()));
    EXPECT_FALSE(store.LoadPart(TestKey(2), 0, part.size(), part.data()));
    EXPECT_EQ(store.Statistics().pagesRejected, 0U);
}

TEST_F(PageStoreTest, TheMappedLengthIsGivenBackAtTheEnd) {
    {
        PageStore store(Options(), &warnings);
        EXPECT_TRUE(Save(&store, 1, 5000));
        EXPECT_NE(store.SegmentData(0), nullptr);
        EXPECT_EQ(std::filesystem::file_size(OnlyFile()), 1U << 20U);
    }
    EXPECT_LT(std::filesystem::file_size(OnlyFile()), 100000U);
    PageStore store(Options(), &warnings);
    EXPECT_TRUE(Has(&store, 1, 5000));
}

TEST_F(PageStoreTest, ManyThreadsSaveAndLoadTheSamePages) {
    PageStore store(Options(512U << 10U), &warnings);
    constexpr std::uint64_t kPages = 400;
    std::atomic<std::uint64_t> loaded{0};
    std::vector<std::thread> threads;
    for (std::uint64_t t = 0; t < 4; ++t) {
        threads.emplace_back([&, t] {
            for (std::uint64_t i = 0; i < kPages; ++i) {
                const std::uint64_t number = (i * 7 + t * 100) % kPages;
                EXPECT_TRUE(Save(&store, number, 50 + number * 11));
                EXPECT_TRUE(Has(&store, number, 50 + number * 11));
                const auto page = store.Locate(TestKey(number));
                ASSERT_TRUE(page.has_value());
                const std::uint8_t* data = store.SegmentData(page->segment);
                ASSERT_NE(data, nullptr);
                const auto expected = TestPage(number, page->bytes);
                EXPECT_EQ(std::memcmp(data + page->offset, expected.data(), expected.size()), 0);
                ++loaded;
            }
        });
    }
    for (std::thread& thread : threads) {
        thread.join();
    }
    EXPECT_EQ(loaded, 4 * kPages);
    EXPECT_EQ(store.Statistics().pagesRejected, 0U);
    PageStore next(Options(), &warnings);
    for (std::uint64_t number = 0; number < kPages; ++number) {
        EXPECT_TRUE(Has(&next, number, 50 + number * 11));
    }
}

TEST_F(PageStoreTest, ClearingWhileOthersSaveAndLoadLeavesRightPages) {
    PageStore store(Options(256U << 10U), &warnings);
    std::atomic<bool> isDone{false};
    std::vector<std::thread> threads;
    for (std::uint64_t t = 0; t < 3; ++t) {
        threads.emplace_back([&, t] {
            for (std::uint64_t i = t; !isDone; ++i) {
                EXPECT_TRUE(Save(&store, i % 300, 1000));
                Has(&store, (i * 7) % 300, 1000); // there or not, but right
                store.Locate(TestKey((i * 11) % 300));
            }
        });
    }
    for (int i = 0; i < 20; ++i) {
        while (store.Statistics().pagesSaved < static_cast<std::uint64_t>(i) * 50) {
            std::this_thread::yield();
        }
        store.Clear();
    }
    isDone = true;
    for (std::thread& thread : threads) {
        thread.join();
    }
    EXPECT_EQ(store.Statistics().pagesRejected, 0U);
    EXPECT_TRUE(warnings.Lines().empty());
}

TEST_F(PageStoreTest, ClearFreesEverythingAndSavingGoesOn) {
    PageStore store(Options(), &warnings);
    EXPECT_TRUE(Save(&store, 1, 5000));
    EXPECT_GE(store.Size(), 5000U);
    EXPECT_GE(PageStore(Options(), &warnings).Clear(), 5000U); // as `hdstream cache --clear`
    EXPECT_EQ(store.Size(), 0U);
    EXPECT_TRUE(Save(&store, 2, 5000)); // into a new file
    EXPECT_TRUE(Has(&store, 2, 5000));
    {
        PageStore next(Options(), &warnings);
        EXPECT_FALSE(Has(&next, 1, 5000));
        EXPECT_TRUE(Has(&next, 2, 5000));
    }
    EXPECT_GE(store.Clear(), 5000U);
    EXPECT_FALSE(Has(&store, 2, 5000));
    EXPECT_TRUE(Save(&store, 3, 5000));
    EXPECT_TRUE(Has(&store, 3, 5000));
    EXPECT_TRUE(warnings.Lines().empty());
}

TEST_F(PageStoreTest, AFullCacheThatAnotherProcessClearsIsFilledAgain) {
    PageStoreOptions options = Options();
    options.maxBytes = 4U << 20U;
    PageStore store(options, &warnings);
    std::uint64_t number = 0;
    while (number < 1000 && Save(&store, number, 60000)) {
        ++number;
    }
    ASSERT_LT(number, 1000U) << "it never was full";
    ASSERT_FALSE(Save(&store, 2000, 60000));
    EXPECT_GT(PageStore(options, &warnings).Clear(), 0U);
    EXPECT_TRUE(Save(&store, 3000, 60000));
    EXPECT_TRUE(Has(&store, 3000, 60000));
}

// Pages that are saved before anybody asks for them must not take the room of those that somebody
// asks for, of this run or of earlier ones, but should have room where they are asked for then.
TEST_F(PageStoreTest, PagesAheadTakeHalfOfWhatIsLeft) {
    constexpr std::size_t kBytes = 60000;
    PageStoreOptions options = Options();
    options.maxBytes = 8U << 20U; // an eighth of a segment is its index
    std::uint64_t number = 0;
    const auto fill = [&](PageStore* store) {
        const std::uint64_t before = number;
        for (; store->HasSpareRoom(); ++number) {
            const std::vector<std::uint8_t> bytes = TestPage(number, kBytes);
            if (!store->SaveAhead(TestKey(number), bytes.data(), bytes.size())) {
                ADD_FAILURE() << "there was room";
                break;
            }
        }
        return double((number - before) * kBytes) / (1U << 20U);
    };
    const auto store = std::make_unique<PageStore>(options, &warnings);
    EXPECT_NEAR(fill(store.get()), 4.0, 0.4);
    EXPECT_EQ(store->NumUsed(), number) << "they belong to what is rendered";
    EXPECT_TRUE(Has(store.get(), 0, kBytes));
    EXPECT_TRUE(Save(store.get(), 1, kBytes)) << "asks as well";
    EXPECT_TRUE(store->HasSpareRoom());
    for (std::uint64_t i = 0; i < number; ++i) {
        EXPECT_EQ(store->Bytes(TestKey(i)), kBytes);
    }
    EXPECT_NEAR(fill(store.get()), 2.0, 0.4);
    EXPECT_EQ(store->NumUsed(), number);
    const std::uint64_t numOld = number;
    PageStore next(options, &warnings);
    for (std::uint64_t i = 0; i < numOld; ++i) {
        EXPECT_EQ(next.Bytes(TestKey(i)), kBytes);
    }
    EXPECT_LT(fill(&next), 1.2) << "of the two that were left";
    next.Clear();
    EXPECT_TRUE(next.HasSpareRoom());
    EXPECT_TRUE(warnings.Lines().empty());
}

TEST_F(PageStoreTest, WhoOnlyLooksRemovesNothing) {
    std::filesystem::create_directories(folder.string());
    const std::string path = folder.string() + "/pages-0123456789abcdef.hdsp";
    std::ofstream(path) << "of another version";
    PageStoreOptions options = Options();
    options.isReadOnly = true;
    PageStore looking(options, &warnings);
    EXPECT_TRUE(std::filesystem::exists(path));
    PageStore working(Options(), &warnings);
    EXPECT_FALSE(std::filesystem::exists(path));
}

} // namespace
} // namespace hds
