// SPDX-License-Identifier: Apache-2.0
// Entries of packages, made by hand byte by byte.
#include "hdStream/persist/packageFile.h"

#include "testenv/support/temporaryFolder.h"

#include <gtest/gtest.h>
#include <sys/stat.h>

#include <filesystem>
#include <random>

namespace hds {
namespace {

std::string Little(std::uint64_t number, int bytes) {
    std::string text;
    for (int i = 0; i < bytes; ++i) {
        text += static_cast<char>(number >> (8 * i) & 0xffU);
    }
    return text;
}

struct Item {
    std::string name;
    std::string content;
    std::uint32_t method = 0; ///< 8: deflate
    std::uint32_t flags = 0;
    std::size_t paddingBytes = 0; ///< of the local header alone, as usdz aligns
};

/// A zip file of items; nothing of them is compressed, whatever they say.
std::string Zip(const std::vector<Item>& items, const std::string& comment = "") {
    std::string file;
    std::string directory;
    for (const Item& item : items) {
        const std::size_t header = file.size();
        const std::string common = Little(20, 2) + Little(item.flags, 2) + Little(item.method, 2) +
                                   Little(0, 8) + Little(item.content.size(), 4) +
                                   Little(item.content.size(), 4) + Little(item.name.size(), 2);
        file += "PK\3\4" + common + Little(item.paddingBytes, 2) + item.name +
                std::string(item.paddingBytes, '\0') + item.content;
        directory += "PK\1\2" + Little(20, 2) + common + Little(0, 2 + 2 + 2 + 2 + 4) +
                     Little(header, 4) + item.name;
    }
    const std::size_t start = file.size();
    return file + directory + "PK\5\6" + Little(0, 4) + Little(items.size(), 2) +
           Little(items.size(), 2) + Little(directory.size(), 4) + Little(start, 4) +
           Little(comment.size(), 2) + comment;
}

std::string ContentOf(const std::string& path) {
    const std::optional<ByteRange> range = FindInPackage(path);
    if (!range) {
        return "not found";
    }
    return test::ReadFile(range->file).substr(range->offset, range->size);
}

TEST(PackageFileTest, EntriesAreFoundWhereTheyAre) {
    const test::TemporaryFolder folder;
    const std::string inner = Zip({{"c.png", "deep", 0, 0, 13}, {"a[1].png", "bracket", 0, 0, 0}});
    const std::string path = folder.File("p[1].usdz");
    test::WriteFile(path, Zip({{"a.png", "first", 0, 0, 60},
                               {"tex/Gr\xc3\xbcn.png", "second", 0, 0, 0},
                               {"inner.usdz", inner, 0, 0, 7},
                               {"deflated.png", "third", 8, 0, 0},
                               {"locked.png", "fourth", 0, 1, 0}},
                              "a comment"));
    EXPECT_EQ(ContentOf(path + "[a.png]"), "first");
    EXPECT_EQ(ContentOf(path + "[tex/Gr\xc3\xbcn.png]"), "second");
    EXPECT_EQ(ContentOf(path + "[inner.usdz[c.png]]"), "deep");
    EXPECT_EQ(ContentOf(path + "[inner.usdz[a\\[1\\].png]]"), "bracket");
    for (const char* name : {"[deflated.png]", "[locked.png]", "[none.png]", "[inner.usdz[none]]",
                             "[a.png[b.png]]", "[none.usdz[b.png]]", "[]", "", "]", "a]"}) {
        EXPECT_EQ(ContentOf(path + name), "not found") << name;
    }
    EXPECT_EQ(ContentOf(folder.File("none.usdz") + "[a.png]"), "not found");
    const std::optional<PackageFile> nested = PackageFile::Open(path + "[inner.usdz]");
    ASSERT_TRUE(nested);
    EXPECT_EQ(nested->Names(), (std::vector<std::string>{"c.png", "a[1].png"}));
}

/// As studios have them: the present version of an asset is a link.
TEST(PackageFileTest, LinksAreFollowed) {
    const test::TemporaryFolder folder;
    test::WriteFile(folder.File("v2.usdz"), Zip({{"a.png", "first", 0, 0, 7}}));
    std::filesystem::create_symlink("v2.usdz", folder.File("now.usdz"));
    EXPECT_EQ(ContentOf(folder.File("now.usdz") + "[a.png]"), "first");
}

/// Nobody writes into it: waiting for that would be for ever.
TEST(PackageFileTest, PipesHaveNoEntries) {
    const test::TemporaryFolder folder;
    ASSERT_EQ(::mkfifo(folder.File("p.usdz").c_str(), 0600), 0);
    EXPECT_EQ(ContentOf(folder.File("p.usdz") + "[a.png]"), "not found");
}

/// What is cut off or overwritten is not found, or lies inside of the file.
TEST(PackageFileTest, DamagedPackagesAreNoDanger) {
    const test::TemporaryFolder folder;
    const std::string whole =
        Zip({{"a.png", "first", 0, 0, 9}, {"p.usdz", Zip({{"b.png", "x", 0, 0, 0}}), 0, 0, 0}});
    const std::string path = folder.File("p.usdz");
    std::mt19937 random(3);
    std::size_t numFound = 0;
    for (int i = 0; i < 3000; ++i) {
        std::string bytes = whole;
        if (i % 3 == 0) {
            bytes.resize(random() % bytes.size());
        }
        for (std::size_t k = 0; k < 1 + random() % 3 && !bytes.empty(); ++k) {
            bytes[random() % bytes.size()] = static_cast<char>(random());
        }
        test::WriteFile(path, bytes);
        for (const char* name : {"[a.png]", "[p.usdz[b.png]]"}) {
            if (const std::optional<ByteRange> range = FindInPackage(path + name)) {
                ++numFound;
                ASSERT_LE(range->offset + range->size, bytes.size());
            }
        }
    }
    EXPECT_GT(numFound, 100U);
}

} // namespace
} // namespace hds
