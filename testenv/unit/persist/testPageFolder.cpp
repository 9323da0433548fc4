// SPDX-License-Identifier: Apache-2.0
// Folders that cannot be written, run full or vanish cost one warning; the size stays below its
// cap.
#include "testenv/support/fileSizeLimit.h"
#include "testenv/unit/persist/pageFixtures.h"

#include "hdStream/persist/pageFormat.h"

#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <thread>

namespace hds {
namespace {

class PageFolderTest : public PageStoreTest {
protected:
    void ExpectOneWarningOf(const std::filesystem::path& path) const {
        ASSERT_EQ(warnings.Lines().size(), 1U);
        EXPECT_EQ(warnings.Lines()[0].rfind(path.string() + ": ", 0), 0U) << warnings.Lines()[0];
    }
    /// Times of modification of files made one after the other differ.
    static void LetTimePass() { std::this_thread::sleep_for(std::chrono::milliseconds(20)); }
};

TEST_F(PageFolderTest, AFolderThatCannotBeMadeWarnsOnce) {
    test::WriteFile(folder.string(), "a file where the folder should be");
    PageStore store(Options(), &warnings);
    EXPECT_FALSE(Save(&store, 1, 100));
    EXPECT_FALSE(Save(&store, 2, 100));
    EXPECT_FALSE(store.IsWriting());
    EXPECT_FALSE(Has(&store, 1, 100));
    EXPECT_EQ(store.Statistics().pagesNotKept, 2U);
    ExpectOneWarningOf(folder);
}

TEST_F(PageFolderTest, AReadOnlyFolderIsReadAndWarnsOnce) {
    {
        PageStore store(Options(), &warnings);
        EXPECT_TRUE(Save(&store, 1, 100));
    }
    // In a child, which gives up the right of root to write everywhere.
    const pid_t child = ::fork();
    if (child == 0) {
        const auto readable = static_cast<std::filesystem::perms>(0555);
        std::filesystem::permissions(temporary.Path(), readable);
        std::filesystem::permissions(folder, readable);
        if (::geteuid() == 0 && ::setuid(65534) != 0) {
            ::_exit(2);
        }
        PageStore store(Options(), &warnings);
        std::vector<std::uint8_t> data;
        if (!store.Load(TestKey(1), &data) || data != TestPage(1, 100)) {
            ::_exit(2); // not even a folder that others can read, on this machine
        }
        const bool isRight = !Save(&store, 2, 300000) && !Save(&store, 3, 300000) &&
                             store.Load(TestKey(1), &data) && !store.IsWriting() &&
                             warnings.Lines().size() == 1;
        ::_exit(isRight ? 0 : 1);
    }
    int status = 0;
    ASSERT_EQ(::waitpid(child, &status, 0), child);
    std::filesystem::permissions(temporary.Path(), std::filesystem::perms::owner_all);
    std::filesystem::permissions(folder, std::filesystem::perms::owner_all);
    ASSERT_TRUE(WIFEXITED(status));
    if (WEXITSTATUS(status) == 2) {
        GTEST_SKIP() << "no user without rights can be played here";
    }
    EXPECT_EQ(WEXITSTATUS(status), 0);
}

TEST_F(PageFolderTest, ADiskThatRunsFullKeepsWhatIsThere) {
    // Full in every part of saving: the header, the first page, its entry is in front, a later one.
    for (const std::uint64_t room : {std::uint64_t{10}, std::uint64_t{64}, kBlockBytes + 500,
                                     kBlockBytes + 2100, kBlockBytes + 4000}) {
        std::filesystem::remove_all(folder);
        warnings.Clear();
        const std::uint64_t fitting = room < kBlockBytes ? 0 : (room - kBlockBytes + 24) / 1024;
        {
            const test::FileSizeLimit limit(room);
            PageStore store(Options(), &warnings);
            for (std::uint64_t i = 0; i < 6; ++i) {
                EXPECT_EQ(Save(&store, i, 1000), i < fitting) << room;
            }
            for (std::uint64_t i = 0; i < 6; ++i) {
                EXPECT_EQ(Has(&store, i, 1000), i < fitting) << room;
            }
            ExpectOneWarningOf(folder);
        }
        PageStore store(Options(), &warnings); // there is room again
        for (std::uint64_t i = 0; i < 6; ++i) {
            EXPECT_EQ(Has(&store, i, 1000), i < fitting) << room;
            EXPECT_TRUE(Save(&store, i, 1000));
            EXPECT_TRUE(Has(&store, i, 1000));
        }
    }
}

TEST_F(PageFolderTest, AFullDiskRefusesTheMappingNotThePages) {
    PageStore store(Options(), &warnings);
    EXPECT_TRUE(Save(&store, 1, 1000));
    const test::FileSizeLimit limit(200000);
    EXPECT_EQ(store.SegmentData(0), nullptr);
    EXPECT_TRUE(Has(&store, 1, 1000));
    EXPECT_TRUE(Save(&store, 2, 1000));
}

TEST_F(PageFolderTest, AFolderThatVanishesWarnsOnce) {
    PageStore store(Options(), &warnings);
    EXPECT_TRUE(Save(&store, 1, 1000));
    std::filesystem::remove_all(folder);
    EXPECT_FALSE(Save(&store, 2, 1000));
    EXPECT_FALSE(Save(&store, 3, 1000));
    EXPECT_TRUE(Has(&store, 1, 1000)); // the file lives while it is open
    EXPECT_FALSE(std::filesystem::exists(folder));
    ExpectOneWarningOf(folder);
}

TEST_F(PageFolderTest, OneProcessStopsAtTheCap) {
    PageStoreOptions options = Options(256U << 10U);
    options.maxBytes = 1U << 20U;
    PageStore store(options, &warnings);
    std::uint64_t kept = 0;
    for (std::uint64_t i = 0; i < 100; ++i) {
        kept += Save(&store, i, 50000) ? 1 : 0;
        EXPECT_LE(store.Size(), options.maxBytes);
    }
    EXPECT_GE(kept, 10U);
    EXPECT_EQ(store.Statistics().pagesNotKept, 100 - kept);
    for (std::uint64_t i = 0; i < kept; ++i) {
        EXPECT_TRUE(Has(&store, i, 50000));
    }
    EXPECT_TRUE(warnings.Lines().empty());
    EXPECT_GT(store.Clear(), 0U);
    EXPECT_TRUE(Save(&store, 200, 50000)); // there is room again
}

TEST_F(PageFolderTest, TheLeastRecentlyUsedSegmentLeavesFirst) {
    PageStoreOptions options = Options(256U << 10U);
    options.maxBytes = 1152U << 10U;        // five of the 192 KiB that a page takes, not six
    for (std::uint64_t i = 0; i < 3; ++i) { // three full segments
        PageStore store(options, &warnings);
        EXPECT_TRUE(Save(&store, i, 190000));
        LetTimePass();
    }
    {
        PageStore store(options, &warnings);
        EXPECT_TRUE(Has(&store, 0, 190000)); // page 1 is the oldest now
        LetTimePass();
    }
    PageStore store(options, &warnings);
    EXPECT_TRUE(store.Contains(TestKey(1)));
    EXPECT_TRUE(Save(&store, 3, 190000));
    EXPECT_TRUE(Save(&store, 4, 190000));
    EXPECT_TRUE(store.Contains(TestKey(1)));
    EXPECT_TRUE(Save(&store, 5, 190000));
    EXPECT_FALSE(store.Contains(TestKey(1)));
    for (const std::uint64_t i : {0, 2, 3, 4, 5}) {
        EXPECT_TRUE(Has(&store, i, 190000)) << i;
    }
    EXPECT_LE(store.Size(), options.maxBytes);
}

TEST_F(PageFolderTest, WhatALiveProcessUsesStays) {
    PageStoreOptions options = Options(256U << 10U);
    options.maxBytes = 512U << 10U;
    {
        PageStore store(options, &warnings);
        EXPECT_TRUE(Save(&store, 1, 190000));
    }
    LetTimePass();
    PageStore reader(options, &warnings);
    EXPECT_TRUE(Has(&reader, 1, 190000));
    PageStore store(options, &warnings); // locks are of open files, as between processes
    EXPECT_TRUE(Save(&store, 2, 190000));
    EXPECT_FALSE(Save(&store, 3, 190000));
    PageStore next(options, &warnings);
    EXPECT_TRUE(Has(&next, 1, 190000));
    EXPECT_TRUE(Has(&next, 2, 190000));
}

TEST_F(PageFolderTest, ALowerCapTrimsWhenTheFolderIsOpened) {
    {
        PageStore store(Options(256U << 10U), &warnings);
        for (std::uint64_t i = 0; i < 10; ++i) {
            EXPECT_TRUE(Save(&store, i, 190000));
        }
    }
    PageStoreOptions options = Options(256U << 10U);
    options.maxBytes = 500000;
    PageStore store(options, &warnings);
    EXPECT_LE(store.Size(), options.maxBytes);
    EXPECT_GE(store.Size(), 190000U);
}

} // namespace
} // namespace hds
