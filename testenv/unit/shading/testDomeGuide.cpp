// SPDX-License-Identifier: Apache-2.0
// The guide of domes: which domes may have one, and distributions of places that rays have left.
#include "hdStream/shading/domeGuide.h"

#include <gtest/gtest.h>

#include <cstring>

namespace hds {
namespace {

constexpr std::uint32_t kCells = HDS_GUIDE_ROWS * HDS_GUIDE_COLUMNS;

std::uint32_t BitsAt(const std::vector<float>& words, std::size_t i) {
    std::uint32_t bits = 0;
    std::memcpy(&bits, &words[i], sizeof(bits));
    return bits;
}

TEST(DomeGuide, EachPlaceThatIsKnownHasADistribution) {
    std::vector<std::uint32_t> cells(std::size_t{HDS_GUIDE_PLACES} * kCells);
    cells[7 * kCells + 40] = 300000; // one direction
    cells[9 * kCells + 3] = 20;      // too little
    constexpr std::uint32_t kBase = 1000;
    const std::vector<float> words = BuildDomeGuide({1.0F, 2.0F, 3.0F}, cells, kBase);
    ASSERT_EQ(words.size(), 3 + HDS_GUIDE_PLACES + kCells + 1);
    EXPECT_EQ(words[1], 2.0F);
    for (std::uint32_t place = 0; place < HDS_GUIDE_PLACES; ++place) {
        EXPECT_EQ(BitsAt(words, 3 + place), place == 7 ? kBase + 3 + HDS_GUIDE_PLACES : HDS_NONE);
    }
    const float* cdf = &words[3 + HDS_GUIDE_PLACES];
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
    EXPECT_TRUE(BuildDomeGuide({}, cells, 0).empty());
}

TEST(DomeGuide, IsOfPlainDomesAlone) {
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
    PlacedLight through = placed;
    through.portals.push_back({glm::dmat4(1.0), 1.0F, 1.0F});
    EXPECT_FALSE(mayHave({through}));
    PlacedLight controlled = placed;
    controlled.light.diffuse = 0.5F; // multipliers are controls
    EXPECT_FALSE(mayHave({controlled}));
}

} // namespace
} // namespace hds
