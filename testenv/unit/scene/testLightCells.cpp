// SPDX-License-Identifier: Apache-2.0
// Lights that change over the shutter: what they are between samples, and the parts they are cut
// into.
#include "hdStream/scene/lightCells.h"

#include <glm/geometric.hpp>
#include <glm/gtc/matrix_transform.hpp>
#include <gtest/gtest.h>

#include <cmath>

namespace hds {
namespace {

const Shutter kShutter{-0.5, 0.5};

LightPrim Ball(const std::vector<std::pair<double, float>>& radii) {
    LightPrim prim;
    prim.light.type = LightType::Sphere;
    for (const auto& [time, radius] : radii) {
        LightSample sample = SampleOf(prim.light);
        sample.time = time;
        sample.radius = radius;
        prim.samples.push_back(sample);
    }
    return prim;
}

std::vector<LightCell> CellsOf(const LightPrim& prim) {
    return MakeLightCells(prim, kShutter, MovingTransform(glm::dmat4(1.0)), {}, true);
}

TEST(LightCells, LightsAreLinearBetweenSamplesAndConstantBeyond) {
    LightPrim prim = Ball({{-1.0, 1.0F}, {0.0, 3.0F}, {1.0, 2.0F}});
    prim.samples[0].color = {0.0F, 1.0F, 2.0F};
    prim.light.width = 7.0F;
    prim.samples[1].width = prim.samples[2].width = 7.0F;
    const auto at = [&](double time) { return LightAt(prim.light, prim.samples, time); };
    EXPECT_EQ(at(-2.0).radius, 1.0F);
    EXPECT_EQ(at(-0.5).radius, 2.0F);
    EXPECT_EQ(at(0.0).radius, 3.0F);
    EXPECT_EQ(at(0.75).radius, 2.25F);
    EXPECT_EQ(at(5.0).radius, 2.0F);
    EXPECT_EQ(at(-0.5).color, (std::array<float, 3>{0.5F, 1.0F, 1.5F}));
    EXPECT_EQ(at(0.5).width, 7.0F);
    EXPECT_EQ(at(-0.5).type, LightType::Sphere);
}

TEST(LightCells, WhatDoesNotChangeHasNone) {
    EXPECT_TRUE(CellsOf(Ball({})).empty());
    EXPECT_TRUE(CellsOf(Ball({{-0.5, 0.5F}, {0.5, 0.5F}})).empty());
    EXPECT_TRUE(MakeLightCells(Ball({{-0.5, 0.1F}, {0.5, 0.5F}}), Shutter(),
                               MovingTransform(glm::dmat4(1.0)), {}, true)
                    .empty());
    EXPECT_EQ(CellsOf(Ball({{-0.5, 0.7F}, {0.5, 0.7F}})).size(), 1U) << "not as for the frame";
    LightPrim dome = Ball({{-0.5, 0.7F}, {0.5, 1.7F}});
    dome.light.type = LightType::Dome;
    EXPECT_TRUE(CellsOf(dome).empty()) << "domes have no radius";
}

TEST(LightCells, TheyHaveTheLightOfTheirMiddleAndAreAsManyAsItChangesFast) {
    const std::vector<LightCell> fast = CellsOf(Ball({{-0.5, 1.0F}, {0.5, 3.0F}}));
    ASSERT_EQ(fast.size(), 128U);
    double mean = 0.0;
    for (std::size_t i = 0; i < fast.size(); ++i) {
        EXPECT_NEAR(fast[i].light.radius, 1.0 + 2.0 * (double(i) + 0.5) / 128.0, 1e-6);
        mean += double(fast[i].light.radius) / 128.0;
    }
    EXPECT_NEAR(mean, 2.0, 1e-6); // of what is linear the mean is exact
    EXPECT_EQ(CellsOf(Ball({{-0.5, 1.0F}, {0.5, 1.02F}})).size(), 4U);
    // What has no size for a while still has one.
    EXPECT_GT(CellsOf(Ball({{-0.5, -2.0F}, {0.5, 1.0F}})).front().light.radius, 0.0F);
}

TEST(LightCells, KeysAndCellsTogetherAreTheAuthoredMotion) {
    const auto pose = [](double degrees, double scale, double x) {
        const glm::dmat4 moved = glm::translate(glm::dmat4(1.0), glm::dvec3(x, 2.0, -1.0));
        const glm::dmat4 turned =
            glm::rotate(moved, glm::radians(degrees), glm::dvec3(1.0, 2.0, 2.0) / 3.0);
        return glm::scale(turned, glm::dvec3(scale, 1.0, 0.5 * scale));
    };
    const glm::dmat4 frame = pose(20.0, 2.0, 4.0);
    const MovingTransform way(frame, {{-0.5, pose(-60.0, 1.0, 1.0)}, {0.5, pose(100.0, 3.0, 7.0)}},
                              kShutter);
    bool isRigid = true;
    const std::vector<LightKey> keys = MakeLightKeys(way, &isRigid);
    ASSERT_FALSE(isRigid);
    ASSERT_FALSE(keys.empty());
    const std::vector<LightCell> cells = MakeLightCells(Ball({}), kShutter, way, keys, isRigid);
    ASSERT_FALSE(cells.empty());
    for (std::size_t i = 0; i < cells.size(); ++i) {
        const double time = (double(i) + 0.5) / double(cells.size());
        const double scaled = time * double(keys.size() - 1);
        const auto segment = std::size_t(scaled);
        const glm::dvec4 q = glm::normalize(
            glm::mix(keys[segment].turn, keys[segment + 1].turn, scaled - double(segment)));
        const glm::dvec3 offset =
            glm::mix(keys[segment].offset, keys[segment + 1].offset, scaled - double(segment));
        const glm::dvec3 pivot(frame[3]);
        for (const glm::dvec3 corner : {glm::dvec3(0.0), glm::dvec3(1.0, -2.0, 0.5)}) {
            // As the kernel turns: v + 2 (w (q x v) + q x (q x v)).
            const glm::dvec3 v =
                glm::dvec3(cells[i].worldFromLight * glm::dvec4(corner, 1.0)) - pivot;
            const glm::dvec3 twice = 2.0 * glm::cross(glm::dvec3(q), v);
            const glm::dvec3 moved =
                pivot + offset + v + q.w * twice + glm::cross(glm::dvec3(q), twice);
            const glm::dvec3 authored = glm::dvec3(way.At(time) * glm::dvec4(corner, 1.0));
            EXPECT_NEAR(glm::distance(moved, authored), 0.0, 1e-9);
        }
    }
}

TEST(LightCells, FlatLightsThatMoveHaveAllOfTheirMotion) {
    const glm::dmat4 flat = glm::scale(glm::dmat4(1.0), glm::dvec3(1.0, 1.0, 0.0));
    const glm::dmat4 moved = glm::translate(glm::dmat4(1.0), glm::dvec3(2.0, 0.0, 0.0)) * flat;
    const MovingTransform way(flat, {{-0.5, flat}, {0.5, moved}}, kShutter);
    bool isRigid = true;
    const std::vector<LightKey> keys = MakeLightKeys(way, &isRigid);
    const std::vector<LightCell> cells = MakeLightCells(Ball({}), kShutter, way, keys, isRigid);
    ASSERT_EQ(cells.size(), 128U);
    EXPECT_NEAR(cells.back().worldFromLight[3].x, 2.0, 2.0 / 128.0);
}

/// A radius that grows threefold, in at most so many parts.
TEST(LightCells, ThereAreAsManyAsThereMayBe) {
    const LightPrim prim = Ball({{-0.5, 1.0F}, {0.5, 3.0F}});
    for (const std::size_t most : {1U, 4U, 64U}) {
        const std::vector<LightCell> cells =
            MakeLightCells(prim, kShutter, MovingTransform(glm::dmat4(1.0)), {}, true, most);
        ASSERT_EQ(cells.size(), most);
        EXPECT_NEAR(cells[0].light.radius, 1.0 + 1.0 / double(most), 1e-6);
    }
}

TEST(LightCells, LightsAtInfinityChangeWithDirectionsAlone) {
    const auto stretched = [](double height) {
        return glm::scale(glm::dmat4(1.0), glm::dvec3(1.0, height, 2.0 * height));
    };
    const MovingTransform way(stretched(1.0), {{-0.5, stretched(0.5)}, {0.5, stretched(2.0)}},
                              kShutter);
    LightPrim sun;
    sun.light.type = LightType::Distant;
    EXPECT_TRUE(MakeLightCells(sun, kShutter, way, {}, false).empty());
    sun.light.shaping.focus = 2.0F; // along axes that are stretched
    EXPECT_FALSE(MakeLightCells(sun, kShutter, way, {}, false).empty());
    LightPrim sky;
    sky.light.type = LightType::Dome;
    EXPECT_TRUE(MakeLightCells(sky, kShutter, way, {}, false).empty());
    sky.light.textureFile.authoredPath = "sky.exr"; // which is stretched
    EXPECT_FALSE(MakeLightCells(sky, kShutter, way, {}, false).empty());
    const LightPrim ball = Ball({});
    EXPECT_FALSE(MakeLightCells(ball, kShutter, way, {}, false).empty());
    // A slanted one is turned by a stretch.
    const auto slanted = [&](double height) {
        return stretched(height) * glm::rotate(glm::dmat4(1.0), 0.5, glm::dvec3(1.0, 0.0, 0.0)) *
               glm::scale(glm::dmat4(1.0), glm::dvec3(1.0, 1.0, 0.5));
    };
    const glm::dmat4 tall = glm::scale(glm::dmat4(1.0), glm::dvec3(1.0, 3.0, 1.0));
    const MovingTransform turns(slanted(1.0), {{-0.5, slanted(1.0)}, {0.5, tall * slanted(1.0)}},
                                kShutter);
    sun.light.shaping.focus = 0.0F;
    EXPECT_FALSE(MakeLightCells(sun, kShutter, turns, {}, false).empty());
}

TEST(LightCells, MostIsTheLargestAndTheBrightest) {
    LightPrim prim = Ball({{-0.5, 3.0F}, {0.5, 1.0F}});
    prim.samples[0].intensity = 0.0F;
    prim.samples[1].intensity = 5.0F;
    const LightDescription most = MostOf(prim.light, CellsOf(prim));
    EXPECT_NEAR(most.radius, 3.0F, 0.02F);
    EXPECT_NEAR(most.intensity, 5.0F, 0.04F);
}

} // namespace
} // namespace hds
