// SPDX-License-Identifier: Apache-2.0
// Prepared textures in the persistent store: found again, not mixed up, whole again after damage.
// Oracle: the lines of the same file prepared without a store.
#include "testenv/unit/texture/textureFixtures.h"

#include <algorithm>
#include <cstring>
#include <filesystem>
#include <thread>
#include <tuple>

namespace hds {
namespace {

using test::ReadFile;
using test::WriteFile;

class TextureStoreTest : public TextureTest {
protected:
    /// Whether the texture had to be built, in a process of its own as far as the store goes.
    bool IsBuilt(const ImageSource& source, const TextureRequest& request) {
        TexturePreparer preparer(OpenStore(), &warnings);
        const auto texture = preparer.Prepare(source, request);
        EXPECT_TRUE(texture->Ok()) << texture->Description().error;
        EXPECT_EQ(AllLines(*texture).size(), texture->NumLines());
        return preparer.NumBuilt() == 1;
    }
};

TEST_F(TextureStoreTest, ASecondProcessFindsTheSameTexture) {
    const std::string path = WriteImage("image.exr", 300, 200, 4, OIIO::TypeHalf);
    const auto plain = Prepare(path);
    {
        TexturePreparer preparer(OpenStore(), &warnings);
        const auto texture = preparer.Prepare({path, 0, 0, ""}, Request("raw"));
        EXPECT_EQ(preparer.NumBuilt(), 1u);
        EXPECT_EQ(texture->HostBytes(), 0u);
        EXPECT_EQ(AllLines(*texture), AllLines(*plain));
    }
    TexturePreparer preparer(OpenStore(), &warnings);
    const auto texture = preparer.Prepare({path, 0, 0, ""}, Request("raw"));
    EXPECT_EQ(preparer.NumBuilt(), 0u);
    EXPECT_EQ(std::memcmp(&texture->Record(), &plain->Record(), sizeof(shared::HdsTexture)), 0);
    EXPECT_EQ(texture->Description().info.channelType, "half");
    EXPECT_EQ(texture->Description().info.bytesDecoded, 300u * 200 * 8);
    EXPECT_EQ(AllLines(*texture), AllLines(*plain));
    EXPECT_GT(texture->NumLines(), LineStore::kGroupLines); // several pages
}

// What was saved of a file that changed while it was read.
TEST_F(TextureStoreTest, LinesThatAreForgottenAreAbsentFromThenOn) {
    const PageKey key{{7, 8}};
    const std::uint32_t numLines = 2 * LineStore::kGroupLines + 5;
    const auto fill = [&](LineStore* lines) {
        for (std::uint32_t line = 0; line < numLines; ++line) {
            lines->Open(line)->fill(line);
            lines->Complete(line, 1);
        }
    };
    const auto store = OpenStore();
    LineStore lines(store, key, numLines);
    fill(&lines);
    ASSERT_TRUE(LineStore(OpenStore(), key, numLines).Has(numLines - 1));
    lines.ForgetSaved();
    for (const std::uint32_t line : {0U, LineStore::kGroupLines, numLines - 1}) {
        EXPECT_FALSE(LineStore(store, key, numLines).Has(line)) << line;
        EXPECT_FALSE(LineStore(OpenStore(), key, numLines).Has(line)) << line;
    }
    LineStore again(store, key, numLines);
    fill(&again);
    TextureLine line{};
    ASSERT_TRUE(LineStore(OpenStore(), key, numLines).Read(numLines - 1, &line));
    EXPECT_EQ(line[0], numLines - 1);
}

TEST_F(TextureStoreTest, TheDescriptionIsKeptWhole) {
    const std::string path =
        WriteImage("part.exr", 300, 200, 1, OIIO::TypeFloat, [](int x, int y, int) {
            return x == 0 && y == 0 ? std::nan("") : (x < 200 ? 0.5 : Waves(x, y, 0));
        });
    const ImageSource source{path, 0, 0, ""};
    TextureDescription first;
    for (int process = 0; process < 2; ++process) {
        TexturePreparer preparer(OpenStore(), &warnings);
        const TextureDescription second = preparer.Prepare(source, Request("raw"))->Description();
        EXPECT_EQ(preparer.NumBuilt(), process == 0 ? 1u : 0u);
        if (process == 0) {
            first = second;
        }
        EXPECT_EQ(second.numNonFinite, 1u);
        EXPECT_EQ(second.warning, first.warning);
        EXPECT_EQ(second.info.fileFormat, "openexr");
    }
}

TEST_F(TextureStoreTest, WhateverTheTextureDependsOnChangesTheKey) {
    const std::string path = WriteImage("image.png", 40, 40, 3, OIIO::TypeUInt8);
    const ImageSource source{path, 0, 0, ""};
    EXPECT_TRUE(IsBuilt(source, Request("raw")));
    EXPECT_FALSE(IsBuilt(source, Request("raw")));
    EXPECT_TRUE(IsBuilt(source, Request("sRGB")));
    EXPECT_TRUE(IsBuilt(source, Request("ACEScg")));
    EXPECT_TRUE(IsBuilt(source, Request("raw", TextureRequest::kRed)));
    EXPECT_FALSE(IsBuilt(source, Request("ACEScg")));
    // A newer and an older file; the same size and time with other bytes at the end (PNG's CRCs).
    const auto time = std::filesystem::last_write_time(path);
    std::filesystem::last_write_time(path, time - std::chrono::hours(1));
    EXPECT_TRUE(IsBuilt(source, Request("raw")));
    std::filesystem::last_write_time(path, time);
    EXPECT_FALSE(IsBuilt(source, Request("raw")));
    const std::string bytes = ReadFile(path);
    WriteImage("image.png", 40, 40, 3, OIIO::TypeUInt8,
               [](int x, int y, int c) { return Waves(y, x, c); });
    std::string other = ReadFile(path);
    ASSERT_NE(other, bytes);
    other.resize(std::max(other.size(), bytes.size()), '\0');
    WriteFile(path, other);
    std::filesystem::last_write_time(path, time);
    EXPECT_TRUE(IsBuilt(source, Request("raw")));
}

TEST_F(TextureStoreTest, HeadersAreKept) {
    const std::string path = WriteImage("image.exr", 30, 20, 4, OIIO::TypeHalf);
    const ImageSource source{path, 0, 0, ""};
    const ImageInfo plain = ProbeImage(source);
    ASSERT_TRUE(plain.Ok() && plain.hasAlpha);
    for (std::uint64_t process = 0; process < 2; ++process) {
        const auto store = OpenStore();
        const ImageInfo info = ProbeImage(source, store.get());
        EXPECT_EQ(store->Statistics().pagesLoaded, process);
        EXPECT_EQ(store->Statistics().pagesSaved, 1u - process);
        EXPECT_TRUE(info.Ok());
        EXPECT_EQ(std::tie(info.width, info.height, info.channels, info.hasAlpha, info.wrapS),
                  std::tie(plain.width, plain.height, plain.channels, plain.hasAlpha, plain.wrapS));
        EXPECT_EQ(std::tie(info.fileFormat, info.channelType, info.autoColorSpace, info.wrapT,
                           info.bytesDecoded),
                  std::tie(plain.fileFormat, plain.channelType, plain.autoColorSpace, plain.wrapT,
                           plain.bytesDecoded));
    }
    WriteImage("image.exr", 31, 20, 3, OIIO::TypeHalf);
    EXPECT_EQ(ProbeImage(source, OpenStore().get()).width, 31u);
    WriteFile(path, "no image");
    const auto store = OpenStore();
    EXPECT_EQ(ProbeImage(source, store.get()).error, ProbeImage(source).error);
    EXPECT_EQ(store->Statistics().pagesSaved, 0u);
}

TEST_F(TextureStoreTest, PackagesHoldManyTextures) {
    const std::string a = ReadFile(WriteImage("a.png", 40, 40, 3, OIIO::TypeUInt8));
    const std::string b = ReadFile(WriteImage("b.png", 20, 20, 1, OIIO::TypeUInt8));
    const std::string package = folder.File("package.usdz");
    WriteFile(package, std::string(64, 'x') + a + b);
    const ImageSource first{package, 64, a.size(), "package.usdz[a.png]"};
    const ImageSource second{package, 64 + a.size(), b.size(), "package.usdz[b.png]"};
    TexturePreparer preparer(OpenStore(), &warnings);
    EXPECT_EQ(AllLines(*preparer.Prepare(first, Request("raw"))),
              AllLines(*Prepare(folder.File("a.png"))));
    EXPECT_EQ(AllLines(*preparer.Prepare(second, Request("raw"))),
              AllLines(*Prepare(folder.File("b.png"))));
    EXPECT_EQ(preparer.NumBuilt(), 2u);
}

TEST_F(TextureStoreTest, DamagedLinesAreMadeAgain) {
    const std::string path = WriteImage("image.png", 300, 200, 4, OIIO::TypeUInt8);
    const std::vector<TextureLine> expected = AllLines(*Prepare(path));
    EXPECT_TRUE(IsBuilt({path, 0, 0, ""}, Request("raw")));
    for (const auto& entry : std::filesystem::directory_iterator(folder.File("cache"))) {
        if (entry.path().extension() == ".hdsp") { // bytes inside the first group of lines
            std::string segment = ReadFile(entry.path().string());
            segment[65536 + 5000] = static_cast<char>(segment[65536 + 5000] ^ 1);
            WriteFile(entry.path().string(), segment);
        }
    }
    TexturePreparer preparer(OpenStore(), &warnings);
    const auto texture = preparer.Prepare({path, 0, 0, ""}, Request("raw"));
    EXPECT_EQ(preparer.NumBuilt(), 0u);
    EXPECT_EQ(AllLines(*texture), expected);
    EXPECT_FALSE(IsBuilt({path, 0, 0, ""}, Request("raw"))); // and are in the store again
}

TEST_F(TextureStoreTest, OneRunMendsAllThatIsDamaged) {
    const std::string path = WriteImage("image.png", 300, 200, 4, OIIO::TypeUInt8);
    const std::vector<TextureLine> expected = AllLines(*Prepare(path));
    EXPECT_TRUE(IsBuilt({path, 0, 0, ""}, Request("raw")));
    for (const auto& entry : std::filesystem::directory_iterator(folder.File("cache"))) {
        if (entry.path().extension() == ".hdsp") { // all groups, and the description
            std::string segment = ReadFile(entry.path().string());
            for (std::size_t at = 65536; at < segment.size(); at += 64) {
                segment[at] = static_cast<char>(segment[at] ^ 1);
            }
            WriteFile(entry.path().string(), segment);
        }
    }
    TexturePreparer preparer(OpenStore(), &warnings);
    const auto texture = preparer.Prepare({path, 0, 0, ""}, Request("raw"));
    EXPECT_EQ(preparer.NumBuilt(), 1u);
    EXPECT_EQ(AllLines(*texture), expected);
    EXPECT_EQ(texture->HostBytes(), 0u);
    EXPECT_FALSE(IsBuilt({path, 0, 0, ""}, Request("raw")));
}

TEST_F(TextureStoreTest, LinesOfAFileThatIsCutAreMadeAgain) {
    const std::string path = WriteImage("image.png", 300, 200, 4, OIIO::TypeUInt8);
    const std::vector<TextureLine> expected = AllLines(*Prepare(path));
    EXPECT_TRUE(IsBuilt({path, 0, 0, ""}, Request("raw")));
    TexturePreparer preparer(OpenStore(), &warnings);
    const auto texture = preparer.Prepare({path, 0, 0, ""}, Request("raw"));
    EXPECT_EQ(AllLines(*texture), expected); // all are verified now
    for (const auto& entry : std::filesystem::directory_iterator(folder.File("cache"))) {
        if (entry.path().extension() == ".hdsp") {
            std::filesystem::resize_file(entry.path(), 65536 + 5000);
        }
    }
    EXPECT_EQ(AllLines(*texture), expected);
    EXPECT_EQ(warnings.Lines(), std::vector<std::string>());
}

TEST_F(TextureStoreTest, AnImageOfOneColorIsPreparedOnce) {
    const std::string path =
        WriteImage("one.png", 300, 200, 3, OIIO::TypeUInt8, [](int, int, int) { return 0.6; });
    EXPECT_TRUE(IsBuilt({path, 0, 0, ""}, Request("sRGB")));
    EXPECT_FALSE(IsBuilt({path, 0, 0, ""}, Request("sRGB")));
}

TEST_F(TextureStoreTest, DamagedLinesOfALostFileAreBlackAndWarnedOfOnce) {
    const std::string path = WriteImage("image.png", 300, 200, 4, OIIO::TypeUInt8);
    EXPECT_TRUE(IsBuilt({path, 0, 0, ""}, Request("raw")));
    TexturePreparer preparer(OpenStore(), &warnings);
    const auto texture = preparer.Prepare({path, 0, 0, ""}, Request("raw"));
    for (const auto& entry : std::filesystem::directory_iterator(folder.File("cache"))) {
        if (entry.path().extension() == ".hdsp") {
            std::fstream segment(entry.path(), std::ios::in | std::ios::out | std::ios::binary);
            segment.seekp(65536 + 5000);
            segment.write("damage", 6);
        }
    }
    WriteImage("image.png", 8, 8, 1, OIIO::TypeUInt8);
    TextureLine line;
    EXPECT_FALSE(texture->ReadLine(0, &line));
    EXPECT_FALSE(texture->ReadLine(1, &line));
    EXPECT_EQ(line, TextureLine{});
    ASSERT_EQ(warnings.Lines().size(), 1u);
    EXPECT_NE(warnings.Lines()[0].find("image.png"), std::string::npos);
}

TEST_F(TextureStoreTest, BadFilesGiveOneLineAndAFallback) {
    const std::string whole = ReadFile(WriteImage("whole.png", 200, 200, 3, OIIO::TypeUInt8));
    const std::string jpeg = ReadFile(WriteImage("whole.jpg", 200, 200, 3, OIIO::TypeUInt8));
    const std::string exr = ReadFile(WriteImage("whole.exr", 200, 200, 3, OIIO::TypeHalf));
    WriteFile(folder.File("cut.png"), whole.substr(0, whole.size() / 2));
    WriteFile(folder.File("cut.exr"), exr.substr(0, exr.size() / 2));
    WriteFile(folder.File("head.jpg"), jpeg.substr(0, 40));
    WriteFile(folder.File("empty.png"), "");
    WriteFile(folder.File("text.png"), "this is no image");
    std::filesystem::create_directory(folder.File("folder.png"));
    const auto store = OpenStore();
    for (const char* name :
         {"missing.png", "cut.png", "cut.exr", "head.jpg", "empty.png", "text.png", "folder.png"}) {
        Warnings own;
        TexturePreparer preparer(store, &own);
        const auto texture = preparer.Prepare({folder.File(name), 0, 0, ""}, Request("auto"));
        EXPECT_FALSE(texture->Ok()) << name;
        ASSERT_EQ(own.Lines().size(), 1u) << name;
        EXPECT_NE(own.Lines()[0].find(name), std::string::npos) << own.Lines()[0];
        EXPECT_EQ(own.Lines()[0].find('\n'), std::string::npos);
        EXPECT_EQ(texture->Record().flags, HDS_TEXTURE_CONSTANT | HDS_TEXTURE_MISSING);
        EXPECT_EQ(Texel(*texture, 0, 0, 0), (std::vector<float>{0, 0, 0, 1}));
        EXPECT_FALSE(TexturePreparer::Estimate({folder.File(name), 0, 0, ""}, Request("auto")) &&
                     std::string(name).substr(0, 3) != "cut"); // cut off behind the header
    }
    // Repaired, it is a texture.
    WriteFile(folder.File("cut.png"), whole);
    EXPECT_TRUE(IsBuilt({folder.File("cut.png"), 0, 0, ""}, Request("auto")));
}

TEST_F(TextureStoreTest, TooLargeForALayoutIsAnError) {
    const auto texture = Prepare(WriteImage("long.tif", 131073, 1, 1, OIIO::TypeUInt8));
    EXPECT_NE(texture->Description().error.find("131073x1"), std::string::npos);
}

TEST_F(TextureStoreTest, ManyThreadsPrepareATextureOnce) {
    std::vector<std::string> paths;
    for (int i = 0; i < 3; ++i) {
        paths.push_back(
            WriteImage("image" + std::to_string(i) + ".png", 200 + i, 150, 3, OIIO::TypeUInt8));
    }
    TexturePreparer preparer(OpenStore(), &warnings);
    std::vector<std::shared_ptr<const PreparedTexture>> textures(12);
    std::vector<std::thread> threads;
    for (std::size_t t = 0; t < textures.size(); ++t) {
        threads.emplace_back([&, t] {
            textures[t] = preparer.Prepare({paths[t % 3], 0, 0, ""}, Request("sRGB"));
            TextureLine line;
            for (std::uint32_t i = 0; i < textures[t]->NumLines(); ++i) {
                ASSERT_TRUE(textures[t]->ReadLine(i, &line));
            }
        });
    }
    for (std::thread& thread : threads) {
        thread.join();
    }
    EXPECT_EQ(preparer.NumBuilt(), 3u);
    for (std::size_t t = 3; t < textures.size(); ++t) {
        EXPECT_EQ(textures[t], textures[t % 3]);
    }
    for (std::size_t i = 0; i < 3; ++i) {
        EXPECT_EQ(AllLines(*textures[i]), AllLines(*Prepare(paths[i], "sRGB")));
    }
}

TEST_F(TextureStoreTest, AFullStoreMeansHostMemory) {
    const std::string path = WriteImage("image.png", 300, 200, 4, OIIO::TypeUInt8);
    PageStoreOptions options;
    options.directory = folder.File("small");
    options.maxBytes = 100000; // one group of lines, no more
    for (int process = 0; process < 2; ++process) {
        TexturePreparer preparer(std::make_shared<PageStore>(options, &warnings), &warnings);
        const auto texture = preparer.Prepare({path, 0, 0, ""}, Request("raw"));
        EXPECT_EQ(preparer.NumBuilt(), 1u);
        EXPECT_GT(texture->HostBytes(), 0u);
        EXPECT_EQ(AllLines(*texture), AllLines(*Prepare(path)));
    }
}

TEST_F(TextureStoreTest, EstimatesAreRecords) {
    const std::string path = WriteImage("image.png", 300, 200, 4, OIIO::TypeUInt16);
    const auto estimate = TexturePreparer::Estimate({path, 0, 0, ""}, Request("raw"));
    ASSERT_TRUE(estimate);
    EXPECT_EQ(std::memcmp(&*estimate, &Prepare(path)->Record(), sizeof(*estimate)), 0);
}

} // namespace
} // namespace hds
