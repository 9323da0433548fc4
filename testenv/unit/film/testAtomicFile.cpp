// SPDX-License-Identifier: Apache-2.0
// Full disks are played by the limit on file sizes (RLIMIT_FSIZE): writes beyond it are short and
// fail with EFBIG, as they do with ENOSPC on a full disk, and no privilege is needed.
#include "hdStream/film/atomicFile.h"

#include "hdStream/base/error.h"
#include "testenv/support/fileSizeLimit.h"
#include "testenv/support/temporaryFolder.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <functional>

namespace {

using hds::test::ReadFile;
using hds::test::TemporaryFolder;
using hds::test::WriteFile;

std::string ErrorOf(const std::function<void()>& action) {
    try {
        action();
    } catch (const hds::Error& error) {
        return error.what();
    }
    return {};
}

TEST(AtomicFile, AppearsOnCommitOnly) {
    const TemporaryFolder folder;
    const std::string target = folder.File("out.bin");
    {
        hds::AtomicFile file(target);
        EXPECT_EQ(file.Write("hello", 5), 5u);
        EXPECT_FALSE(std::filesystem::exists(target));
        EXPECT_EQ(file.Tell(), 5);
        EXPECT_TRUE(file.Seek(1));
        file.Write("u", 1);
        file.Commit();
    }
    EXPECT_EQ(ReadFile(target), "hullo");
    EXPECT_EQ(folder.NumEntries(), 1u);
}

TEST(AtomicFile, LeavesNothingWithoutCommit) {
    const TemporaryFolder folder;
    const std::string target = folder.File("out.bin");
    WriteFile(target, "precious");
    {
        hds::AtomicFile file(target);
        file.Write("half", 4);
    }
    EXPECT_EQ(ReadFile(target), "precious");
    EXPECT_EQ(folder.NumEntries(), 1u);
}

TEST(AtomicFile, FullDiskNamesFileAndReasonAndKeepsTheOld) {
    const TemporaryFolder folder;
    const std::string target = folder.File("out.bin");
    WriteFile(target, "precious");
    const std::string bytes(200000, 'x');
    std::string message;
    {
        const hds::test::FileSizeLimit limit(100000);
        message = ErrorOf([&] {
            hds::AtomicFile file(target);
            file.Write(bytes.data(), bytes.size());
            file.Commit();
        });
    }
    EXPECT_NE(message.find("'" + target + "'"), std::string::npos) << message;
    EXPECT_NE(message.find("too large"), std::string::npos) << message;
    EXPECT_EQ(ReadFile(target), "precious");
    EXPECT_EQ(folder.NumEntries(), 1u);
}

TEST(AtomicFile, FailureThatShowsWhenBuffersAreFlushed) {
    const TemporaryFolder folder;
    const std::string target = folder.File("out.bin");
    std::string message;
    {
        const hds::test::FileSizeLimit limit(10);
        message = ErrorOf([&] {
            hds::AtomicFile file(target);
            EXPECT_EQ(file.Write("some more bytes", 15), 15u); // still in the buffer
            file.Commit();
        });
    }
    EXPECT_NE(message.find(target), std::string::npos) << message;
    EXPECT_EQ(folder.NumEntries(), 0u);
}

TEST(AtomicFile, WrongTargetsNameThemselves) {
    const TemporaryFolder folder;
    WriteFile(folder.File("file"), "x");
    const std::string missingFolder = folder.File("no/such/out.exr");
    const std::string throughFile = folder.File("file/out.exr");
    for (const std::string& target : {missingFolder, throughFile, folder.Path()}) {
        const std::string message = ErrorOf([&] { hds::AtomicFile file(target); });
        EXPECT_NE(message.find("'" + target + "'"), std::string::npos) << message;
        EXPECT_EQ(message.find('\n'), std::string::npos);
    }
    EXPECT_NE(ErrorOf([&] { hds::AtomicFile file("/dev/null"); }).find("regular"),
              std::string::npos);
    EXPECT_TRUE(std::filesystem::is_character_file("/dev/null"));
    EXPECT_EQ(folder.NumEntries(), 1u);
}

TEST(AtomicFile, FollowsLinks) {
    const TemporaryFolder folder;
    std::filesystem::create_directory(folder.File("there"));
    const std::string real = folder.File("there/real.bin");
    WriteFile(real, "old");
    const std::string link = folder.File("link.bin");
    std::filesystem::create_symlink(real, link);
    hds::AtomicFile file(link);
    file.Write("new", 3);
    file.Commit();
    EXPECT_TRUE(std::filesystem::is_symlink(link));
    EXPECT_EQ(ReadFile(real), "new");
}

} // namespace
