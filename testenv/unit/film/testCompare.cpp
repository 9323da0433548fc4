// SPDX-License-Identifier: Apache-2.0
// Oracle: the measures of docs/film.md written out for images of a few known numbers.
#include "hdStream/film/compare.h"

#include "hdStream/film/aov.h"
#include "hdStream/film/imageWriter.h"
#include "testenv/support/temporaryFolder.h"

#include <OpenImageIO/imageio.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>

namespace {

using hds::test::TemporaryFolder;

constexpr float kInf = std::numeric_limits<float>::infinity();
constexpr float kNan = std::numeric_limits<float>::quiet_NaN();

hds::ImageLayer Depth(std::vector<float> values) {
    hds::ImageLayer layer =
        hds::MakeClearLayer(*hds::FindAov("depth"), static_cast<std::uint32_t>(values.size()), 1);
    layer.values = std::move(values);
    return layer;
}

hds::ImageComparison Compare(const std::vector<hds::ImageLayer>& a,
                             const std::vector<hds::ImageLayer>& b) {
    const TemporaryFolder folder;
    hds::WriteImage(folder.File("a.exr"), a);
    hds::WriteImage(folder.File("b.exr"), b);
    return hds::CompareImages(folder.File("a.exr"), folder.File("b.exr"));
}

TEST(Compare, MeasuresAreTheirFormulas) {
    const hds::ImageComparison result =
        Compare({Depth({1.0f, 2.0f, 3.0f, 0.0f})}, {Depth({1.0f, 2.5f, 1.0f, 0.0f})});
    ASSERT_TRUE(result.Ok()) << result.error;
    EXPECT_EQ(result.width, 4u);
    EXPECT_EQ(result.height, 1u);
    ASSERT_EQ(result.layers.size(), 1u);
    const hds::LayerDifference& layer = result.layers[0];
    EXPECT_EQ(layer.name, "depth");
    EXPECT_EQ(layer.maxAbs, 2.0);
    EXPECT_DOUBLE_EQ(layer.rmse, std::sqrt((0.25 + 4.0) / 4));
    EXPECT_DOUBLE_EQ(layer.relMse, (0.25 / (6.25 + 0.01) + 4.0 / (1.0 + 0.01)) / 4);
    EXPECT_NEAR(layer.psnr, 10 * std::log10(1.0 / 1.0625), 1e-12);
    EXPECT_EQ(layer.numPixels, 4u);
    EXPECT_EQ(layer.numDifferingPixels, 2u);
    EXPECT_EQ(layer.numNonFinite, 0u);
    EXPECT_TRUE(result.IsAbove(0.5));
    EXPECT_FALSE(result.IsAbove(1.1));
}

TEST(Compare, TheReferenceIsTheSecondFile) {
    const hds::ImageComparison forth = Compare({Depth({1.0f})}, {Depth({3.0f})});
    const hds::ImageComparison back = Compare({Depth({3.0f})}, {Depth({1.0f})});
    EXPECT_DOUBLE_EQ(forth.layers[0].relMse, 4.0 / 9.01);
    EXPECT_DOUBLE_EQ(back.layers[0].relMse, 4.0 / 1.01);
}

TEST(Compare, EqualFilesAreEqual) {
    std::vector<hds::ImageLayer> layers;
    for (const hds::AovInfo& info : hds::AovTable()) {
        layers.push_back(hds::MakeClearLayer(info, 33, 17)); // depths are infinite
    }
    const hds::ImageComparison result = Compare(layers, layers);
    ASSERT_TRUE(result.Ok()) << result.error;
    ASSERT_EQ(result.layers.size(), hds::AovTable().size());
    EXPECT_EQ(result.layers[0].name, "color");
    for (const hds::LayerDifference& layer : result.layers) {
        EXPECT_EQ(layer.maxAbs, 0.0);
        EXPECT_EQ(layer.relMse, 0.0);
        EXPECT_EQ(layer.numDifferingPixels, 0u);
        EXPECT_TRUE(std::isinf(layer.psnr));
        const bool isDepth = layer.name == "cameraDepth" || layer.name == "volumeDepth";
        EXPECT_EQ(layer.numNonFinite, isDepth ? 33u * 17u : 0u) << layer.name;
    }
    EXPECT_FALSE(result.IsAbove(0.0));
}

TEST(Compare, NonFiniteValuesAreNeverGoodEnough) {
    const std::vector<std::pair<float, float>> unlike{{kNan, 1.0f},  {1.0f, kNan},  {kInf, 1.0f},
                                                      {1.0f, -kInf}, {kInf, -kInf}, {kNan, kInf}};
    for (const auto& [a, b] : unlike) {
        const hds::ImageComparison result = Compare({Depth({1.0f, a})}, {Depth({1.0f, b})});
        EXPECT_TRUE(std::isinf(result.layers[0].relMse)) << a << " " << b;
        EXPECT_TRUE(std::isinf(result.layers[0].maxAbs));
        EXPECT_EQ(result.layers[0].numDifferingPixels, 1u);
        EXPECT_EQ(result.layers[0].numNonFinite, 1u);
        EXPECT_TRUE(result.IsAbove(1e30));
    }
    EXPECT_FALSE(Compare({Depth({kNan, kInf})}, {Depth({kNan, kInf})}).IsAbove(0.0));
}

TEST(Compare, LargeIdsAreComparedExactly) {
    hds::ImageLayer a = hds::MakeClearLayer(*hds::FindAov("primId"), 2, 1);
    hds::ImageLayer b = a;
    a.ids = {2000000001, -1};
    b.ids = {2000000000, -1}; // a float could not tell
    const hds::ImageComparison result = Compare({a}, {b});
    EXPECT_EQ(result.layers[0].maxAbs, 1.0);
    EXPECT_EQ(result.layers[0].numDifferingPixels, 1u);
}

TEST(Compare, EightBitValuesAreFractions) {
    const TemporaryFolder folder;
    hds::ImageLayer a = Depth({0.0f, 1.0f});
    hds::ImageLayer b = Depth({0.2f, 1.0f}); // code 51
    hds::WriteImage(folder.File("a.png"), {a});
    hds::WriteImage(folder.File("b.png"), {b});
    const hds::ImageComparison result =
        hds::CompareImages(folder.File("a.png"), folder.File("b.png"));
    ASSERT_TRUE(result.Ok()) << result.error;
    EXPECT_DOUBLE_EQ(result.layers[0].maxAbs, 0.2);
}

TEST(Compare, HalvesAreDecodedExactly) {
    const TemporaryFolder folder;
    const std::vector<float> values{0.0f,    1.0f,        -2.5f, 65504.0f, 5.9604645e-8f,
                                    6.1e-5f, 0.33325195f, -kInf, kInf,     6.103515625e-5f};
    for (const char* name : {"half.exr", "float.exr"}) {
        OIIO::ImageSpec spec(static_cast<int>(values.size()), 1, 1,
                             name == std::string("half.exr") ? OIIO::TypeHalf : OIIO::TypeFloat);
        spec.channelnames = {"Y"};
        const auto output = OIIO::ImageOutput::create(folder.File(name));
        ASSERT_TRUE(output && output->open(folder.File(name), spec));
        ASSERT_TRUE(output->write_image(OIIO::TypeFloat, values.data()));
        ASSERT_TRUE(output->close());
    }
    const hds::ImageComparison result =
        hds::CompareImages(folder.File("half.exr"), folder.File("float.exr"));
    ASSERT_TRUE(result.Ok()) << result.error;
    // 6.1e-5 is the one value here that half cannot hold: it is off by half a step at most.
    EXPECT_LE(result.layers[0].maxAbs, std::ldexp(1.0, -25));
    EXPECT_EQ(result.layers[0].numDifferingPixels, 1u);
}

TEST(Compare, UnlikeImagesAndBadFilesAreErrorsThatNameThem) {
    const TemporaryFolder folder;
    hds::WriteImage(folder.File("a.exr"), {Depth({1.0f, 2.0f})});
    hds::WriteImage(folder.File("b.exr"), {Depth({1.0f, 2.0f, 3.0f})});
    hds::ImageLayer alpha = Depth({1.0f, 2.0f});
    alpha.name = "alpha";
    hds::WriteImage(folder.File("c.exr"), {alpha});
    for (const char* other : {"b.exr", "c.exr", "missing.exr"}) {
        const std::string file = folder.File(other);
        for (const auto& result : {hds::CompareImages(folder.File("a.exr"), file),
                                   hds::CompareImages(file, folder.File("a.exr"))}) {
            EXPECT_FALSE(result.Ok()) << other;
            EXPECT_NE(result.error.find(file), std::string::npos) << result.error;
            EXPECT_EQ(result.error.find('\n'), std::string::npos);
        }
    }
}

/// Else crops of equal size would be compared pixel by pixel, wherever they lie.
TEST(Compare, DifferentPartsOfOnePictureAreNotCompared) {
    const TemporaryFolder folder;
    const auto write = [&](const char* name, std::int32_t x, std::uint32_t displayWidth) {
        hds::ImageWriteOptions options;
        options.metadata.dataWindowMin = {x, 1};
        options.metadata.displayWindowSize = {displayWidth, 4};
        hds::WriteImage(folder.File(name), {Depth({1.0f, 2.0f})}, options);
        return folder.File(name);
    };
    const std::string left = write("left.exr", 1, 8);
    const std::string error = hds::CompareImages(left, write("right.exr", 5, 8)).error;
    EXPECT_EQ(error, left + ": its data window begins at (1, 1) but that of " +
                         folder.File("right.exr") + " at (5, 1)");
    EXPECT_TRUE(hds::CompareImages(left, write("same.exr", 1, 8)).Ok());
    EXPECT_TRUE(hds::CompareImages(left, write("other.exr", 5, 12)).Ok());
    hds::WriteImage(folder.File("plain.exr"), {Depth({1.0f, 2.0f})}); // a cut-out without windows
    EXPECT_TRUE(hds::CompareImages(left, folder.File("plain.exr")).Ok());
}

} // namespace
