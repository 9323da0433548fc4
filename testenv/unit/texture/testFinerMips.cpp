// SPDX-License-Identifier: Apache-2.0
// Mips that are made when a line of them is read. Oracle: the lines of the same file, all made at
// once and kept in memory.
#include "hdStream/texture/keptImage.h"
#include "hdStream/texture/textureLayout.h"
#include "hdStream/texture/textureLines.h"
#include "testenv/unit/texture/textureFixtures.h"

#include <tbb/task_arena.h>

#include <cstring>
#include <filesystem>
#include <thread>

namespace hds {
namespace {

constexpr std::uint64_t kFew = 80 * 80; ///< texels that the tests make at once
constexpr std::uint64_t kNoneKept = 0;
constexpr std::uint64_t kAllKept = TexturePreparer::kKeptBytes;

class FinerMipsTest : public TextureTest {
protected:
    struct Image {
        std::string path;
        std::string colorSpace;
    };

    /// One of each way in which rows are read and stored.
    std::vector<Image> Images() {
        return {{WriteImage("rgb.png", 500, 333, 3, OIIO::TypeUInt8), "sRGB"},
                {WriteImage("gray.png", 512, 512, 1, OIIO::TypeUInt8), "raw"},
                {WriteImage("two.png", 301, 600, 2, OIIO::TypeUInt8), "raw"},
                {WriteImage("deep.png", 300, 200, 3, OIIO::TypeUInt16), "sRGB"},
                {WriteImage("half.exr", 300, 260, 4, OIIO::TypeHalf), "raw"},
                {WriteImage("float.tif", 300, 260, 1, OIIO::TypeFloat), "raw"},
                {WriteImage("named.png", 200, 300, 3, OIIO::TypeUInt8), "ACEScg"}};
    }

    std::vector<TextureLine> Expected(const Image& image) {
        TexturePreparer preparer(nullptr, &warnings);
        const auto texture = preparer.Prepare({image.path, 0, 0, ""}, Request(image.colorSpace),
                                              TexturePreparer::kAllTexels);
        EXPECT_TRUE(texture->HasLine(0));
        return AllLines(*texture);
    }
};

TEST_F(FinerMipsTest, AreMadeWhenTheyAreRead) {
    for (const Image& image : Images()) {
        const std::vector<TextureLine> expected = Expected(image);
        for (const bool hasStore : {false, true}) {
            for (const int how : {0, 1, 2, 3}) {
                const bool coarseFirst = how % 2 == 1;
                std::filesystem::remove_all(folder.File("cache"));
                TexturePreparer preparer(hasStore ? OpenStore() : nullptr, &warnings,
                                         how < 2 ? kNoneKept : kAllKept);
                const auto texture =
                    preparer.Prepare({image.path, 0, 0, ""}, Request(image.colorSpace), kFew);
                const auto last = static_cast<std::uint32_t>(expected.size() - 1);
                EXPECT_FALSE(texture->HasLine(0)) << image.path;
                EXPECT_TRUE(texture->HasLine(last)) << image.path;
                std::vector<TextureLine> lines(expected.size());
                for (std::uint32_t i = 0; i <= last; ++i) {
                    const std::uint32_t line = coarseFirst ? last - i : i;
                    EXPECT_TRUE(texture->ReadLine(line, &lines[line]));
                }
                EXPECT_EQ(lines, expected) << image.path << hasStore << how;
                EXPECT_EQ(texture->HostBytes() == 0, hasStore);
            }
        }
    }
    EXPECT_EQ(warnings.Lines(), std::vector<std::string>());
}

TEST_F(FinerMipsTest, OfAFileAreTheMipThatIsAskedAndCoarserOnes) {
    const std::string path = WriteImage("rgb.png", 1024, 1024, 3, OIIO::TypeUInt8);
    TexturePreparer preparer(OpenStore(), &warnings, kNoneKept);
    const auto texture = preparer.Prepare({path, 0, 0, ""}, Request("sRGB"), kFew);
    const std::uint32_t second = FirstLineOf(texture->Record(), 1);
    EXPECT_EQ(second, 4096u); // lines of 16 x 16
    EXPECT_EQ(MipOfLine(texture->Record(), second - 1), 0u);
    EXPECT_EQ(MipOfLine(texture->Record(), second), 1u);
    EXPECT_EQ(MipOfLine(texture->Record(), texture->NumLines() - 1), 7u); // 8 x 8 and less share it
    EXPECT_FALSE(texture->HasLine(second + 1000));
    TextureLine line;
    EXPECT_TRUE(texture->ReadLine(second + 1000, &line));
    for (std::uint32_t i = second; i < texture->NumLines(); ++i) {
        EXPECT_TRUE(texture->HasLine(i)) << i;
    }
    EXPECT_FALSE(texture->HasLine(second - LineStore::kGroupLines));
}

TEST_F(FinerMipsTest, OfAKeptImageAreTheGroupsThatAreAsked) {
    const std::string path = WriteImage("rgb.png", 1024, 1024, 3, OIIO::TypeUInt8);
    TexturePreparer preparer(OpenStore(), &warnings, kAllKept);
    const auto texture = preparer.Prepare({path, 0, 0, ""}, Request("sRGB"), kFew);
    WriteImage("rgb.png", 8, 8, 3, OIIO::TypeUInt8); // the file is not asked
    const std::uint32_t asked = 4096 + 1000;
    texture->MakeLines({asked, 300});
    for (std::uint32_t line = 0; line < FirstLineOf(texture->Record(), 3); ++line) {
        const std::uint32_t group = line / LineStore::kGroupLines;
        EXPECT_EQ(texture->HasLine(line),
                  group == asked / LineStore::kGroupLines || group == 300 / LineStore::kGroupLines)
            << line;
    }
    EXPECT_EQ(warnings.Lines(), std::vector<std::string>());
}

TEST_F(FinerMipsTest, OfOddSizesAreFilteredAlike) {
    // Every parity of width and height at several mips; a group is less than a row of lines.
    for (const auto& [width, height] : {std::pair(2047, 97), {1555, 331}, {130, 1023}, {4097, 5}}) {
        const std::string path = WriteImage("odd.png", width, height, 3, OIIO::TypeUInt8);
        const std::vector<TextureLine> expected = Expected({path, "sRGB"});
        TexturePreparer preparer(nullptr, &warnings, kAllKept);
        const auto texture = preparer.Prepare({path, 0, 0, ""}, Request("sRGB"), 64);
        EXPECT_EQ(AllLines(*texture), expected) << width << "x" << height;
    }
}

TEST(KeptImages, ThoseThatWereUsedLongestAgoLeave) {
    TextureForm form;
    form.numChannels = 1;
    form.sources = {0, -1, -1, -1};
    const auto image = std::make_shared<KeptImage>(CodeRows(form, false, {0, -1, -1, -1}, 1), 100,
                                                   10); // 1000 bytes
    KeptImages images(2500);
    EXPECT_TRUE(images.Fits(2500));
    EXPECT_FALSE(images.Fits(2501));
    const auto keyOf = [](std::uint64_t i) { return PageKey{{i, i}}; };
    images.Add(keyOf(1), image);
    images.Add(keyOf(2), image);
    EXPECT_NE(images.Find(keyOf(1)), nullptr);
    images.Add(keyOf(3), image);
    EXPECT_EQ(images.Find(keyOf(2)), nullptr);
    EXPECT_NE(images.Find(keyOf(1)), nullptr);
    EXPECT_NE(images.Find(keyOf(3)), nullptr);
}

TEST_F(FinerMipsTest, AreMadeByALaterProcess) {
    for (const Image& image : Images()) {
        const std::vector<TextureLine> expected = Expected(image);
        for (std::uint64_t process = 0; process < 3; ++process) {
            TexturePreparer preparer(OpenStore(), &warnings);
            const auto texture =
                preparer.Prepare({image.path, 0, 0, ""}, Request(image.colorSpace), kFew);
            EXPECT_EQ(preparer.NumBuilt(), process == 0 ? 1u : 0u);
            EXPECT_EQ(texture->HasLine(0), process == 2) << image.path;
            if (process == 1) {
                EXPECT_EQ(AllLines(*texture), expected) << image.path;
            }
        }
    }
}

TEST_F(FinerMipsTest, ThreadsMayAskForThemAtOnce) {
    const Image image = Images().front();
    const std::vector<TextureLine> expected = Expected(image);
    TexturePreparer preparer(OpenStore(), &warnings);
    const auto texture = preparer.Prepare({image.path, 0, 0, ""}, Request(image.colorSpace), kFew);
    std::vector<std::vector<TextureLine>> lines(4, std::vector<TextureLine>(expected.size()));
    std::vector<std::thread> threads;
    for (std::size_t thread = 0; thread < lines.size(); ++thread) {
        threads.emplace_back([&, thread] {
            for (std::size_t i = 0; i < expected.size(); ++i) {
                const std::size_t line = (i * 7 + thread * 97) % expected.size();
                texture->ReadLine(static_cast<std::uint32_t>(line), &lines[thread][line]);
            }
        });
    }
    for (std::thread& thread : threads) {
        thread.join();
    }
    for (const auto& read : lines) {
        for (std::size_t i = 0; i < expected.size(); ++i) {
            EXPECT_EQ(read[i], expected[i]) << i;
        }
    }
}

TEST_F(FinerMipsTest, OfAFileThatHasChangedAreBlackAndWarnedOfOnce) {
    const std::string path = WriteImage("rgb.png", 512, 512, 3, OIIO::TypeUInt8);
    const std::vector<TextureLine> expected = Expected({path, "sRGB"});
    TexturePreparer preparer(OpenStore(), &warnings, kNoneKept);
    const auto texture = preparer.Prepare({path, 0, 0, ""}, Request("sRGB"), kFew);
    WriteImage("rgb.png", 511, 512, 3, OIIO::TypeUInt8);
    TextureLine line;
    EXPECT_FALSE(texture->ReadLine(0, &line));
    EXPECT_EQ(line, TextureLine{});
    EXPECT_FALSE(texture->ReadLine(1, &line));
    const auto last = static_cast<std::uint32_t>(expected.size() - 1);
    EXPECT_TRUE(texture->ReadLine(last, &line)); // what was made stays
    EXPECT_EQ(line, expected.back());
    ASSERT_EQ(warnings.Lines().size(), 1u);
    EXPECT_NE(warnings.Lines()[0].find("rgb.png"), std::string::npos);
}

TEST_F(FinerMipsTest, OfSeveralTexturesAreMadeFromOneList) {
    std::vector<TextureImage> images;
    std::vector<std::vector<TextureLine>> expected;
    for (const char* name : {"a.png", "b.png", "c.png"}) {
        const std::string path = WriteImage(name, 1900, 1300, 3, OIIO::TypeUInt8);
        images.push_back({{path, 0, 0, ""}, Request("raw"), images.size(), 1 << 20});
        expected.push_back(Expected({path, "raw"}));
    }
    TextureLines lines(std::make_shared<TexturePreparer>(OpenStore(), &warnings), images);
    EXPECT_TRUE(lines.Open({0, 1, 2}, false, {}));
    std::vector<LineId> ids;
    for (std::uint32_t i = 0; i < 600; ++i) {
        ids.push_back({i % 3, (600 - i) * 16});
    }
    std::vector<std::uint8_t> bytes(ids.size() * HDS_LINE_BYTES);
    EXPECT_TRUE(lines.Read(ids, bytes.data(), {}));
    for (std::size_t i = 0; i < ids.size(); ++i) {
        ASSERT_EQ(std::memcmp(&bytes[i * HDS_LINE_BYTES],
                              expected[ids[i].texture][ids[i].line].data(), HDS_LINE_BYTES),
                  0)
            << i;
    }
}

TEST_F(FinerMipsTest, WhoCancelsWaitsForOneImageOnly) {
    tbb::task_arena alone(1);
    std::vector<TextureImage> images;
    std::vector<std::string> paths;
    for (const char* name : {"a.png", "b.png", "c.png", "d.png"}) {
        const std::string path = WriteImage(name, 1900, 1300, 3, OIIO::TypeUInt8);
        paths.push_back(path);
        images.push_back({{path, 0, 0, ""}, Request("raw"), images.size(), 1 << 20});
    }
    TextureLines lines(std::make_shared<TexturePreparer>(OpenStore(), &warnings, kNoneKept),
                       images);
    int numAsked = 0;
    const auto isSecond = [&] { return ++numAsked == 2; };
    alone.execute([&] {
        EXPECT_FALSE(lines.Open({0, 1, 2, 3}, false, isSecond));
        EXPECT_EQ(lines.NumBuilt(), 2U);
        EXPECT_EQ(numAsked, 2) << "it is not asked again";
        EXPECT_TRUE(lines.Open({0, 1, 2, 3}, false, [] { return false; }));
        EXPECT_EQ(lines.NumBuilt(), 4U);
        // Lines of the finest mips, which are made of the files.
        const std::vector<LineId> ids = {{0, 0}, {1, 0}, {2, 0}, {3, 0}};
        std::vector<std::uint8_t> bytes(ids.size() * HDS_LINE_BYTES);
        numAsked = 0;
        EXPECT_FALSE(lines.Read(ids, bytes.data(), isSecond));
        EXPECT_EQ(numAsked, 2);
        EXPECT_TRUE(lines.Read(ids, bytes.data(), [] { return false; }));
        for (std::size_t i = 0; i < ids.size(); ++i) {
            EXPECT_EQ(std::memcmp(&bytes[i * HDS_LINE_BYTES], Expected({paths[i], "raw"})[0].data(),
                                  HDS_LINE_BYTES),
                      0);
        }
    });
}

} // namespace
} // namespace hds
