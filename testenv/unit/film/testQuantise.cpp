// SPDX-License-Identifier: Apache-2.0
// Oracles: IEC 61966-2-1's formula in long double and rounding by hand; OpenColorIO configurations
// written here with transforms whose results are known in closed form.
#include "hdStream/film/quantise.h"

#include "hdStream/base/error.h"
#include "testenv/support/temporaryFolder.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <limits>

namespace {

using hds::ColorCorrection;

hds::ImageLayer ColorLayer(std::uint32_t width, std::vector<float> values) {
    hds::ImageLayer layer;
    layer.name = "color";
    layer.channels = {"R", "G", "B", "A"};
    layer.width = width;
    layer.height = static_cast<std::uint32_t>(values.size() / 4 / width);
    layer.values = std::move(values);
    return layer;
}

/// Sets $OCIO while it lives.
class OcioVariable {
public:
    explicit OcioVariable(const std::string& value) { setenv("OCIO", value.c_str(), 1); }
    ~OcioVariable() { unsetenv("OCIO"); }
};

TEST(Quantise, RoundsToTheNearestCode) {
    for (int code = 0; code <= 255; ++code) {
        const float exact = static_cast<float>(code / 255.0);
        EXPECT_EQ(hds::QuantiseUnit(exact), code);
        EXPECT_EQ(hds::QuantiseUnit(exact + 0.49f / 255), code < 255 ? code : 255);
        EXPECT_EQ(hds::QuantiseUnit(exact + 0.51f / 255), code < 255 ? code + 1 : 255);
    }
    EXPECT_EQ(hds::QuantiseUnit(-1.0f), 0);
    EXPECT_EQ(hds::QuantiseUnit(7.0f), 255);
    EXPECT_EQ(hds::QuantiseUnit(std::numeric_limits<float>::infinity()), 255);
    EXPECT_EQ(hds::QuantiseUnit(-std::numeric_limits<float>::infinity()), 0);
    EXPECT_EQ(hds::QuantiseUnit(std::numeric_limits<float>::quiet_NaN()), 0);
}

TEST(Quantise, SrgbEqualsTheStandardForEveryPixel) {
    std::vector<float> values;
    for (int i = 0; i < 65536; ++i) {
        const float v = static_cast<float>(i) / 65000.0f;
        values.insert(values.end(), {v, v * 0.01f, 1.0f - v, 1.0f});
    }
    const hds::ImageLayer layer = ColorLayer(256, values);
    const hds::DisplayTransform transform(ColorCorrection::Srgb);
    const hds::QuantisedImage image =
        hds::QuantiseLayer(layer, transform, hds::AlphaMode::Unpremultiplied);
    ASSERT_EQ(image.numChannels, 4u);
    for (std::size_t i = 0; i < values.size(); ++i) {
        const long double v = std::min(1.0L, std::max(0.0L, static_cast<long double>(values[i])));
        const long double encoded =
            i % 4 == 3
                ? v
                : (v <= 0.0031308L ? v * 12.92L : 1.055L * std::pow(v, 1.0L / 2.4L) - 0.055L);
        const long double code = encoded * 255;
        // Floats between transform and rounding may move a value across a half by 1e-5 of a code.
        const long double toHalf = std::fabs(code - std::floor(code) - 0.5L);
        if (toHalf > 2e-5L) {
            ASSERT_EQ(image.values[i], static_cast<int>(std::floor(code + 0.5L))) << values[i];
        }
    }
}

TEST(Quantise, PngDividesByAlphaAndJpegDoesNot) {
    const hds::ImageLayer layer = ColorLayer(3, {0.1f, 0.2f, 0.25f, 0.5f, // half covered
                                                 0.1f, 0.2f, 0.3f, 0.0f,  // light without coverage
                                                 0.4f, 0.6f, 0.8f, 1.0f});
    const hds::DisplayTransform linear(ColorCorrection::Disabled);
    EXPECT_EQ(hds::QuantiseLayer(layer, linear, hds::AlphaMode::Unpremultiplied).values,
              (std::vector<std::uint8_t>{51, 102, 128, 128, 26, 51, 77, 0, 102, 153, 204, 255}));
    const hds::QuantisedImage black = hds::QuantiseLayer(layer, linear, hds::AlphaMode::OverBlack);
    EXPECT_EQ(black.numChannels, 3u);
    EXPECT_EQ(black.values, (std::vector<std::uint8_t>{26, 51, 64, 26, 51, 77, 102, 153, 204}));
}

TEST(Quantise, SingleChannelStaysSingle) {
    hds::ImageLayer layer;
    layer.name = "depth";
    layer.channels = {"Z"};
    layer.width = 2;
    layer.height = 1;
    layer.values = {0.0f, 1.0f};
    const hds::DisplayTransform linear(ColorCorrection::Disabled);
    EXPECT_EQ(hds::QuantiseLayer(layer, linear, hds::AlphaMode::Unpremultiplied).values,
              (std::vector<std::uint8_t>{0, 255}));
}

TEST(DisplayTransform, ModesAreReadAsUsdrecordNamesThem) {
    EXPECT_EQ(hds::ParseColorCorrection("disabled"), ColorCorrection::Disabled);
    EXPECT_EQ(hds::ParseColorCorrection("sRGB"), ColorCorrection::Srgb);
    EXPECT_EQ(hds::ParseColorCorrection("openColorIO"), ColorCorrection::OpenColorIO);
    EXPECT_EQ(hds::ParseColorCorrection(""), ColorCorrection::Automatic);
    try {
        hds::ParseColorCorrection("srgb?");
        ADD_FAILURE();
    } catch (const hds::Error& error) {
        EXPECT_EQ(error.kind(), hds::ErrorKind::Usage);
        EXPECT_NE(std::string(error.what()).find("srgb?"), std::string::npos);
    }
}

TEST(DisplayTransform, BuiltInOpenColorIoDisplayIsSrgb) {
    unsetenv("OCIO");
    const hds::DisplayTransform ocio(ColorCorrection::OpenColorIO);
    const hds::DisplayTransform srgb(ColorCorrection::Automatic);
    for (int i = 0; i <= 1000; ++i) {
        float a[3] = {static_cast<float>(i) / 1000, 0.0f, 1.0f};
        float b[3] = {a[0], a[1], a[2]};
        ocio.Apply(a, 1);
        srgb.Apply(b, 1);
        for (int c = 0; c < 3; ++c) {
            // OpenColorIO joins the two pieces smoothly: 1e-5 apart near black, 1/400 of a code.
            EXPECT_NEAR(a[c], b[c], 2e-5);
        }
    }
}

/// A configuration whose default view squares: exponents are exact enough in closed form.
const char* const kSquareConfig = R"(ocio_profile_version: 2
search_path: ""
strictparsing: true
roles:
  default: raw
  scene_linear: lin
file_rules:
  - !<Rule> {name: Default, colorspace: default}
displays:
  wall:
    - !<View> {name: square, colorspace: squared}
    - !<View> {name: plain, colorspace: lin}
active_displays: [wall]
active_views: [square, plain]
colorspaces:
  - !<ColorSpace>
    name: raw
    isdata: true
  - !<ColorSpace>
    name: lin
  - !<ColorSpace>
    name: squared
    from_scene_reference: !<ExponentTransform> {value: 2}
)";

TEST(DisplayTransform, EnvironmentConfigDecidesWhenAutomatic) {
    const hds::test::TemporaryFolder folder;
    const std::string file = folder.File("config.ocio");
    hds::test::WriteFile(file, kSquareConfig);
    const OcioVariable variable(file);
    const hds::DisplayTransform transform(ColorCorrection::Automatic);
    float rgb[3] = {0.5f, 0.25f, 2.0f};
    transform.Apply(rgb, 1);
    EXPECT_NEAR(rgb[0], 0.25f, 1e-6f);
    EXPECT_NEAR(rgb[1], 0.0625f, 1e-6f);
    EXPECT_NEAR(rgb[2], 4.0f, 1e-5f);
    const hds::DisplayTransform srgb(ColorCorrection::Srgb); // named: the variable is not asked
    float plain[3] = {0.5f, 0.5f, 0.5f};
    srgb.Apply(plain, 1);
    EXPECT_NEAR(plain[0], 0.735357f, 1e-6f);
}

TEST(DisplayTransform, BrokenConfigIsAnErrorThatNamesIt) {
    const hds::test::TemporaryFolder folder;
    const std::string broken = folder.File("broken.ocio");
    hds::test::WriteFile(broken, "this is no configuration: [\n");
    for (const std::string& file : {broken, folder.File("missing.ocio")}) {
        const OcioVariable variable(file);
        try {
            const hds::DisplayTransform transform(ColorCorrection::Automatic);
            ADD_FAILURE() << file;
        } catch (const hds::Error& error) {
            EXPECT_NE(std::string(error.what()).find(file), std::string::npos) << error.what();
            EXPECT_EQ(std::string(error.what()).find('\n'), std::string::npos) << error.what();
        }
    }
}

} // namespace
