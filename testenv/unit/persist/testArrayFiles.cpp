// SPDX-License-Identifier: Apache-2.0
// Files under the arrays of a scene: what is written into one is found out, what takes its place is
// not meant.
#include "hdStream/persist/arrayFiles.h"

#include "hdStream/base/error.h"

#include "testenv/support/temporaryFolder.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>

namespace hds {
namespace {

class ArrayFilesTest : public ::testing::Test {
protected:
    ArrayFilesTest() { Write(path, "first"); }
    ~ArrayFilesTest() override { ArrayFiles::Forget(&source); }

    static void Write(const std::string& file, const char* text) { std::ofstream(file) << text; }
    std::string Problem() const {
        try {
            ArrayFiles::Check(&source);
            return "";
        } catch (const Error& error) {
            return error.what();
        }
    }

    test::TemporaryFolder folder;
    std::string path = folder.Path() + "/stage.usdc";
    ArraySource source{"/M.points", {}, [] { return ArrayBytes(); }};
};

TEST_F(ArrayFilesTest, WhatIsNotWatchedHasNoProblem) {
    EXPECT_EQ(Problem(), "");
    ArrayFiles::Watch(&source, {path, folder.Path() + "/absent"});
    EXPECT_EQ(Problem(), "");
}

TEST_F(ArrayFilesTest, ALongerFileHasBeenWrittenInto) {
    ArrayFiles::Watch(&source, {path});
    const auto time = std::filesystem::last_write_time(path);
    std::ofstream(path, std::ios::app) << "more";
    std::filesystem::last_write_time(path, time);
    EXPECT_EQ(Problem(), path + " has been written into");
    ArrayFiles::Forget(&source);
    EXPECT_EQ(Problem(), "");
}

TEST_F(ArrayFilesTest, ALaterFileHasBeenWrittenInto) {
    ArrayFiles::Watch(&source, {path});
    std::filesystem::last_write_time(path, std::filesystem::last_write_time(path) +
                                               std::chrono::nanoseconds(1000));
    EXPECT_EQ(Problem(), path + " has been written into");
}

TEST_F(ArrayFilesTest, AFileThatIsDeletedOrReplacedIsNotMeant) {
    ArrayFiles::Watch(&source, {path});
    const std::string other = folder.Path() + "/other";
    Write(other, "other and longer");
    std::filesystem::rename(other, path);
    EXPECT_EQ(Problem(), "");
    std::filesystem::remove(path);
    EXPECT_EQ(Problem(), "");
}

} // namespace
} // namespace hds
