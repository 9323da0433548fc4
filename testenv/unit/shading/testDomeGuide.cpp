// SPDX-License-Identifier: Apache-2.0
// The guide of domes: which domes may have one, and distributions of places that rays have left.
#include "hdStream/shading/domeGuide.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstring>
#include <memory>

namespace hds {
namespace {

constexpr std::uint32_t kCells = HDS_GUIDE_ROWS * HDS_GUIDE_COLUMNS;

std::uint32_t BitsAt(const std::vector<float>& words, std::size_t i) {
    std::uint32_t bits = 0;
    std::memcpy(&bits, &words[i], sizeof(bits));
    return bits;
}

DomeLight Even() {
    DomeLight light;
    light.sky.fill(1.0);
    return light;
}

TEST(DomeGuide, EachPlaceThatIsKnownHasADistribution) {
    std::vector<std::uint32_t> cells(std::size_t{HDS_GUIDE_PLACES} * kCells);
    cells[7 * kCells + 40] = 300000; // one direction
    cells[9 * kCells + 3] = 20;      // too little
    constexpr std::uint32_t kBase = 1000;
    const std::vector<float> words = BuildDomeGuide({1.0F, 2.0F, 3.0F}, cells, Even(), kBase);
    ASSERT_EQ(words.size(), 3 + HDS_GUIDE_PLACES + 1 + kCells + 1);
    EXPECT_EQ(words[1], 2.0F);
    for (std::uint32_t place = 0; place < HDS_GUIDE_PLACES; ++place) {
        EXPECT_EQ(BitsAt(words, 3 + place), place == 7 ? kBase + 4 + HDS_GUIDE_PLACES : HDS_NONE);
    }
    EXPECT_EQ(words[3 + HDS_GUIDE_PLACES], 0.9F); // of the light samples
    const float* cdf = &words[4 + HDS_GUIDE_PLACES];
    EXPECT_EQ(cdf[0], 0.0F);
    EXPECT_EQ(cdf[kCells], 1.0F);
    for (std::uint32_t cell = 0; cell < kCells; ++cell) {
        const float share = cdf[cell + 1] - cdf[cell];
        const bool isNear = cell == 39 || cell == 41 || cell == 40 - HDS_GUIDE_COLUMNS ||
                            cell == 40 + HDS_GUIDE_COLUMNS;
        EXPECT_GT(share, 0.0F) << cell; // light may come from anywhere
        EXPECT_LT(share, cell == 40 ? 0.7F : (isNear ? 0.1F : 0.001F)) << cell;
        EXPECT_GT(share, cell == 40 ? 0.6F : (isNear ? 0.07F : 0.0F)) << cell;
    }
}

TEST(DomeGuide, IsNoneWhereNothingIsKnown) {
    std::vector<std::uint32_t> cells(std::size_t{HDS_GUIDE_PLACES} * kCells);
    cells[0] = 100;
    EXPECT_TRUE(BuildDomeGuide({}, cells, Even(), 0).empty());
}

TEST(DomeGuide, IsOfDomesWithoutPortalsAndControls) {
    PlacedLight placed;
    placed.light.type = LightType::Dome;
    const auto mayHave = [](const std::vector<PlacedLight>& lights) {
        Warnings warnings;
        return MayHaveGuide(BuildLightTable(lights, {}, {}, warnings));
    };
    EXPECT_TRUE(mayHave({placed}));
    PlacedLight sun = placed;
    sun.light.type = LightType::Distant;
    EXPECT_FALSE(mayHave({sun}));
    EXPECT_TRUE(mayHave({sun, placed}));
    PlacedLight withImage = placed;
    withImage.light.textureFile.authoredPath = "sky.exr";
    EXPECT_TRUE(mayHave({withImage}));
    PlacedLight through = placed;
    through.portals.push_back({glm::dmat4(1.0), 1.0F, 1.0F});
    EXPECT_FALSE(mayHave({through}));
    PlacedLight controlled = placed;
    controlled.light.diffuse = 0.5F; // multipliers are controls
    EXPECT_FALSE(mayHave({controlled}));
}

/// Of a dome with an image of 64 x 32 texels; there is `bright` where light space's z axis points,
/// else 1.
DomeLight LightOf(float bright, const glm::dmat4& worldFromLight) {
    LightImage image;
    image.width = 64;
    image.height = 32;
    for (std::uint32_t y = 0; y < image.height; ++y) {
        for (std::uint32_t x = 0; x < image.width; ++x) {
            const bool isBright = x >= 30 && x < 34 && y >= 14 && y < 18;
            image.rgb.insert(image.rgb.end(), 3, isBright ? bright : 1.0F);
        }
    }
    PlacedLight placed;
    placed.light.type = LightType::Dome;
    placed.light.textureFile.authoredPath = "sky.exr";
    placed.worldFromLight = worldFromLight;
    const LoadLightImage load = [&](const AssetReference&) {
        return LightTexture{std::make_shared<LightImage>(image), 0};
    };
    Warnings warnings;
    const LightTable table = BuildLightTable({placed}, {}, {load, {}, {}}, warnings);
    return LightOfCells(table.lights[0], table.cdf);
}

TEST(DomeGuide, CellsCountByWhatTheImageShows) {
    for (const double share : LightOf(1.0F, glm::dmat4(1.0)).sky) {
        EXPECT_NEAR(share, 1.0, 1e-4);
    }
    // A sun is left to samples by the image.
    const DomeLight light = LightOf(1e6F, glm::dmat4(1.0));
    const DomeCells& sunny = light.sky;
    std::size_t numBright = 0;
    for (std::uint32_t cell = 0; cell < kCells; ++cell) {
        const bool isNear = cell >= 7 * HDS_GUIDE_COLUMNS; // z > 3/4
        EXPECT_GE(sunny[cell], 0.0499) << cell;
        EXPECT_LE(sunny[cell], isNear ? 4.0 : 0.0501) << cell;
        EXPECT_EQ(light.sun[cell] > 1.0, sunny[cell] > 0.2) << cell;
        numBright += sunny[cell] > 0.2 ? 1 : 0;
    }
    EXPECT_GT(numBright, 8U);
    // z of light space is x of the world, in the middle of the longitudes.
    const glm::dmat4 turned(glm::dvec4(0, 1, 0, 0), glm::dvec4(0, 0, 1, 0), glm::dvec4(1, 0, 0, 0),
                            glm::dvec4(0, 0, 0, 1));
    const DomeCells cells = LightOf(20.0F, turned).sky;
    for (std::uint32_t cell = 0; cell < kCells; ++cell) {
        const std::uint32_t column = cell % HDS_GUIDE_COLUMNS;
        const std::uint32_t row = cell / HDS_GUIDE_COLUMNS;
        const bool isNear = (column == 7 || column == 8) && (row == 3 || row == 4);
        EXPECT_EQ(cells[cell] > 1.5, isNear) << cell;
    }
}

TEST(DomeGuide, PlacesInTheSunFollowTheImage) {
    const DomeLight light = LightOf(1e6F, glm::dmat4(1.0));
    const auto shareOf = [&](std::uint32_t cell) {
        std::vector<std::uint32_t> cells(std::size_t{HDS_GUIDE_PLACES} * kCells);
        cells[cell] = 300000;
        return BuildDomeGuide({}, cells, light, 0)[3 + HDS_GUIDE_PLACES];
    };
    EXPECT_FLOAT_EQ(shareOf(0), 0.8F);
    const auto bright = std::max_element(light.sun.begin(), light.sun.end());
    EXPECT_NEAR(shareOf(std::uint32_t(bright - light.sun.begin())), 0.2F, 1e-3F);
}

} // namespace
} // namespace hds
