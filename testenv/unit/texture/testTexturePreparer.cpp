// SPDX-License-Identifier: Apache-2.0
// What textures hold after preparation. Oracles: the formula that the image was written from, mips
// by a cascade of box filters in double precision written as plain loops, sRGB by IEC 61966-2-1.
#include "testenv/unit/texture/textureFixtures.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace hds {
namespace {

/// An error is at most `share` of the range of its block and channel, plus `rounding`: half a step
/// of the least bits that an index has for the channel, times the slope of sRGB where there is one,
/// and half a code.
struct Kind {
    const char* extension;
    OIIO::TypeDesc type;
    int channels;
    const char* space;
    std::uint32_t format; ///< expected
    double share;
    double rounding;
};

const Kind kKinds[] = {
    {"png", OIIO::TypeUInt8, 1, "raw", HDS_TEXEL_U8 | 0u, 0.1, 0.004},
    {"png", OIIO::TypeUInt8, 2, "raw", HDS_TEXEL_U8 | 1u, 0.1, 0.004},
    {"png", OIIO::TypeUInt8, 3, "raw", HDS_TEXEL_U8 | 2u, 0.2, 0.004},
    {"png", OIIO::TypeUInt8, 4, "raw", HDS_TEXEL_U8 | 2u, 0.55, 0.004},
    {"png", OIIO::TypeUInt8, 3, "sRGB", HDS_TEXEL_U8 | 2u | HDS_TEXEL_SRGB, 0.3, 0.01},
    {"png", OIIO::TypeUInt8, 1, "sRGB", HDS_TEXEL_U8 | 0u | HDS_TEXEL_SRGB, 0.2, 0.01},
    {"png", OIIO::TypeUInt8, 2, "sRGB",
     HDS_TEXEL_U8 | 1u | HDS_TEXEL_SRGB | HDS_TEXEL_SECOND_IS_ALPHA, 0.2, 0.01},
    {"png", OIIO::TypeUInt16, 1, "raw", HDS_TEXEL_U16 | 0u, 0.0081, 2e-5},
    {"png", OIIO::TypeUInt16, 3, "raw", HDS_TEXEL_U16 | 2u, 0.0021, 2e-5},
    {"png", OIIO::TypeUInt16, 4, "raw", HDS_TEXEL_U16 | 2u, 0.0081, 2e-5},
    {"png", OIIO::TypeUInt16, 3, "sRGB", HDS_TEXEL_HALF | 2u, 0.02, 5e-4},
    {"exr", OIIO::TypeHalf, 1, "raw", HDS_TEXEL_HALF | 0u, 0.0081, 5e-4},
    {"exr", OIIO::TypeHalf, 3, "raw", HDS_TEXEL_HALF | 2u, 0.02, 5e-4},
    {"exr", OIIO::TypeHalf, 4, "auto", HDS_TEXEL_HALF | 2u, 0.05, 5e-4},
    {"tif", OIIO::TypeFloat, 1, "raw", HDS_TEXEL_FLOAT | 0u, 1.3e-4, 1e-6},
    {"exr", OIIO::TypeFloat, 3, "raw", HDS_TEXEL_HALF | 2u, 0.02, 5e-4},
};

class PreparedKind : public TextureTest, public ::testing::WithParamInterface<Kind> {};

double Srgb(double v) {
    return v <= 0.04045 ? v / 12.92 : std::pow((v + 0.055) / 1.055, 2.4);
}

/// The mip chain of a channel in double precision: each level the area means of the one before.
std::vector<std::vector<double>> Mips(std::vector<double> level, int width, int height) {
    std::vector<std::vector<double>> mips{level};
    while (width > 1 || height > 1) {
        const int w = std::max(1, width / 2);
        const int h = std::max(1, height / 2);
        std::vector<double> next(std::size_t(w) * std::size_t(h), 0.0);
        for (int y = 0; y < height * h; ++y) {
            for (int x = 0; x < width * w; ++x) {
                next[std::size_t(y / height * w + x / width)] +=
                    level[std::size_t(y / h * width + x / w)] / (double(width) * height);
            }
        }
        mips.push_back(next);
        level = next;
        width = w;
        height = h;
    }
    return mips;
}

/// High less low of each texel's block of 4x4.
std::vector<double> BlockRanges(const std::vector<double>& level, int width, int height) {
    std::vector<double> ranges;
    for (int i = 0; i < width * height; ++i) {
        double low = 1e30;
        double high = -1e30;
        for (int y = i / width / 4 * 4; y < std::min(height, i / width / 4 * 4 + 4); ++y) {
            for (int x = i % width / 4 * 4; x < std::min(width, i % width / 4 * 4 + 4); ++x) {
                low = std::min(low, level[std::size_t(y * width + x)]);
                high = std::max(high, level[std::size_t(y * width + x)]);
            }
        }
        ranges.push_back(high - low);
    }
    return ranges;
}

/// Compares output `c` of all mips of a texture with its formula.
void ExpectChannel(const Kind& kind, const PreparedTexture& texture, int c) {
    const int width = static_cast<int>(texture.Record().width);
    const int height = static_cast<int>(texture.Record().height);
    const bool hasAlpha = kind.channels % 2 == 0;
    const int source = c == 3 ? (hasAlpha ? kind.channels - 1 : -1) : (kind.channels < 3 ? 0 : c);
    const bool isEncoded = std::string(kind.space) == "sRGB" && c < 3;
    std::vector<double> values;
    for (int i = 0; i < width * height; ++i) {
        const double v = source < 0 ? 1.0 : Waves(i % width, i / width, source);
        values.push_back(isEncoded ? Srgb(v) : v);
    }
    const auto mips = Mips(values, width, height);
    ASSERT_EQ(texture.Record().numMips, mips.size());
    for (std::uint32_t mip = 0; mip < mips.size(); ++mip) {
        const std::vector<float> pixels = texture.DecodeMip(mip);
        ASSERT_EQ(pixels.size(), 4 * mips[mip].size());
        const std::vector<double> ranges =
            BlockRanges(mips[mip], std::max(1, width >> mip), std::max(1, height >> mip));
        for (std::size_t i = 0; i < ranges.size(); ++i) {
            const double bound = source < 0 ? 1e-12 : kind.share * ranges[i] + kind.rounding;
            ASSERT_NEAR(pixels[4 * i + std::size_t(c)], mips[mip][i], bound)
                << "mip " << mip << " texel " << i << " channel " << c << " of " << width << "x"
                << height;
        }
    }
}

TEST_P(PreparedKind, EveryMipIsTheImageInLinearLight) {
    const Kind& kind = GetParam();
    constexpr int kSizes[][2] = {{53, 38}, {1, 1}, {1, 21}, {64, 32}};
    for (const auto& [width, height] : kSizes) {
        const std::string path = WriteImage(std::string("image.") + kind.extension, width, height,
                                            kind.channels, kind.type);
        const auto texture = Prepare(path, kind.space);
        ASSERT_TRUE(texture->Ok()) << texture->Description().error;
        EXPECT_EQ(texture->Record().format, kind.format);
        for (int c = 0; c < 4; ++c) {
            ExpectChannel(kind, *texture, c);
        }
        EXPECT_EQ(warnings.Lines(), std::vector<std::string>());
    }
}

INSTANTIATE_TEST_SUITE_P(Formats, PreparedKind, ::testing::ValuesIn(kKinds));

TEST_F(TextureTest, MipZeroIsTheFile) {
    // In a block of 4x4 a channel has two values, which the codec keeps.
    const auto code = [](int x, int y, int c) {
        const int isHigh = (x * 5 + y * 3 + c * 7 + x * y) % 3 == 0 ? 1 : 0;
        return 40 * c + 11 * (x / 4) + 60 * isHigh;
    };
    const std::string path = WriteImage("two.png", 7, 3, 4, OIIO::TypeUInt8,
                                        [&](int x, int y, int c) { return code(x, y, c) / 255.0; });
    for (const char* space : {"raw", "sRGB"}) {
        const bool isEncoded = std::string(space) == "sRGB";
        const auto texture = Prepare(path, space);
        ASSERT_TRUE(texture->Ok());
        EXPECT_EQ(texture->Record().numMips, 3u);
        EXPECT_EQ(texture->Record().format, HDS_TEXEL_U8 | 2u | (isEncoded ? HDS_TEXEL_SRGB : 0u));
        const std::vector<float> pixels = texture->DecodeMip(0);
        for (int i = 0; i < 4 * 7 * 3; ++i) {
            const double stored = code(i / 4 % 7, i / 28, i % 4) / 255.0;
            EXPECT_NEAR(pixels[std::size_t(i)], isEncoded && i % 4 < 3 ? Srgb(stored) : stored,
                        1e-6)
                << i;
        }
    }
}

TEST_F(TextureTest, MipsAreMeansByArea) {
    const auto ramp = [](int x, int y, int) { return x + 10.0 * y; };
    const auto texture = Prepare(WriteImage("ramp.exr", 5, 3, 1, OIIO::TypeFloat, ramp));
    EXPECT_EQ(texture->Record().format, HDS_TEXEL_FLOAT);
    EXPECT_EQ(texture->Record().swizzle, HDS_SWIZZLE_GRAY);
    // Mip 1 is 2 x 1: columns 0, 1 and half of 2; half of 2, 3 and 4; all rows. Two values are
    // kept.
    EXPECT_NEAR(Texel(*texture, 1, 0, 0)[0], (0 + 1 + 0.5 * 2) / 2.5 + 10.0, 1e-5);
    EXPECT_NEAR(Texel(*texture, 1, 1, 0)[0], (0.5 * 2 + 3 + 4) / 2.5 + 10.0, 1e-5);
    EXPECT_NEAR(Texel(*texture, 2, 0, 0)[0], 2.0 + 10.0, 1e-5);
}

TEST_F(TextureTest, ChannelsThatNobodyReadsAreNotStored) {
    const std::string path = WriteImage("rgba.png", 20, 20, 4, OIIO::TypeUInt8);
    const auto green = Prepare(path, "raw", TextureRequest::kGreen);
    EXPECT_EQ(green->Record().format, HDS_TEXEL_U8 | 0u);
    EXPECT_NEAR(Texel(*green, 0, 7, 5)[1], Waves(7, 5, 1), 0.035);
    const auto blueAlpha = Prepare(path, "sRGB", TextureRequest::kBlue | TextureRequest::kAlpha);
    EXPECT_EQ(blueAlpha->Record().format,
              HDS_TEXEL_U8 | 1u | HDS_TEXEL_SRGB | HDS_TEXEL_SECOND_IS_ALPHA);
    EXPECT_NEAR(Texel(*blueAlpha, 0, 7, 5)[2], Srgb(Waves(7, 5, 2)), 0.07);
    EXPECT_NEAR(Texel(*blueAlpha, 0, 7, 5)[3], Waves(7, 5, 3), 0.035);
    const auto alpha = Prepare(path, "sRGB", TextureRequest::kAlpha);
    EXPECT_EQ(alpha->Record().format, HDS_TEXEL_U8 | 0u);
    EXPECT_NEAR(Texel(*alpha, 0, 7, 5)[3], Waves(7, 5, 3), 0.035);
    const auto colors = Prepare(path, "raw", 7);
    EXPECT_EQ(Texel(*colors, 0, 7, 5)[3], 1.0f); // not stored: its bits go to the colours
    EXPECT_NE(green->Record().numLines, colors->Record().numLines);
}

TEST_F(TextureTest, NamedSpacesAreConvertedWhilePreparing) {
    // Gamma 2.2 and gray of 8 bits need more than 8 bits when they are linear.
    const std::string path = WriteImage("gamma.png", 16, 16, 3, OIIO::TypeUInt8);
    const auto texture = Prepare(path, "g22_rec709");
    EXPECT_EQ(texture->Record().format, HDS_TEXEL_HALF | 2u);
    EXPECT_NEAR(Texel(*texture, 0, 3, 9)[2], std::pow(Waves(3, 9, 2), 2.2), 0.01);
    const auto unknown = Prepare(path, "no such space");
    EXPECT_NE(unknown->Description().warning.find("no such space"), std::string::npos);
    EXPECT_EQ(unknown->Record().format, HDS_TEXEL_U8 | 2u | HDS_TEXEL_SRGB); // auto
}

TEST_F(TextureTest, FloatColorsBeyondHalvesStayFloats) {
    const auto bright = [](int x, int y, int c) { return c == 0 && x == 3 && y == 2 ? 1e6 : 0.5; };
    const auto large = Prepare(WriteImage("large.exr", 9, 9, 3, OIIO::TypeFloat, bright));
    EXPECT_EQ(large->Record().format, HDS_TEXEL_FLOAT | 2u);
    EXPECT_EQ(Texel(*large, 0, 3, 2)[0], 1e6f);
    const auto tiny = [](int x, int y, int c) { return 1e-5 * Waves(x, y, c); };
    const auto small = Prepare(WriteImage("small.exr", 9, 9, 3, OIIO::TypeFloat, tiny));
    EXPECT_EQ(small->Record().format, HDS_TEXEL_FLOAT | 2u);
    EXPECT_NEAR(Texel(*small, 0, 3, 2)[0], 1e-5 * Waves(3, 2, 0), 1e-8);
}

TEST_F(TextureTest, ValuesThatAreNotFiniteAreReplacedAndCounted) {
    const auto broken = [](int x, int y, int) {
        if (y == 1 && x < 3) {
            const double inf = std::numeric_limits<double>::infinity();
            return x == 0 ? std::nan("") : (x == 1 ? inf : -inf);
        }
        return 0.25;
    };
    const auto texture = Prepare(WriteImage("nan.exr", 8, 8, 1, OIIO::TypeFloat, broken));
    EXPECT_EQ(texture->Description().numNonFinite, 3u);
    EXPECT_NE(texture->Description().warning.find("nan.exr"), std::string::npos);
    EXPECT_EQ(warnings.Lines().size(), 1u);
    EXPECT_EQ(Texel(*texture, 0, 1, 1)[0], 65504.0f);
    EXPECT_EQ(Texel(*texture, 0, 2, 1)[0], -65504.0f);
    for (std::uint32_t mip = 0; mip < texture->Record().numMips; ++mip) {
        for (const float value : texture->DecodeMip(mip)) {
            EXPECT_TRUE(std::isfinite(value));
        }
    }
}

TEST_F(TextureTest, AnImageOfOneColorTakesOneLine) {
    for (const OIIO::TypeDesc& type :
         {OIIO::TypeDesc(OIIO::TypeDesc::UINT8), OIIO::TypeDesc(OIIO::TypeDesc::UINT16)}) {
        const auto texture = Prepare(WriteImage("one.png", 700, 300, 3, type,
                                                [](int, int, int c) { return 0.2 * (c + 1); }));
        EXPECT_EQ(texture->Record().flags, HDS_TEXTURE_CONSTANT);
        EXPECT_EQ(texture->NumLines(), 1u);
        EXPECT_EQ(texture->Record().width, 700u);
        for (const std::uint32_t mip : {0u, 5u, 9u}) {
            EXPECT_NEAR(Texel(*texture, mip, (700u >> mip) - 1, 0)[1], 0.4, 1e-6);
        }
    }
    // Until its last row: nothing may be lost of the rows before.
    const auto late =
        Prepare(WriteImage("late.png", 300, 300, 1, OIIO::TypeUInt8,
                           [](int x, int y, int) { return y == 299 ? Waves(x, y, 0) : 0.6; }));
    EXPECT_EQ(late->Record().flags, 0u);
    EXPECT_EQ(Texel(*late, 0, 299, 150)[0], 153 / 255.0f);
    EXPECT_NEAR(Texel(*late, 8, 0, 0)[0], 0.6, 0.01);
}

TEST_F(TextureTest, WideImagesAreFilteredRowByRow) {
    // 16k: the longest rows that common tools write. Columns of one value check every line's place.
    const auto texture = Prepare(WriteImage("wide.png", 16384, 33, 1, OIIO::TypeUInt8,
                                            [](int x, int, int) { return (x / 64) / 255.0; }));
    ASSERT_TRUE(texture->Ok());
    EXPECT_EQ(texture->Record().numMips, 15u);
    const std::vector<float> pixels = texture->DecodeMip(3);
    ASSERT_EQ(pixels.size(), 4u * 2048 * 4);
    for (std::size_t x = 0; x < 2048; ++x) {
        EXPECT_NEAR(pixels[4 * (2048 + x)], double(x / 8) / 255, 1e-6);
    }
}

TEST_F(TextureTest, RadianceIsFiniteAndNotNegative) {
    // A block each, so that the codec keeps what preparing made of it.
    const float infinity = std::numeric_limits<float>::infinity();
    const std::vector<float> stored = {1.0f, std::numeric_limits<float>::quiet_NaN(), infinity,
                                       -infinity, -4.0f};
    const std::vector<float> expected = {1.0f, 0.0f, 65504.0f, 0.0f, 0.0f};
    const std::string path =
        WriteImage("sky.exr", 4 * int(stored.size()), 4, 3, OIIO::TypeFloat,
                   [&](int x, int, int c) { return c == 0 ? stored[std::size_t(x / 4)] : 0.5; });
    TextureRequest request = Request("auto", 7);
    request.isRadiance = true;
    TexturePreparer preparer(OpenStore(), &warnings);
    const auto texture = preparer.Prepare({path, 0, 0, ""}, request);
    ASSERT_TRUE(texture->Ok());
    for (std::uint32_t i = 0; i < stored.size(); ++i) {
        EXPECT_EQ(Texel(*texture, 0, 4 * i, 0), (std::vector<float>{expected[i], 0.5f, 0.5f, 1.0f}))
            << i;
    }
    ASSERT_EQ(warnings.Lines().size(), 1u);
    EXPECT_EQ(warnings.Lines()[0],
              path + ": 48 NaN or infinite, 16 negative and 0 too large values were replaced");
    request.isRadiance = false;
    const auto data = preparer.Prepare({path, 0, 0, ""}, request);
    EXPECT_EQ(Texel(*data, 0, 16, 0)[0], -4.0f) << "another texture, of which the store has none";
}

} // namespace
} // namespace hds
