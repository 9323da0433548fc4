// SPDX-License-Identifier: Apache-2.0
// The files of a UDIM set.
#include "hdStream/texture/udim.h"

#include "testenv/support/temporaryFolder.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>

namespace hds {
namespace {

TEST(UdimTest, FilesAreFoundByTheirNumber) {
    const test::TemporaryFolder folder;
    for (const char* name : {"a.1001.png", "a.1100.png", "a.1000.png", "a.1101.png", "a.9999.png",
                             "a.10011.png", "a.100x.png", "b.1003.png", "a.1002.jpg"}) {
        std::ofstream(folder.File(name)) << "x";
    }
    const std::vector<UdimFile> files = FindUdimFiles(folder.File("a.<UDIM>.png"));
    ASSERT_EQ(files.size(), 2U);
    EXPECT_EQ(files[0].index, 0U);
    EXPECT_EQ(files[0].place.file, folder.File("a.1001.png"));
    EXPECT_EQ(files[1].index, 99U);
    EXPECT_EQ(files[0].place.size, 0U); // all of it
    EXPECT_TRUE(FindUdimFiles(folder.File("nowhere/a.<UDIM>.png")).empty());
    EXPECT_TRUE(FindUdimFiles(folder.File("a.1001.png")).empty());
}

TEST(UdimTest, TheTokenMayNameFolders) {
    const test::TemporaryFolder folder;
    for (const char* name : {"1001", "1012", "1013"}) {
        std::filesystem::create_directory(folder.File(name));
    }
    std::ofstream(folder.File("1001/a.png")) << "x";
    std::ofstream(folder.File("1012/a.png")) << "x";
    const std::vector<UdimFile> files = FindUdimFiles(folder.File("<UDIM>/a.png"));
    ASSERT_EQ(files.size(), 2U);
    EXPECT_EQ(files[1].index, 11U);
    EXPECT_EQ(files[1].place.file, folder.File("1012/a.png"));
}

TEST(UdimTest, TilesAreNamed) {
    EXPECT_EQ(TileName("a/b.<UDIM>.png", 12), "a/b.1013.png");
    EXPECT_EQ(TileName("a.png", 12), "a.png");
}

} // namespace
} // namespace hds
