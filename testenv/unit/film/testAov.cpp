// SPDX-License-Identifier: Apache-2.0
#include "hdStream/film/aov.h"

#include "hdStream/base/error.h"

#include <gtest/gtest.h>

#include <set>

namespace {

TEST(Aov, TableHasEveryAovOfTheContractOnce) {
    const std::set<std::string> expected{"color",
                                         "alpha",
                                         "depth",
                                         "cameraDepth",
                                         "normal",
                                         "Neye",
                                         "position",
                                         "albedo",
                                         "primId",
                                         "instanceId",
                                         "elementId",
                                         "variance",
                                         "noisy",
                                         "sampleCount",
                                         "crypto_object",
                                         "crypto_material",
                                         "crypto_instance",
                                         "emission",
                                         "diffuse",
                                         "specular",
                                         "transmission",
                                         "volume",
                                         "direct",
                                         "indirect",
                                         "directDiffuse",
                                         "indirectDiffuse",
                                         "directSpecular",
                                         "indirectSpecular",
                                         "directTransmission",
                                         "indirectTransmission",
                                         "Peye",
                                         "facingRatio",
                                         "motionForward",
                                         "motionBackward",
                                         "ambientOcclusion",
                                         "volumeDepth"};
    std::set<std::string> names;
    for (const hds::AovInfo& info : hds::AovTable()) {
        EXPECT_TRUE(names.insert(info.name).second) << info.name;
        EXPECT_FALSE(info.description.empty()) << info.name;
        const std::set<std::string> channels(info.channels.begin(), info.channels.end());
        EXPECT_EQ(channels.size(), info.channels.size()) << info.name;
        EXPECT_FALSE(channels.empty()) << info.name;
        EXPECT_EQ(hds::FindAov(info.name), &info);
    }
    EXPECT_EQ(names, expected);
    EXPECT_EQ(hds::FindAov("colour"), nullptr);
}

TEST(Aov, SumsAreInTheOrderThatFilmsKeepThemIn) {
    hds::AovLayout layout = hds::MakeAovLayout({"ambientOcclusion", "color", "diffuse"});
    EXPECT_EQ(layout.SumNames(), (std::vector<std::string>{"C<RD>.*[LO]", "ambientOcclusion"}));
    layout.hasCatchers = true;
    EXPECT_EQ(layout.SumNames(), (std::vector<std::string>{"C<RD>.*[LO]", "catchers",
                                                           "catchersAlone", "ambientOcclusion"}));
    EXPECT_TRUE(hds::IsSummed("ambientOcclusion"));
    EXPECT_TRUE(hds::MakeAovLayout({"color"}).SumNames().empty());
}

TEST(Aov, ClearValuesOfHydra) {
    EXPECT_EQ(hds::FindAov("depth")->clearValue, 1.0f);
    EXPECT_GT(hds::FindAov("cameraDepth")->clearValue, 3.4e38f);
    EXPECT_EQ(hds::FindAov("color")->clearValue, 0.0f);
    for (const char* name : {"primId", "instanceId", "elementId"}) {
        EXPECT_TRUE(hds::FindAov(name)->isInteger);
        EXPECT_EQ(hds::FindAov(name)->clearId, -1);
    }
}

TEST(Aov, LayoutPacksFloatsAndIntsApart) {
    const hds::AovLayout layout =
        hds::MakeAovLayout({"depth", "primId", "color", "elementId", "normal"});
    EXPECT_EQ(layout.floatsPerPixel, 1u + 4u + 3u);
    EXPECT_EQ(layout.intsPerPixel, 2u);
    EXPECT_EQ(layout.Find("depth")->offset, 0u);
    EXPECT_EQ(layout.Find("color")->offset, 1u);
    EXPECT_EQ(layout.Find("normal")->offset, 5u);
    EXPECT_EQ(layout.Find("primId")->offset, 0u);
    EXPECT_EQ(layout.Find("elementId")->offset, 1u);
    EXPECT_EQ(layout.Find("alpha"), nullptr);
}

TEST(Aov, WrongNamesAreUsageErrorsThatNameThem) {
    const std::vector<std::vector<std::string>> cases{{"color", "colour"}, {"color", "color"}, {}};
    for (const auto& names : cases) {
        try {
            hds::MakeAovLayout(names);
            ADD_FAILURE() << "no error";
        } catch (const hds::Error& error) {
            EXPECT_EQ(error.kind(), hds::ErrorKind::Usage);
            if (!names.empty()) {
                EXPECT_NE(std::string(error.what()).find("'" + names.back() + "'"),
                          std::string::npos)
                    << error.what();
            }
        }
    }
}

TEST(Aov, LayersAreCutOutOfTheBuffers) {
    const hds::AovLayout layout = hds::MakeAovLayout({"primId", "normal", "depth"});
    const std::vector<float> floats{1, 2, 3, 4, 5, 6, 7, 8}; // two pixels of (normal, depth)
    const std::vector<std::int32_t> ints{-1, 9};
    const std::vector<hds::ImageLayer> layers =
        hds::MakeLayers(layout, 2, 1, floats.data(), ints.data());
    ASSERT_EQ(layers.size(), 3u);
    EXPECT_EQ(layers[0].name, "primId");
    EXPECT_TRUE(layers[0].isInteger);
    EXPECT_EQ(layers[0].ids, ints);
    EXPECT_TRUE(layers[0].values.empty());
    EXPECT_EQ(layers[1].values, (std::vector<float>{1, 2, 3, 5, 6, 7}));
    EXPECT_EQ(layers[2].values, (std::vector<float>{4, 8}));
    EXPECT_EQ(layers[2].channels, std::vector<std::string>{"Z"});
    EXPECT_EQ(layers[2].width, 2u);
    EXPECT_EQ(layers[2].height, 1u);
}

TEST(Aov, ClearLayerIsFilled) {
    const hds::ImageLayer ids = hds::MakeClearLayer(*hds::FindAov("elementId"), 3, 2);
    EXPECT_EQ(ids.ids, std::vector<std::int32_t>(6, -1));
    const hds::ImageLayer depth = hds::MakeClearLayer(*hds::FindAov("depth"), 3, 2);
    EXPECT_EQ(depth.values, std::vector<float>(6, 1.0f));
}

TEST(Aov, APreviewFillsSquaresOrStaysClear) {
    hds::ImageLayer known = hds::MakeClearLayer(*hds::FindAov("normal"), 2, 2);
    for (std::size_t i = 0; i < known.values.size(); ++i) {
        known.values[i] = float(i + 1); // of 5 x 3 pixels those at (0, 0) and (4, 0)
    }
    hds::ImageLayer ids = hds::MakeClearLayer(*hds::FindAov("elementId"), 2, 2);
    ids.ids = {7, 8, 9, 10};
    const auto shown = [&](const hds::ImageLayer& from, hds::PreviewFill fill) {
        return hds::EnlargePreview(*hds::FindAov(from.name), from, 5, 3, 4, fill);
    };
    known.height = ids.height = 1;
    EXPECT_EQ(shown(ids, hds::PreviewFill::Squares).ids,
              (std::vector<std::int32_t>{7, 7, 7, 7, 8, 7, 7, 7, 7, 8, 7, 7, 7, 7, 8}));
    EXPECT_EQ(
        shown(ids, hds::PreviewFill::Clear).ids,
        (std::vector<std::int32_t>{7, -1, -1, -1, 8, -1, -1, -1, -1, -1, -1, -1, -1, -1, -1}));
    const hds::ImageLayer squares = shown(known, hds::PreviewFill::Squares);
    ASSERT_EQ(squares.values.size(), 45U);
    for (std::size_t pixel = 0; pixel < 15; ++pixel) {
        for (std::size_t c = 0; c < 3; ++c) {
            EXPECT_EQ(squares.values[3 * pixel + c], float(c + (pixel % 5 == 4 ? 4 : 1)));
        }
    }
    EXPECT_EQ(squares.width, 5U);
    EXPECT_EQ(squares.height, 3U);
}

} // namespace
