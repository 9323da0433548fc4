// SPDX-License-Identifier: Apache-2.0
// Oracles: IEC 61966-2-1's formula in long double; the ACEScg matrix as the Academy publishes it
// (AP1 to linear Rec.709 with Bradford adaptation, ACES 1.x, rounded to 10 digits).
#include "hdStream/texture/colorConversion.h"
#include "hdStream/texture/colorDecoder.h"
#include "hdStream/texture/oneLine.h"
#include "hdStream/texture/srgb.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>

namespace {

TEST(Srgb, EqualsTheStandardAndInvertsItself) {
    for (int i = -600; i <= 600; ++i) {
        const long double v = i / 255.0L;
        const long double a = std::fabs(v);
        const long double linear =
            a <= 0.04045L ? a / 12.92L : std::pow((a + 0.055L) / 1.055L, 2.4L);
        EXPECT_NEAR(hds::LinearFromSrgb(static_cast<double>(v)),
                    static_cast<double>(std::copysign(linear, v)),
                    1e-15 * (1 + double(linear)) * 4);
        // The standard's two pieces meet within 1e-7 only, hence the tolerance of the round trip.
        EXPECT_NEAR(hds::SrgbFromLinear(hds::LinearFromSrgb(static_cast<double>(v))),
                    static_cast<double>(v), 2e-7);
    }
    EXPECT_EQ(hds::LinearFromSrgb(0.0), 0.0);
    EXPECT_NEAR(hds::SrgbFromLinear(1.0), 1.0, 1e-15); // 1.055 - 0.055
    EXPECT_EQ(hds::LinearFromSrgb(1.0), 1.0);
}

hds::ColorDecoder MakeDecoder(const std::string& space) {
    std::string warning;
    hds::ColorDecoder decoder(space, OIIO::ImageSpec(1, 1, 3, OIIO::TypeFloat), &warning);
    EXPECT_EQ(warning, "");
    return decoder;
}

TEST(ColorDecoder, BuiltInSpacesAreWhatTheirNamesSay) {
    const float input[3] = {0.25f, 0.5f, 0.75f};
    for (const char* name : {"lin_rec709", "lin_rec709_scene", "lin_srgb"}) {
        float rgb[3] = {input[0], input[1], input[2]};
        MakeDecoder(name).DecodeRgb(rgb, 1);
        for (int c = 0; c < 3; ++c) {
            EXPECT_EQ(rgb[c], input[c]) << name;
        }
    }
    for (const char* name : {"srgb_texture", "srgb_rec709_scene", "sRGB - Texture"}) {
        float rgb[3] = {input[0], input[1], input[2]};
        MakeDecoder(name).DecodeRgb(rgb, 1);
        for (int c = 0; c < 3; ++c) {
            // OpenColorIO joins the pieces smoothly at 0.0393, not at 0.04045.
            EXPECT_NEAR(rgb[c], hds::LinearFromSrgb(input[c]), 2e-6) << name;
        }
    }
    float power[3] = {input[0], input[1], input[2]};
    MakeDecoder("g22_rec709").DecodeRgb(power, 1);
    for (int c = 0; c < 3; ++c) {
        EXPECT_NEAR(power[c], std::pow(input[c], 2.2), 2e-6);
    }
    for (const char* name : {"raw", "data"}) {
        const hds::ColorDecoder raw = MakeDecoder(name);
        EXPECT_TRUE(raw.IsPerChannel());
        float rgb[3] = {0.3f, -1.0f, 7.0f};
        raw.DecodeRgb(rgb, 1);
        EXPECT_EQ(rgb[0], 0.3f);
        EXPECT_EQ(rgb[1], -1.0f);
        EXPECT_EQ(rgb[2], 7.0f);
    }
}

TEST(ColorDecoder, AcesCgMatrix) {
    const double matrix[3][3] = {{1.7050509927, -0.6217921207, -0.0832588720},
                                 {-0.1302564175, 1.1408047366, -0.0105483191},
                                 {-0.0240033568, -0.1289689761, 1.1529723329}};
    const float input[3] = {0.25f, 0.5f, 0.75f};
    for (const char* name : {"ACEScg", "lin_ap1", "lin_ap1_scene"}) {
        float rgb[3] = {input[0], input[1], input[2]};
        MakeDecoder(name).DecodeRgb(rgb, 1);
        for (int row = 0; row < 3; ++row) {
            const double expected =
                matrix[row][0] * input[0] + matrix[row][1] * input[1] + matrix[row][2] * input[2];
            EXPECT_NEAR(rgb[row], expected, 1e-5) << name; // matrices of both use rounded whites
        }
    }
}

/// What a decoder makes of three numbers of an image of 8 bits or of floats.
std::array<double, 3> Decoded(const std::string& space, OIIO::TypeDesc type) {
    std::string warning;
    const hds::ColorDecoder decoder(space, OIIO::ImageSpec(1, 1, 3, type), &warning);
    EXPECT_EQ(warning, "");
    float rgb[3] = {0.25f, 0.5f, 0.75f};
    decoder.DecodeRgb(rgb, 1);
    return {rgb[0], rgb[1], rgb[2]};
}

TEST(ColorDecoder, ConvertsToAnotherWorkingSpace) {
    const double rec709[3][3] = {{1.7050509927, -0.6217921207, -0.0832588720},
                                 {-0.1302564175, 1.1408047366, -0.0105483191},
                                 {-0.0240033568, -0.1289689761, 1.1529723329}};
    const auto expect = [&](const std::array<double, 3>& aces, bool isEncoded) {
        const double codes[3] = {0.25, 0.5, 0.75};
        for (int row = 0; row < 3; ++row) {
            const double value =
                rec709[row][0] * aces[0] + rec709[row][1] * aces[1] + rec709[row][2] * aces[2];
            EXPECT_NEAR(value, isEncoded ? hds::LinearFromSrgb(codes[row]) : codes[row], 1e-5);
        }
    };
    expect(Decoded("sRGB>ACEScg", OIIO::TypeFloat), true);
    expect(Decoded("auto>ACEScg", OIIO::TypeUInt8), true);
    expect(Decoded("autoColor>ACEScg", OIIO::TypeUInt8), true);
    expect(Decoded("autoColor>ACEScg", OIIO::TypeFloat), false);
    expect(Decoded("lin_rec709>lin_ap1", OIIO::TypeFloat), false);
    const std::array<double, 3> same{0.25, 0.5, 0.75};
    EXPECT_EQ(Decoded("auto>ACEScg", OIIO::TypeFloat), same); // data
    EXPECT_EQ(Decoded("raw>ACEScg", OIIO::TypeUInt8), same);
    EXPECT_EQ(Decoded("ACEScg>ACEScg", OIIO::TypeFloat), same);
    std::string warning;
    const hds::ColorDecoder unknown("sRGB>none", OIIO::ImageSpec(1, 1, 3, OIIO::TypeFloat),
                                    &warning);
    EXPECT_NE(warning.find("'none' cannot be used"), std::string::npos) << warning;
    EXPECT_TRUE(unknown.IsSrgb());
}

/// The same space by way of another, in both directions, is the identity; grey stays grey, since
/// whites are adapted.
TEST(ColorConversion, InvertsItselfAndKeepsWhite) {
    for (const char* name : {"ACEScg", "ACES2065-1", "lin_rec2020", "lin_p3d65", "lin_adobergb",
                             "srgb_ap1", "g22_ap1", "g22_adobergb", "adobergb", "srgb_displayp3"}) {
        ASSERT_TRUE(hds::IsColorSpace(name));
        EXPECT_FALSE(hds::IsDataSpace(name));
        const hds::ColorConversion to("lin_rec709", name);
        const hds::ColorConversion from(name, "lin_rec709");
        EXPECT_FALSE(to.IsIdentity());
        float rgba[8] = {0.25f, 0.5f, 0.75f, 9.0f, 1.0f, 1.0f, 1.0f, 8.0f};
        to.Apply(rgba, 2, 4);
        EXPECT_NEAR(rgba[4], 1.0, 2e-4) << name;
        EXPECT_NEAR(rgba[6], 1.0, 2e-4) << name;
        from.Apply(rgba, 2, 4);
        const float before[8] = {0.25f, 0.5f, 0.75f, 9.0f, 1.0f, 1.0f, 1.0f, 8.0f};
        for (int i = 0; i < 8; ++i) {
            EXPECT_NEAR(rgba[i], before[i], 2e-5) << name << " " << i;
        }
        EXPECT_EQ(rgba[3], 9.0f);
    }
    EXPECT_TRUE(hds::ColorConversion("lin_srgb", "").IsIdentity());
    EXPECT_TRUE(hds::IsDataSpace("raw"));
    EXPECT_TRUE(hds::IsDataSpace("auto"));
    EXPECT_FALSE(hds::IsColorSpace("noSuchSpace"));
}

TEST(ColorDecoder, SrgbOfFloatsDecodesEachChannel) {
    float rgb[6] = {0.0f, 0.02f, 0.5f, 1.0f, 2.0f, -0.5f};
    MakeDecoder("sRGB").DecodeRgb(rgb, 2);
    const double encoded[6] = {0.0, 0.02, 0.5, 1.0, 2.0, -0.5};
    for (int i = 0; i < 6; ++i) {
        EXPECT_NEAR(rgb[i], hds::LinearFromSrgb(encoded[i]), 3e-7 * std::abs(rgb[i]) + 1e-9);
    }
}

TEST(OneLine, JoinsLines) {
    EXPECT_EQ(hds::OneLine("a\nb\r\n\nc\n"), "a; b; c");
    EXPECT_EQ(hds::OneLine("\n"), "");
    EXPECT_EQ(hds::OneLine("plain"), "plain");
}

} // namespace
