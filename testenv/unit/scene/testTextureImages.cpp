// SPDX-License-Identifier: Apache-2.0
// A scene's images as the texture cache sees them: opened when they are asked for, bounded by what
// their headers say.
#include "hdStream/scene/textureImages.h"
#include "testenv/unit/texture/textureFixtures.h"

#include <cstring>
#include <filesystem>

namespace hds {
namespace {

class TextureImagesTest : public TextureTest {
protected:
    MaterialTexture Texture(const std::string& path, const std::string& colorSpace = "auto",
                            std::uint32_t channels = 15) {
        MaterialTexture texture;
        texture.file.authoredPath = path;
        texture.file.file = path;
        texture.colorSpace = colorSpace;
        texture.channels = channels;
        library.Probe(texture.file);
        return texture;
    }

    std::unique_ptr<TextureLines> Lines(const std::vector<MaterialTexture>& textures) {
        return std::make_unique<TextureLines>(std::make_shared<TexturePreparer>(nullptr, &warnings),
                                              MakeTextureImages(textures, library));
    }

    ImageLibrary library{warnings};
};

TEST_F(TextureImagesTest, HeadersBoundTheLines) {
    std::vector<MaterialTexture> textures;
    for (int channels = 1; channels <= 4; ++channels) {
        const std::string name = "c" + std::to_string(channels);
        textures.push_back(Texture(WriteImage(name + "a.png", 70, 45, channels, OIIO::TypeUInt8)));
        textures.push_back(
            Texture(WriteImage(name + "b.png", 33, 200, channels, OIIO::TypeUInt16), "sRGB"));
        textures.push_back(
            Texture(WriteImage(name + "c.tif", 100, 9, channels, OIIO::TypeFloat), "raw"));
        textures.push_back(
            Texture(WriteImage(name + "d.png", 64, 64, channels, OIIO::TypeUInt8), "ACEScg", 1));
    }
    textures.push_back(Texture(WriteImage("signed.tif", 256, 256, 1, OIIO::TypeInt16), "raw"));
    textures.push_back(Texture(WriteImage("bytes.tif", 256, 256, 3, OIIO::TypeInt8), "raw"));
    textures.push_back(Texture(folder.File("missing.png")));
    for (const MaterialTexture& texture : textures) {
        const auto lines = Lines({texture});
        const std::uint64_t bound = lines->MaxLines();
        ASSERT_NE(bound, LineProvider::kUnknown) << texture.file.file;
        EXPECT_TRUE(lines->Open({0}, false, {}));
        EXPECT_LE(lines->Record(0).numLines, bound) << texture.file.file;
        EXPECT_EQ(lines->MaxLines(), lines->Record(0).numLines) << "known now";
        EXPECT_EQ(lines->TotalLines(), lines->Record(0).numLines);
    }
}

TEST_F(TextureImagesTest, LinesAreThoseOfThePreparedTexture) {
    const std::string path = WriteImage("a.png", 90, 70, 3, OIIO::TypeUInt8);
    const auto lines =
        Lines({Texture(WriteImage("b.png", 8, 8, 1, OIIO::TypeUInt8)), Texture(path)});
    EXPECT_TRUE(lines->Open({1}, false, {}));
    const auto prepared = Prepare(path, "auto");
    const std::vector<TextureLine> expected = AllLines(*prepared);
    ASSERT_EQ(lines->Record(1).numLines, expected.size());
    std::vector<LineId> ids;
    for (std::uint32_t i = 0; i < 3 * expected.size(); ++i) { // more than one task's
        ids.push_back({1, i * 7 % static_cast<std::uint32_t>(expected.size())});
    }
    std::vector<std::uint8_t> bytes(ids.size() * HDS_LINE_BYTES);
    EXPECT_TRUE(lines->Read(ids, bytes.data(), {}));
    for (std::size_t i = 0; i < ids.size(); ++i) {
        ASSERT_EQ(
            std::memcmp(&bytes[i * HDS_LINE_BYTES], expected[ids[i].line].data(), HDS_LINE_BYTES),
            0);
    }
}

TEST_F(TextureImagesTest, IdsTellImagesSpacesChannelsAndEpochsApart) {
    const std::string path = WriteImage("a.png", 8, 8, 3, OIIO::TypeUInt8);
    const std::string other = WriteImage("b.png", 8, 8, 3, OIIO::TypeUInt8);
    const std::vector<MaterialTexture> textures = {Texture(path), Texture(other),
                                                   Texture(path, "raw"), Texture(path, "auto", 1)};
    const auto before = Lines(textures);
    const auto same = Lines(textures);
    for (std::uint32_t i = 0; i < 4; ++i) {
        EXPECT_EQ(before->TextureId(i), same->TextureId(i));
        for (std::uint32_t j = 0; j < i; ++j) {
            EXPECT_NE(before->TextureId(i), before->TextureId(j));
        }
    }
    library.Clear(); // images may have changed
    EXPECT_NE(before->TextureId(0), Lines(textures)->TextureId(0));
}

TEST_F(TextureImagesTest, NothingIsOpenedUnasked) {
    const std::string path = WriteImage("a.png", 8, 8, 3, OIIO::TypeUInt8);
    const std::vector<MaterialTexture> textures = {Texture(path)};
    std::filesystem::remove(path);
    const auto lines = Lines(textures);
    EXPECT_GE(lines->MaxLines(), 1U);
    EXPECT_TRUE(warnings.Lines().empty());
    EXPECT_TRUE(lines->Open({0}, false, {}));
    EXPECT_TRUE(lines->Open({0}, false, {}));
    EXPECT_NE(lines->Record(0).flags & HDS_TEXTURE_MISSING, 0U);
    EXPECT_EQ(warnings.Lines().size(), 1U);
}

} // namespace
} // namespace hds
