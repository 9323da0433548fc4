// SPDX-License-Identifier: Apache-2.0
// The distributions of images on lights.
#include "hdStream/shading/lightImage.h"

#include <gtest/gtest.h>

#include <cmath>

namespace hds {
namespace {

constexpr double kPi = 3.14159265358979323846;

LightImage Constant(std::uint32_t width, std::uint32_t height, float value) {
    return {width, height, std::vector<float>(std::size_t(width) * height * 3, value)};
}

TEST(LightImageTableTest, AConstantImageIsUniformOverTheSphere) {
    const LightImageTable table = BuildLatLongTable(Constant(8, 4, 3.0F));
    EXPECT_NEAR(table.meanLuminance, 3.0, 1e-6);
    for (std::uint32_t y = 0; y <= 4; ++y) {
        EXPECT_NEAR(table.cdf[y], 0.5 - 0.5 * std::cos(kPi * y / 4.0), 1e-6); // area above row y
    }
    for (std::uint32_t x = 0; x <= 8; ++x) {
        EXPECT_NEAR(table.cdf[5 + x], x / 8.0, 1e-6);
    }
}

TEST(LightImageTableTest, ABrightTexelSpreadsAsItsBilinearTent) {
    LightImage image = Constant(16, 8, 0.0F);
    for (int c = 0; c < 3; ++c) {
        image.rgb[(4 * 16 + 0) * 3 + std::size_t(c)] = 1.0F; // at the seam, row 4
    }
    const LightImageTable table = BuildLatLongTable(image);
    const auto weight = [&](std::size_t x, std::size_t y) {
        const float* row = &table.cdf[9 + y * 17];
        return double(table.cdf[y + 1] - table.cdf[y]) * (row[x + 1] - row[x]) /
               std::sin((double(y) + 0.5) * kPi / 8.0);
    };
    const double peak = weight(0, 4);
    EXPECT_NEAR(weight(1, 4) / peak, 1.0 / 6.0, 1e-5);
    EXPECT_NEAR(weight(15, 4) / peak, 1.0 / 6.0, 1e-5) << "longitude wraps";
    EXPECT_NEAR(weight(0, 3) / peak, 1.0 / 6.0, 1e-5);
    EXPECT_NEAR(weight(1, 5) / peak, 1.0 / 36.0, 1e-5);
    EXPECT_EQ(weight(2, 4), 0.0);
    EXPECT_EQ(weight(0, 6), 0.0);
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
    const LightImageTable table = BuildLatLongTable(Constant(4, 2, 0.0F));
    EXPECT_EQ(table.meanLuminance, 0.0);
    EXPECT_FLOAT_EQ(table.cdf[1], 0.5F);
    EXPECT_FLOAT_EQ(table.cdf[2], 1.0F);
}

TEST(LightImageTableTest, SanitizesAndShrinks) {
    LightImage image = Constant(8, 4, 1.0F);
    image.rgb[0] = -1.0F;
    image.rgb[1] = INFINITY;
    image.rgb[2] = std::nanf("");
    EXPECT_EQ(SanitizeLightImage(image), 3U);
    EXPECT_EQ(image.rgb[0] + image.rgb[1] + image.rgb[2], 0.0F);
    ShrinkLightImage(image, 4);
    EXPECT_EQ(image.width, 4U);
    EXPECT_EQ(image.height, 2U);
    EXPECT_FLOAT_EQ(image.rgb[0], 0.75F);
    EXPECT_FLOAT_EQ(image.rgb[3], 1.0F);
}

} // namespace
} // namespace hds
