// SPDX-License-Identifier: Apache-2.0
// What a block comes back as. Oracles: the texels that went in, with bounds that follow from the
// widths of the indices; IEEE 754's halves by arithmetic; IEC 61966-2-1 in long double.
#include "hdStream/texture/blockEncoder.h"

#include "kernels/shared/textureCodec.h"
#include "testenv/support/textureFormats.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>

namespace hds {
namespace {

using shared::HdsTexel8;
using Block = std::array<std::uint32_t, 32>; // the largest takes all of it

/// Four channels of a block of 8 bits, back.
std::array<std::array<int, 4>, 16> RoundTrip(const std::vector<std::uint8_t>& texels) {
    Block block;
    EncodeBlock(HDS_TEXEL_U8 | 2u, texels.data(), block.data());
    std::array<std::array<int, 4>, 16> out;
    for (std::uint32_t i = 0; i < 16; ++i) {
        const HdsTexel8 t = shared::codec_color8(block.data(), i);
        out[i] = {int(t.r), int(t.g), int(t.b), int(t.a)};
    }
    return out;
}

float Component(const shared::float4& v, std::size_t c) {
    return c == 0 ? v.x : (c == 1 ? v.y : (c == 2 ? v.z : v.w));
}

/// The stored value as a number, not decoded.
double ValueOf(std::uint32_t format, const std::uint8_t* texels, std::size_t at) {
    std::uint16_t wide = 0;
    float value = 0.0f;
    switch (format & HDS_TEXEL_TYPE_MASK) {
    case HDS_TEXEL_U8:
        return texels[at] / 255.0;
    case HDS_TEXEL_U16:
        std::memcpy(&wide, texels + 2 * at, 2);
        return wide / 65535.0;
    case HDS_TEXEL_HALF:
        std::memcpy(&wide, texels + 2 * at, 2);
        return shared::codec_floatOfHalf(wide);
    default:
        std::memcpy(&value, texels + 4 * at, 4);
        return value;
    }
}

TEST(BlockCodec, ColorsOfSmallRangeComeBackExactly) {
    std::mt19937 generator(1);
    for (int trial = 0; trial < 2000; ++trial) {
        std::vector<std::uint8_t> texels(64);
        const int range = 16; // 4 bits a channel
        int low[3];
        for (int& value : low) {
            value = static_cast<int>(generator() % (257 - range));
        }
        for (std::size_t i = 0; i < 64; ++i) {
            texels[i] =
                i % 4 == 3 ? 255 : static_cast<std::uint8_t>(low[i % 4] + int(generator() % range));
        }
        const auto back = RoundTrip(texels);
        for (std::size_t i = 0; i < 64; ++i) {
            ASSERT_EQ(back[i / 4][i % 4], texels[i]);
        }
    }
}

TEST(BlockCodec, GrayAndMasksComeBackExactly) {
    std::mt19937 generator(2);
    for (int trial = 0; trial < 500; ++trial) {
        std::vector<std::uint8_t> gray(64);
        std::vector<std::uint8_t> mask(64);
        for (std::size_t i = 0; i < 16; ++i) {
            const auto value = static_cast<std::uint8_t>(generator());
            std::fill_n(&gray[4 * i], 3, value); // all of 0 to 255: the luma has 8 bits
            gray[4 * i + 3] = 255;
            std::fill_n(&mask[4 * i], 4, generator() % 2 == 0 ? 255 : 0);
        }
        const auto grayBack = RoundTrip(gray);
        const auto maskBack = RoundTrip(mask);
        for (std::size_t i = 0; i < 64; ++i) {
            ASSERT_EQ(grayBack[i / 4][i % 4], gray[i]);
            ASSERT_EQ(maskBack[i / 4][i % 4], mask[i]);
        }
    }
}

TEST(BlockCodec, AlphaOfOneStaysOneAndConstantsStay) {
    std::mt19937 generator(3);
    for (int trial = 0; trial < 500; ++trial) {
        std::vector<std::uint8_t> noise(64);
        for (std::size_t i = 0; i < 64; ++i) {
            noise[i] = i % 4 == 3 ? 255 : static_cast<std::uint8_t>(generator());
        }
        for (const auto& texel : RoundTrip(noise)) {
            ASSERT_EQ(texel[3], 255);
        }
        std::vector<std::uint8_t> constant(64);
        for (std::size_t i = 0; i < 64; ++i) {
            constant[i] = i < 4 ? static_cast<std::uint8_t>(generator()) : constant[i - 4];
        }
        const auto back = RoundTrip(constant);
        for (std::size_t i = 0; i < 64; ++i) {
            ASSERT_EQ(back[i / 4][i % 4], constant[i]);
        }
    }
}

TEST(BlockCodec, ColorErrorsAreBounded) {
    // Equal shares of the index, 4 bits a channel (with alpha 2 or 3 of 11), are always possible;
    // what is chosen instead must not be worse as a sum of squares.
    std::mt19937 generator(4);
    for (int trial = 0; trial < 3000; ++trial) {
        std::vector<std::uint8_t> texels = test::RandomBlock(HDS_TEXEL_U8 | 2u, generator);
        const auto back = RoundTrip(texels);
        bool isOpaque = true;
        double squares = 0.0;
        double bound = 0.0;
        for (std::size_t c = 0; c < 4; ++c) {
            int low = 255;
            int high = 0;
            for (std::size_t i = 0; i < 16; ++i) {
                low = std::min<int>(low, texels[4 * i + c]);
                high = std::max<int>(high, texels[4 * i + c]);
                isOpaque = isOpaque && texels[4 * i + 3] == 255;
                squares += std::pow(back[i][c] - texels[4 * i + c], 2);
            }
            const double half = 0.5 * (high - low);
            bound += 16 * std::pow(half, 2);
        }
        const double share = isOpaque ? 1.0 / 15 : 1.0 / 3;
        ASSERT_LE(squares, bound * share * share * 2 + 16 * 4 * 0.25) << trial;
    }
}

TEST(BlockCodec, ScalarErrorsAreBounded) {
    std::mt19937 generator(5);
    for (int trial = 0; trial < 5000; ++trial) {
        const std::vector<std::uint8_t> texels = test::RandomBlock(HDS_TEXEL_U8, generator);
        const auto [low, high] = std::minmax_element(texels.begin(), texels.end());
        std::array<std::uint32_t, 2> block;
        EncodeScalar8(texels.data(), 1, block.data());
        double squares = 0.0;
        for (std::uint32_t i = 0; i < 16; ++i) {
            const int error = int(shared::codec_scalar8(block.data(), i)) - texels[i];
            squares += error * error;
            if (*high - *low <= 7) {
                ASSERT_EQ(error, 0);
            }
        }
        // An interval of 3 bits, whose range may be coded 5 too large.
        const double step = (*high - *low + 5) / 7.0;
        ASSERT_LE(squares, 16 * std::pow(0.5 * step + 0.5, 2));
    }
}

TEST(BlockCodec, RampsBeatTheirRange) {
    // Slopes of three codes a texel with noise of +-3: an interval of 24 would lose about 1.7
    // codes, the ramp's window of 7 loses none of the noise.
    std::mt19937 generator(6);
    double squares = 0.0;
    for (int trial = 0; trial < 1000; ++trial) {
        std::vector<std::uint8_t> texels;
        for (int i = 0; i < 16; ++i) {
            texels.push_back(
                static_cast<std::uint8_t>(100 + 3 * (i % 4) + 3 * (i / 4) + int(generator() % 5)));
        }
        std::array<std::uint32_t, 2> block;
        EncodeScalar8(texels.data(), 1, block.data());
        for (std::uint32_t i = 0; i < 16; ++i) {
            squares += std::pow(int(shared::codec_scalar8(block.data(), i)) - texels[i], 2);
        }
    }
    EXPECT_LT(squares / 16000, 0.5);
}

/// Largest error that each channel of a wide block may have, from its range and index.
TEST(BlockCodec, WideErrorsAreBounded) {
    std::mt19937 generator(7);
    for (const std::uint32_t format : test::AllTexelFormats()) {
        if ((format & HDS_TEXEL_TYPE_MASK) == HDS_TEXEL_U8) {
            continue;
        }
        const std::size_t numChannels = std::size_t{1} << (format & HDS_TEXEL_CHANNELS_LOG2_MASK);
        const bool isFloat = (format & HDS_TEXEL_TYPE_MASK) == HDS_TEXEL_FLOAT;
        for (int trial = 0; trial < 1000; ++trial) {
            const std::vector<std::uint8_t> texels = test::RandomBlock(format, generator);
            Block line{};
            EncodeBlock(format, texels.data(), line.data());
            for (std::size_t c = 0; c < numChannels; ++c) {
                double low = 1e30;
                double high = -1e30;
                for (std::size_t i = 0; i < 16; ++i) {
                    low = std::min(low, ValueOf(format, texels.data(), i * numChannels + c));
                    high = std::max(high, ValueOf(format, texels.data(), i * numChannels + c));
                }
                for (std::uint32_t i = 0; i < 16; ++i) {
                    const double value = ValueOf(format, texels.data(), i * numChannels + c);
                    const double back =
                        Component(shared::codec_texel(line.data(), format, i % 4, i / 4), c);
                    // Half a step; colours may choose steps of equal ratio instead: for these, of
                    // up to 2^30, a step is at most a factor of 1.6.
                    const double step = (high - low) / (isFloat ? 4095.0 : 63.0);
                    const double bound = numChannels == 4 && c < 3
                                             ? std::max(0.51 * step, 0.6 * std::abs(value))
                                             : 0.501 * step;
                    ASSERT_LE(std::abs(back - value),
                              bound + 1e-6 * std::max(std::abs(low), std::abs(high)) + 1.6e-5)
                        << format << " channel " << c << " in [" << low << ", " << high << "]";
                }
            }
        }
    }
}

TEST(BlockCodec, EndsOfWideIntervalsAreExact) {
    std::mt19937 generator(8);
    for (const std::uint32_t format : {HDS_TEXEL_U16, HDS_TEXEL_HALF, HDS_TEXEL_FLOAT}) {
        for (int trial = 0; trial < 500; ++trial) {
            std::vector<std::uint8_t> texels = test::RandomBlock(format, generator);
            const std::size_t bytes = TexelBytes(format);
            for (std::size_t i = 2; i < 16; ++i) { // two values in turn
                std::copy_n(&texels[bytes * (i % 2)], bytes, &texels[bytes * i]);
            }
            Block line{};
            EncodeBlock(format, texels.data(), line.data());
            for (std::uint32_t i = 0; i < 16; ++i) {
                // U16: a product with 1 / 65535 is half a unit in the last place off.
                ASSERT_FLOAT_EQ(shared::codec_texel(line.data(), format, i % 4, i / 4).x,
                                static_cast<float>(ValueOf(format, texels.data(), i)));
            }
        }
    }
}

TEST(BlockCodec, DarkColorsOfAHighRangeSurvive) {
    // A sun's edge: 16 values over 2^13 : 1. Each must come back within a third of itself, which
    // interpolation of the values cannot (its step would be 32 times the darkest).
    std::vector<std::uint16_t> texels;
    for (int i = 0; i < 16; ++i) {
        const auto value = HalfOfFloat(std::exp2(-3.0f + 13.0f * static_cast<float>(i) / 15.0f));
        texels.insert(texels.end(), {value, value, value, HalfOfFloat(1.0f)});
    }
    Block line{};
    EncodeBlock(HDS_TEXEL_HALF | 2u, texels.data(), line.data());
    for (std::uint32_t i = 0; i < 16; ++i) {
        const shared::float4 back =
            shared::codec_texel(line.data(), HDS_TEXEL_HALF | 2u, i % 4, i / 4);
        const float value = shared::codec_floatOfHalf(texels[4 * i]);
        EXPECT_NEAR(back.x, value, 0.05 * value);
        EXPECT_EQ(back.w, 1.0f);
    }
}

TEST(BlockCodec, SrgbTableIsTheStandard) {
    for (int code = 0; code < 256; ++code) {
        const long double v = code / 255.0L;
        const long double linear =
            v <= 0.04045L ? v / 12.92L : std::pow((v + 0.055L) / 1.055L, 2.4L);
        EXPECT_EQ(shared::srgb_linear[code], static_cast<float>(linear)) << code;
    }
    EXPECT_EQ(shared::codec_linear8(255, 0), 1.0f);
}

TEST(HalfFloat, EveryHalfAndEveryMiddleRoundsAsIeee754Says) {
    for (std::uint32_t bits = 0; bits < 0x7bffu; ++bits) {
        const auto exponent = static_cast<int>(bits >> 10);
        const double expected = exponent == 0 ? std::ldexp(bits, -24)
                                              : std::ldexp(1024 + (bits & 1023u), exponent - 25);
        ASSERT_EQ(shared::codec_floatOfHalf(bits), expected);
        ASSERT_EQ(shared::codec_floatOfHalf(bits | 0x8000u), -expected);
        ASSERT_EQ(HalfOfFloat(static_cast<float>(expected)), bits);
        ASSERT_EQ(HalfOfFloat(-static_cast<float>(expected)), bits | 0x8000u);
        const float next = shared::codec_floatOfHalf(bits + 1);
        const float middle = static_cast<float>((expected + next) / 2);
        ASSERT_EQ(HalfOfFloat(middle), (bits & 1u) == 0 ? bits : bits + 1);
        ASSERT_EQ(HalfOfFloat(std::nextafter(middle, 0.0f)), bits);
        ASSERT_EQ(HalfOfFloat(std::nextafter(middle, 1e9f)), bits + 1);
    }
}

TEST(BlockCodec, OrderedBitsAreInTheOrderOfTheNumbers) {
    const float values[] = {-65504.0f, -1.0f, -6e-8f, 0.0f, 6e-8f, 0.1f, 65504.0f};
    for (std::size_t i = 0; i + 1 < std::size(values); ++i) {
        std::uint32_t low = HalfOfFloat(values[i]);
        std::uint32_t high = HalfOfFloat(values[i + 1]);
        EXPECT_LT(shared::codec_orderOfHalf(low), shared::codec_orderOfHalf(high));
        EXPECT_EQ(shared::codec_halfOfOrder(shared::codec_orderOfHalf(low)), low);
        std::memcpy(&low, &values[i], 4);
        std::memcpy(&high, &values[i + 1], 4);
        EXPECT_LT(shared::codec_orderOfFloat(low), shared::codec_orderOfFloat(high));
        EXPECT_EQ(shared::codec_floatOfOrder(shared::codec_orderOfFloat(low)), low);
    }
    EXPECT_EQ(shared::codec_orderOfHalf(0x8000u), shared::codec_orderOfHalf(0u));
    EXPECT_EQ(shared::codec_orderOfFloat(0x80000000u), shared::codec_orderOfFloat(0u));
}

} // namespace
} // namespace hds
