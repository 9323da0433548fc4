// SPDX-License-Identifier: Apache-2.0
// The distributions of images on lights.
#include "hdStream/shading/lightImage.h"

#include "kernels/shared/compat.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstring>

namespace hds {
namespace {

constexpr double kPi = 3.14159265358979323846;

LightImage Constant(std::uint32_t width, std::uint32_t height, float value) {
    return {width, height, std::vector<float>(std::size_t(width) * height * 3, value), 0};
}

TEST(LightImageTableTest, AConstantImageIsUniformOverTheSphere) {
    for (const bool leavesMean : {true, false}) {
        const LightImageTable table = BuildLatLongTable(Constant(8, 4, 3.0F), leavesMean);
        EXPECT_NEAR(table.meanLuminance, 3.0, 1e-6);
        EXPECT_EQ(table.width, 8U);
        ASSERT_EQ(table.numRows, 5U);
        for (std::uint32_t y = 0; y <= 5; ++y) {
            // Rows begin at the poles and between texels; the area above row y.
            const double begin = std::clamp((double(y) - 0.5) / 4.0, 0.0, 1.0);
            EXPECT_NEAR(table.cdf[y], 0.5 - 0.5 * std::cos(kPi * begin), 1e-6);
        }
        for (std::uint32_t x = 0; x <= 8; ++x) {
            EXPECT_NEAR(table.cdf[6 + x], x / 8.0, 1e-6);
        }
    }
}

/// Rows of luminance 1 and 9 have the mean 5, of which half is left to BSDF samples. Other
/// lights are sampled in proportion.
TEST(LightImageTableTest, HalfOfTheMeanIsLeftToBsdfSamples) {
    LightImage image = Constant(8, 4, 1.0F);
    std::fill(image.rgb.begin() + 2 * 8 * 3, image.rgb.end(), 9.0F);
    for (const bool leavesMean : {true, false}) {
        const LightImageTable table = BuildLatLongTable(image, leavesMean);
        EXPECT_NEAR(table.meanLuminance, 5.0, 1e-6) << "estimates count all of it";
        const auto weight = [&](std::size_t y) { // by solid angle
            const double begin = std::clamp((double(y) - 0.5) / 4.0, 0.0, 1.0);
            const double end = std::clamp((double(y) + 0.5) / 4.0, 0.0, 1.0);
            return double(table.cdf[y + 1] - table.cdf[y]) /
                   (std::cos(kPi * begin) - std::cos(kPi * end));
        };
        EXPECT_NEAR(weight(2) / weight(4), leavesMean ? 2.5 / 6.5 : 5.0 / 9.0, 1e-4);
        EXPECT_NEAR(weight(1) / weight(4), leavesMean ? 0.0 : 1.0 / 9.0, 1e-4);
        EXPECT_GT(weight(0), 0.0);
    }
}

TEST(LightImageTableTest, ABrightTexelSharesTheCellsAroundIt) {
    LightImage image = Constant(16, 8, 0.0F);
    for (int c = 0; c < 3; ++c) {
        image.rgb[(4 * 16 + 0) * 3 + std::size_t(c)] = 1.0F; // at the seam, row 4
    }
    const LightImageTable table = BuildLatLongTable(image, false);
    const auto weight = [&](std::size_t x, std::size_t y) {
        const float* row = &table.cdf[10 + y * 17];
        return double(table.cdf[y + 1] - table.cdf[y]) * (row[x + 1] - row[x]) /
               std::sin(double(y) * kPi / 8.0);
    };
    const double peak = weight(0, 4);
    EXPECT_NEAR(weight(15, 4) / peak, 1.0, 1e-5) << "longitude wraps";
    EXPECT_NEAR(weight(0, 5) / peak, 1.0, 1e-5);
    EXPECT_NEAR(weight(15, 5) / peak, 1.0, 1e-5);
    for (const double dark : {weight(1, 4), weight(0, 6), weight(0, 3)}) {
        EXPECT_GT(dark, 0.0) << "finer mips may be bright here";
        EXPECT_LT(dark / peak, 1e-5);
    }
}

/// 16 bits beside the largest channel, whatever the size of the numbers.
TEST(LightImageTableTest, TexelsKeepSixteenBits) {
    LightImage image = Constant(3, 2, 0.7F);
    const float colors[3][3] = {{1e5F, 3.0F, 0.123F}, {1e-30F, 3e-31F, 0.0F}, {0.0F, 0.0F, 0.0F}};
    std::memcpy(image.rgb.data(), colors, sizeof(colors));
    image.rgb[3 * 5] = 65535.99F; // rounds up to the next power of two
    const LightImageTable table = BuildLatLongTable(image, false);
    ASSERT_EQ(table.cdf.size(), 4U + 3U * 4U + 6U * 2U);
    for (std::size_t i = 0; i < 6; ++i) {
        std::uint32_t words[2];
        std::memcpy(words, &table.cdf[16 + 2 * i], sizeof(words));
        const double unit = shared::FloatOfBits(words[1] >> 16U << 23U);
        const double texel[3] = {(words[0] & 0xffffU) * unit, (words[0] >> 16U) * unit,
                                 (words[1] & 0xffffU) * unit};
        const float* expected = &image.rgb[3 * i];
        const double largest = *std::max_element(expected, expected + 3);
        for (std::size_t c = 0; c < 3; ++c) {
            EXPECT_NEAR(texel[c], expected[c], 0x1p-16 * largest) << i << " " << c;
        }
    }
}

/// The mass of every box is that of its cells; beside a sun of 1e9 no cell is without.
TEST(LightImageTableTest, SumsOfCellsAreExact) {
    LightImage image = Constant(16, 8, 0.0F);
    image.rgb[(2 * 16 + 5) * 3 + 1] = 1e9F;
    image.rgb[(6 * 16 + 9) * 3 + 1] = 100.0F;
    const LightImageTable table = BuildLatLongTable(image, false);
    const std::vector<std::uint32_t> sums = SumCells(table.cdf.data(), 16, 9);
    ASSERT_EQ(sums.size(), 10U * 17U);
    const auto box = [&](std::size_t x0, std::size_t y0, std::size_t x1, std::size_t y1) {
        return sums[y1 * 17 + x1] - sums[y0 * 17 + x1] - sums[y1 * 17 + x0] + sums[y0 * 17 + x0];
    };
    std::uint64_t all = 0;
    for (std::size_t y = 0; y < 9; ++y) {
        const float* row = &table.cdf[10 + y * 17];
        for (std::size_t x = 0; x < 16; ++x) {
            const double share =
                (double(table.cdf[y + 1]) - table.cdf[y]) * (double(row[x + 1]) - row[x]);
            EXPECT_GE(box(x, y, x + 1, y + 1), 1U);
            EXPECT_NEAR(box(x, y, x + 1, y + 1), share * 0x1p32, 1.0 + share * 256.0);
            all += box(x, y, x + 1, y + 1);
        }
    }
    EXPECT_EQ(all, box(0, 0, 16, 9)) << "no overflow";
}

TEST(LightImageTableTest, AFlatImageCountsAreaAndEndsAtItsEdges) {
    LightImage image = Constant(4, 2, 0.0F);
    for (int c = 0; c < 3; ++c) {
        image.rgb[std::size_t(c)] = 8.0F; // the corner goes on beyond the edges
    }
    const LightImageTable table = BuildFlatTable(image);
    EXPECT_NEAR(table.meanLuminance, 1.0, 1e-6);
    EXPECT_NEAR(table.cdf[1], 7.0 / 8.0, 1e-6);
    const float* row = &table.cdf[3];
    EXPECT_NEAR(row[1], 7.0 / 8.0, 1e-6);
    EXPECT_NEAR(row[2], 1.0, 1e-6);
    EXPECT_NEAR(row[3], 1.0, 1e-6) << "the other side is dark";
}

TEST(LightImageTableTest, ABlackImageIsNotAnError) {
    const LightImageTable table = BuildLatLongTable(Constant(4, 2, 0.0F), true);
    EXPECT_EQ(table.meanLuminance, 0.0);
    EXPECT_FLOAT_EQ(table.cdf[1], 1.0F / 3.0F);
    EXPECT_FLOAT_EQ(table.cdf[3], 1.0F);
}

/// A sun that is all but all of the power: what floats make of the sums may leave no cell out.
TEST(LightImageTableTest, NoCellIsWithoutAShare) {
    constexpr std::uint32_t kWidth = 8192;
    LightImage image = Constant(kWidth, 3, 1e-20F);
    for (std::size_t c = 0; c < 3; ++c) {
        image.rgb[std::size_t{3} * kWidth + c] = 1e10F; // first in the middle row
    }
    for (const LightImageTable& table : {BuildLatLongTable(image, true), BuildFlatTable(image)}) {
        for (std::uint32_t y = 0; y < table.numRows; ++y) {
            ASSERT_GT(table.cdf[y + 1], table.cdf[y]) << y;
            const float* row = &table.cdf[table.numRows + 1 + y * (kWidth + 1)];
            ASSERT_EQ(row[0], 0.0F);
            ASSERT_EQ(row[kWidth], 1.0F);
            for (std::uint32_t x = 0; x < kWidth; ++x) {
                ASSERT_GT(row[x + 1], row[x]) << x << " " << y;
            }
        }
        const float* row = &table.cdf[table.numRows + 1 + kWidth + 1];
        // A cell of a dome has one half of the texel's width, a cell of a rect most of its tent.
        const bool isDome = table.numRows > 3;
        EXPECT_GT(row[1], isDome ? 0.4F : 0.7F) << "the sun's own cell keeps its share";
    }
}

TEST(LightImageTableTest, TheTableMipIsTheFinestThatIsSmallEnough) {
    EXPECT_EQ(FindTableMip(1, 1), 0U);
    EXPECT_EQ(FindTableMip(2048, 1024), 0U);
    EXPECT_EQ(FindTableMip(2050, 1025), 1U);
    EXPECT_EQ(FindTableMip(16384, 8192), 3U);
    EXPECT_EQ(FindTableMip(8192, 1), 0U);
    EXPECT_EQ(FindTableMip(1, 131072), 4U);
}

} // namespace
} // namespace hds
