// SPDX-License-Identifier: Apache-2.0
// Whole textures: texels as they are stored, mips by area, channels, unreadable files; UDIM sets.
#include "hdStream/texture/plainTexture.h"
#include "hdStream/texture/udim.h"

#include "testenv/unit/texture/textureFixtures.h"

#include <cmath>
#include <cstring>
#include <fstream>

namespace hds {
namespace {

class PlainTextureTest : public TextureTest {
protected:
    static PlainTexture Load(const std::string& path, const std::string& colorSpace = "raw",
                             std::uint32_t channels = 15) {
        return LoadPlainTexture({path, 0, 0, ""}, Request(colorSpace, channels));
    }
    static const std::uint8_t* Mip(const PlainTexture& texture, std::uint32_t mip) {
        return texture.texels.data() + std::size_t{16} * texture.record.mipBlock[mip];
    }
};

TEST_F(PlainTextureTest, MipZeroIsTheFile) {
    const auto codes = [](int x, int y, int c) { return (10 * x + 40 * y + 3 * c) / 255.0; };
    const std::string path = WriteImage("a.png", 5, 3, 4, OIIO::TypeUInt8, codes);
    for (const char* space : {"raw", "sRGB"}) {
        const PlainTexture texture = Load(path, space);
        ASSERT_EQ(texture.error, "");
        EXPECT_EQ(texture.record.numMips, 3U);
        const std::uint32_t srgb = std::string(space) == "sRGB" ? HDS_TEXEL_SRGB : 0U;
        EXPECT_EQ(texture.record.format, HDS_TEXEL_U8 | 2U | srgb);
        for (int i = 0; i < 5 * 3 * 4; ++i) {
            const int texel = i / 4;
            EXPECT_EQ(Mip(texture, 0)[i], 10 * (texel % 5) + 40 * (texel / 5) + 3 * (i % 4)) << i;
        }
    }
}

TEST_F(PlainTextureTest, MipsAreMeansByArea) {
    const auto ramp = [](int x, int y, int) { return x + 10.0 * y; };
    const PlainTexture texture = Load(WriteImage("a.exr", 5, 3, 1, OIIO::TypeFloat, ramp));
    ASSERT_EQ(texture.error, "");
    EXPECT_EQ(texture.record.format, HDS_TEXEL_FLOAT);
    EXPECT_EQ(texture.record.swizzle, HDS_SWIZZLE_GRAY);
    float values[2] = {};
    std::memcpy(values, Mip(texture, 1), sizeof(values)); // 2 x 1
    // Columns 0, 1 and half of 2; half of 2, 3 and 4; all rows.
    EXPECT_NEAR(values[0], (0 + 1 + 0.5 * 2) / 2.5 + 10.0, 1e-5);
    EXPECT_NEAR(values[1], (0.5 * 2 + 3 + 4) / 2.5 + 10.0, 1e-5);
    std::memcpy(values, Mip(texture, 2), sizeof(float));
    EXPECT_NEAR(values[0], 2.0 + 10.0, 1e-5);
}

TEST_F(PlainTextureTest, ChannelsAreReadInLinearLight) {
    const std::string path = WriteImage("a.png", 4, 4, 4, OIIO::TypeUInt8,
                                        [](int x, int, int c) { return c == 3 ? 0.2 : x / 255.0; });
    const PlainChannel green = LoadPlainChannel({path, 0, 0, ""}, "sRGB", 1);
    ASSERT_EQ(green.values.size(), 16U);
    EXPECT_NEAR(green.values[3], 3 / 255.0 / 12.92, 1e-7);
    EXPECT_NEAR(LoadPlainChannel({path, 0, 0, ""}, "sRGB", 3).values[0], 0.2, 1e-6);
    const std::string gray =
        WriteImage("g.png", 2, 2, 1, OIIO::TypeUInt8, [](int, int, int) { return 0.4; });
    EXPECT_NEAR(LoadPlainChannel({gray, 0, 0, ""}, "raw", 2).values[0], 0.4, 1e-6);
    EXPECT_EQ(LoadPlainChannel({gray, 0, 0, ""}, "raw", 3).values[0], 1.0F);
}

TEST_F(PlainTextureTest, UnreadableFilesAreMissingTextures) {
    const std::string path = WriteImage("a.png", 64, 64, 3, OIIO::TypeUInt8);
    std::ifstream whole(path, std::ios::binary);
    std::string bytes((std::istreambuf_iterator<char>(whole)), std::istreambuf_iterator<char>());
    std::ofstream(folder.File("cut.png"), std::ios::binary).write(bytes.data(), 1000);
    std::ofstream(folder.File("text.png")) << "no image";
    for (const char* name : {"cut.png", "text.png", "absent.png"}) {
        const PlainTexture texture = Load(folder.File(name));
        EXPECT_NE(texture.error.find(name), std::string::npos) << texture.error;
        EXPECT_EQ(texture.record.flags, HDS_TEXTURE_MISSING);
        EXPECT_TRUE(texture.texels.empty());
        EXPECT_TRUE(LoadPlainChannel({folder.File(name), 0, 0, ""}, "raw", 0).values.empty());
    }
}

TEST_F(PlainTextureTest, UdimFilesAreFoundByTheirNumber) {
    for (const char* name : {"a.1001.png", "a.1100.png", "a.1000.png", "a.1101.png", "a.9999.png",
                             "a.10011.png", "a.100x.png", "b.1003.png", "a.1002.jpg"}) {
        std::ofstream(folder.File(name)) << "x";
    }
    const std::vector<UdimFile> files = FindUdimFiles(folder.File("a.<UDIM>.png"));
    ASSERT_EQ(files.size(), 2U);
    EXPECT_EQ(files[0].index, 0U);
    EXPECT_EQ(files[0].path, folder.File("a.1001.png"));
    EXPECT_EQ(files[1].index, 99U);
    EXPECT_TRUE(FindUdimFiles(folder.File("nowhere/a.<UDIM>.png")).empty());
    EXPECT_TRUE(FindUdimFiles(folder.File("a.1001.png")).empty());
}

} // namespace
} // namespace hds
