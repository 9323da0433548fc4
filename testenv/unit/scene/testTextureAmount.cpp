// SPDX-License-Identifier: Apache-2.0
// Displacement by images: look-ups against closed forms, ranges that hold, coordinates of any kind.
#include "hdStream/scene/meshDisplacement.h"
#include "hdStream/scene/textureAmount.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace hds {
namespace {

/// Texel (x, y) of 4 x 2, rows from the top, holds 10 y + x.
DisplacementLookup Ramp(std::uint32_t wrap) {
    auto image = std::make_shared<HeightImage>();
    image->width = 4;
    image->height = 2;
    image->values = {0, 1, 2, 3, 10, 11, 12, 13};
    DisplacementLookup lookup;
    lookup.wrapS = wrap;
    lookup.wrapT = wrap;
    lookup.image = std::move(image);
    return lookup;
}

double At(const DisplacementAmount& amount, double s, double t) {
    AmountPoint point = MissingPoint(amount);
    point.primvars[0] = {s, t, 0.0, 0.0};
    return amount.At(point);
}

TEST(TextureAmount, IsBilinearBetweenTexels) {
    const auto amount = MakeTextureAmount("st", Ramp(HDS_WRAP_CLAMP));
    ASSERT_EQ(amount->Primvars().size(), 1U);
    EXPECT_EQ(amount->Primvars()[0].names, std::vector<std::string>{"st"});
    EXPECT_EQ(amount->Primvars()[0].numComponents, 2U);
    EXPECT_DOUBLE_EQ(At(*amount, 0.125, 0.75), 0.0) << "the centre of the upper left texel";
    EXPECT_DOUBLE_EQ(At(*amount, 0.625, 0.25), 12.0);
    EXPECT_DOUBLE_EQ(At(*amount, 0.5, 0.5), 6.5) << "where four meet";
    EXPECT_DOUBLE_EQ(At(*amount, -3.0, 9.0), 0.0) << "clamped";
}

TEST(TextureAmount, WrapsAsLookUpsDo) {
    EXPECT_DOUBLE_EQ(At(*MakeTextureAmount("st", Ramp(HDS_WRAP_REPEAT)), 1.125, -0.75), 10.0);
    EXPECT_DOUBLE_EQ(At(*MakeTextureAmount("st", Ramp(HDS_WRAP_REPEAT)), 0.0, 0.75), 1.5);
    EXPECT_DOUBLE_EQ(At(*MakeTextureAmount("st", Ramp(HDS_WRAP_MIRROR)), 1.125, 0.75), 3.0);
    EXPECT_DOUBLE_EQ(At(*MakeTextureAmount("st", Ramp(HDS_WRAP_BLACK)), 1.5, 0.75), 0.0);
    EXPECT_DOUBLE_EQ(At(*MakeTextureAmount("st", Ramp(HDS_WRAP_BLACK)), 1.0, 0.75), 1.5);
}

TEST(TextureAmount, TransformsScalesAndFallsBack) {
    DisplacementLookup lookup = Ramp(HDS_WRAP_CLAMP);
    lookup.rows = {0, 1, 0.125, 1, 0, 0.25}; // (s, t) -> (t + 0.125, s + 0.25)
    lookup.scale = -2.0F;
    lookup.bias = 1.0F;
    lookup.missing = {0.5F, 0.5F};
    const auto amount = MakeTextureAmount("st", lookup);
    EXPECT_DOUBLE_EQ(At(*amount, 0.0, 0.5), -2.0 * 12.0 + 1.0);
    EXPECT_DOUBLE_EQ(amount->At(MissingPoint(*amount)), -2.0 * 2.0 + 1.0);
    EXPECT_TRUE(MakeTextureAmount("", lookup)->Primvars().empty());
}

TEST(TextureAmount, NothingIsOutsideItsRange) {
    std::mt19937 generator(1);
    std::uniform_real_distribution<double> position(-3.0, 3.0);
    for (std::uint32_t wrap = HDS_WRAP_BLACK; wrap <= HDS_WRAP_MIRROR; ++wrap) {
        DisplacementLookup lookup = Ramp(wrap);
        lookup.scale = -0.5F;
        lookup.bias = 20.0F;
        const auto amount = MakeTextureAmount("st", lookup);
        const AmountRange range = amount->Over({});
        EXPECT_DOUBLE_EQ(range.low, 13.5);
        EXPECT_DOUBLE_EQ(range.high, 20.0);
        for (int i = 0; i < 1000; ++i) {
            const double value = At(*amount, position(generator), position(generator));
            ASSERT_GE(value, range.low - 1e-12);
            ASSERT_LE(value, range.high + 1e-12);
        }
        for (const double odd : {double(NAN), double(INFINITY), 1e300, -1e300}) {
            EXPECT_TRUE(std::isfinite(At(*amount, odd, 0.5))) << odd;
        }
    }
}

TEST(TextureAmount, AnUnreadableImageLeavesTheFallback) {
    DisplacementInput input;
    input.constant = 0.75F;
    input.primvar = "st";
    input.lookup = Ramp(HDS_WRAP_CLAMP);
    EXPECT_EQ(MakeDisplacement({input})[0]->Primvars().size(), 1U);
    input.lookup->image = nullptr;
    const Displacement displacement = MakeDisplacement({input});
    EXPECT_TRUE(displacement[0]->Primvars().empty());
    EXPECT_DOUBLE_EQ(displacement[0]->At({}), 0.75);
}

} // namespace
} // namespace hds
