// SPDX-License-Identifier: Apache-2.0
// Light tables: units, placement, selection by power, and what is left out.
#include "testenv/unit/shading/lightTableQueries.h"

#include <gtest/gtest.h>

#include <glm/gtc/matrix_transform.hpp>

#include <cmath>
#include <cstring>
#include <tuple>
#include <utility>
#include <vector>

namespace hds {
namespace {

using test::LightOfMesh;
using test::Make;
using test::Word;

constexpr double kPi = 3.14159265358979323846;

LightTable Build(const std::vector<PlacedLight>& lights, Warnings& warnings,
                 const LoadLightImage& images = {}) {
    return BuildLightTable(lights, {}, {images, {}, {}}, warnings);
}

/// The table's only light; expects no warning.
shared::HdsLight BuildOne(const PlacedLight& light) {
    Warnings warnings;
    const LightTable table = Build({light}, warnings);
    EXPECT_TRUE(warnings.Lines().empty());
    EXPECT_EQ(table.lights.size(), 1U);
    return table.lights.empty() ? shared::HdsLight{} : table.lights[0];
}

double Determinant(const float* r) {
    return r[0] * (double(r[5]) * r[10] - double(r[6]) * r[9]) -
           r[1] * (double(r[4]) * r[10] - double(r[6]) * r[8]) +
           r[2] * (double(r[4]) * r[9] - double(r[5]) * r[8]);
}

TEST(LightTableTest, ScaleMovesIntoTheSizes) {
    for (const double scale : {1e-6, 1.0, 1e6}) {
        for (const LightType type :
             {LightType::Sphere, LightType::Rect, LightType::Disk, LightType::Cylinder}) {
            PlacedLight light = Make(type);
            light.worldFromLight = glm::scale(
                glm::rotate(glm::translate(glm::dmat4(1.0), {1.0, 2.0, 3.0}), 0.5, {1.0, 1.0, 0.0}),
                glm::dvec3(scale));
            const shared::HdsLight out = BuildOne(light);
            EXPECT_NEAR(std::abs(Determinant(out.worldFromLight)), 1.0, 1e-6) << int(type);
            EXPECT_NEAR(std::abs(Determinant(out.lightFromWorld)), 1.0, 1e-6) << int(type);
            const double size = type == LightType::Rect ? 1.0 : 0.5;
            EXPECT_NEAR(out.params[0], size * scale, 1e-6 * scale) << int(type);
            EXPECT_FLOAT_EQ(out.center[1], 2.0F);
            EXPECT_GE(out.boundRadius, float(size * scale * 0.5));
        }
    }
}

TEST(LightTableTest, BoundsContainTheShape) {
    PlacedLight light = Make(LightType::Sphere);
    light.worldFromLight =
        glm::scale(glm::rotate(glm::dmat4(1.0), 0.7, {1.0, 0.2, 0.4}), {4.0, 0.1, 1.0});
    const shared::HdsLight out = BuildOne(light);
    EXPECT_GE(out.boundRadius, 2.0F);
    EXPECT_LE(out.boundRadius, 2.0F * 1.2F);
}

TEST(LightTableTest, FlatLightsIgnoreTheirThirdAxis) {
    PlacedLight light = Make(LightType::Rect);
    light.worldFromLight = glm::scale(glm::dmat4(1.0), {2.0, 3.0, 0.0});
    const shared::HdsLight flat = BuildOne(light);
    EXPECT_FLOAT_EQ(flat.params[0], 2.0F);
    EXPECT_FLOAT_EQ(flat.params[1], 3.0F);
    EXPECT_FLOAT_EQ(flat.worldFromLight[10], 1.0F);
    light.worldFromLight = glm::scale(glm::dmat4(1.0), {2.0, 3.0, -5.0});
    EXPECT_FLOAT_EQ(BuildOne(light).worldFromLight[10], -1.0F) << "a mirrored light emits to +z";
}

TEST(LightTableTest, NormalizeDividesByTheWorldArea) {
    PlacedLight light = Make(LightType::Rect);
    light.light.width = 2.0F;
    light.light.intensity = 6.0F;
    light.light.normalize = true;
    light.worldFromLight = glm::scale(glm::dmat4(1.0), glm::dvec3(3.0));
    EXPECT_FLOAT_EQ(BuildOne(light).radiance[0], 6.0F / 18.0F);

    PlacedLight sun = Make(LightType::Distant);
    sun.light.angle = 10.0F;
    sun.light.normalize = true;
    const double sine = std::sin(5.0 * kPi / 180.0);
    EXPECT_NEAR(BuildOne(sun).radiance[0], 1.0 / (kPi * sine * sine), 1e-3);

    PlacedLight dome = Make(LightType::Dome);
    dome.light.normalize = true; // has no size
    EXPECT_FLOAT_EQ(BuildOne(dome).radiance[0], 1.0F);
}

TEST(LightTableTest, DeltaLightsAreFlagged) {
    PlacedLight sun = Make(LightType::Distant);
    sun.light.angle = 0.0F;
    EXPECT_TRUE(BuildOne(sun).flags & HDS_LIGHT_POINT);
    PlacedLight point = Make(LightType::Sphere);
    point.light.treatAsPoint = true;
    const shared::HdsLight out = BuildOne(point);
    EXPECT_TRUE(out.flags & HDS_LIGHT_POINT);
    EXPECT_NEAR(out.radiance[0], kPi * 0.25, 1e-6); // radiance times projected area
    EXPECT_FALSE(BuildOne(Make(LightType::Sphere)).flags & HDS_LIGHT_POINT);
    PlacedLight hidden = Make(LightType::Sphere);
    hidden.light.visibleToCamera = false;
    EXPECT_FALSE(BuildOne(hidden).flags & HDS_LIGHT_VISIBLE);
}

TEST(LightTableTest, DistantLightsComeAgainstTheirDirection) {
    PlacedLight sun = Make(LightType::Distant);
    sun.worldFromLight = glm::rotate(glm::dmat4(1.0), -kPi / 2.0, {1.0, 0.0, 0.0});
    const shared::HdsLight out = BuildOne(sun); // emits along -y
    EXPECT_NEAR(out.worldFromLight[6], 1.0F, 1e-6F);
    EXPECT_NEAR(Determinant(out.worldFromLight), 1.0, 1e-6);
}

TEST(LightTableTest, StrengthIsPowerOrIrradiance) {
    PlacedLight rect = Make(LightType::Rect);
    rect.light.intensity = 3.0F; // power 3 pi, intensity if it were even: 3 / 4
    EXPECT_FLOAT_EQ(BuildOne(rect).strength, 0.75F);
    PlacedLight dome = Make(LightType::Dome);
    dome.light.intensity = 0.5F;
    EXPECT_FLOAT_EQ(BuildOne(dome).strength, float(0.5 * kPi));
    PlacedLight sun = Make(LightType::Distant);
    sun.light.normalize = true;
    EXPECT_FLOAT_EQ(BuildOne(sun).strength, 1.0F);
    PlacedLight point = Make(LightType::Sphere);
    point.light.treatAsPoint = true;
    EXPECT_FLOAT_EQ(BuildOne(point).strength, float(kPi * 0.25));
}

TEST(LightTableTest, LightsAtInfinityComeFirst) {
    EmissiveMesh mesh;
    mesh.radiance = glm::dvec3(1.0);
    mesh.triangles.push_back({{{0, 0, 0}, {2, 0, 0}, {0, 2, 0}}, 0});
    Warnings warnings;
    const LightTable table = BuildLightTable({Make(LightType::Rect), Make(LightType::Dome),
                                              Make(LightType::Sphere), Make(LightType::Distant)},
                                             {mesh}, {}, warnings);
    const std::uint32_t expected[] = {HDS_LIGHT_DOME, HDS_LIGHT_DISTANT, HDS_LIGHT_RECT,
                                      HDS_LIGHT_SPHERE, HDS_LIGHT_MESH};
    ASSERT_EQ(table.lights.size(), 5U);
    for (std::size_t i = 0; i < 5; ++i) {
        EXPECT_EQ(table.lights[i].type, expected[i]);
    }
    EXPECT_EQ(LightOfMesh(table, 0), 4U);
    EXPECT_EQ(table.triangles[0].light, 4U);
}

/// Walks the tree: every light inside all spheres above it, strengths, places.
class TreeWalk {
public:
    std::vector<int> seen; ///< visits of each light

    explicit TreeWalk(const LightTable& table) : seen(table.lights.size(), 0), _table(table) {}

    /// \return the strength below the node.
    double Visit(std::uint32_t index, std::uint32_t place, std::uint32_t depth) {
        const shared::HdsLightNode& node = _table.nodes[index];
        EXPECT_LE(depth, 30U);
        EXPECT_EQ(node.place, place);
        double sum = 0.0;
        for (std::uint32_t slot = 0; slot < 8; ++slot) {
            const std::uint32_t child = node.child[slot];
            const std::uint32_t own = 8 * index + slot;
            if (child == HDS_NONE) {
                EXPECT_EQ(node.strength[slot], 0.0F) << "an empty slot";
                EXPECT_EQ(node.metByRays >> slot & 1U, 0U);
                continue;
            }
            _above.emplace_back(&node, slot);
            const double strength = (child & HDS_LIGHT_LEAF) != 0
                                        ? VisitLight(child & ~HDS_LIGHT_LEAF, own)
                                        : Visit(child, own, depth + 1);
            _above.pop_back();
            EXPECT_NEAR(node.strength[slot], strength, 1e-5 * strength);
            sum += strength;
        }
        return sum;
    }

private:
    double VisitLight(std::uint32_t index, std::uint32_t place) {
        const shared::HdsLight& light = _table.lights[index];
        ++seen[index];
        EXPECT_EQ(light.treePlace, place);
        for (const auto& [node, slot] : _above) {
            const double distance = std::hypot(double(light.center[0]) - node->centerX[slot],
                                               double(light.center[1]) - node->centerY[slot],
                                               double(light.center[2]) - node->centerZ[slot]);
            EXPECT_LE(distance + light.boundRadius, node->radius[slot]);
            EXPECT_EQ(node->metByRays >> slot & 1U, 1U);
        }
        return light.strength;
    }
    const LightTable& _table;
    std::vector<std::pair<const shared::HdsLightNode*, std::uint32_t>> _above;
};

TEST(LightTableTest, TheTreeHoldsEachFiniteLightOnce) {
    std::vector<PlacedLight> lights{Make(LightType::Dome)};
    for (int i = 0; i < 200; ++i) {
        lights.push_back(Make(LightType::Sphere));
        lights.back().light.intensity = float(i + 1);
        // Some coincide.
        lights.back().worldFromLight = glm::translate(
            glm::dmat4(1.0), glm::dvec3(i % 13, (i / 13) % 5, 100.0 * std::sin(i / 3)));
    }
    Warnings warnings;
    const LightTable table = Build(lights, warnings);
    EXPECT_LT(table.nodes.size(), 100U) << "nodes have two children each";
    TreeWalk walk(table);
    walk.Visit(0, HDS_NONE, 0);
    EXPECT_EQ(walk.seen[0], 0) << "the dome is not in the tree";
    for (std::size_t i = 1; i < walk.seen.size(); ++i) {
        EXPECT_EQ(walk.seen[i], 1);
    }
    EXPECT_EQ(Build({Make(LightType::Sphere)}, warnings).nodes.size(), 1U);
    EXPECT_TRUE(Build({Make(LightType::Dome)}, warnings).nodes.empty());
}

/// Each light four times as far as the one before: bins set few of them apart at a time.
TEST(LightTableTest, TheTreeIsNoDeeperThanItsPaths) {
    std::vector<PlacedLight> lights;
    for (int i = -50; i < 50; ++i) {
        lights.push_back(Make(LightType::Sphere));
        lights.back().light.radius = 1e-3F;
        lights.back().worldFromLight =
            glm::translate(glm::dmat4(1.0), glm::dvec3(std::pow(4.0, i), 0.0, 0.0));
    }
    Warnings warnings;
    const LightTable table = Build(lights, warnings);
    TreeWalk walk(table);
    walk.Visit(0, HDS_NONE, 0);
    EXPECT_EQ(walk.seen, std::vector<int>(100, 1));
}

TEST(LightTableTest, NodesKnowWhereTheirLightsFace) {
    // Two rows far apart, which face each other.
    std::vector<PlacedLight> lights;
    for (int i = 0; i < 40; ++i) {
        lights.push_back(Make(LightType::Rect)); // emits towards -z
        const double side = i % 2 == 0 ? 1.0 : -1.0;
        lights.back().worldFromLight =
            glm::translate(glm::dmat4(1.0), {4.0 * i, 0.0, 500.0 * side}) *
            glm::scale(glm::dmat4(1.0), {1.0, 1.0, side});
    }
    Warnings warnings;
    const LightTable table = Build(lights, warnings);
    // The intensity of a flat light at its normal is 4 times that of its power in all directions.
    const float intensity = 4.0F * table.lights[0].strength;
    std::size_t numClusters = 0;
    for (const shared::HdsLightNode& node : table.nodes) {
        for (std::uint32_t slot = 0; slot < 8; ++slot) {
            if (node.child[slot] != HDS_NONE) {
                EXPECT_LT(node.strength[slot], 1e-6F) << "directions are not told apart";
                const double count = node.cosineStrength[slot] / intensity;
                EXPECT_NEAR(count, std::round(count), 1e-5);
                EXPECT_NEAR(std::abs(node.axisZ[slot]), 1.0F, 1e-6F);
                numClusters += count > 1.5 ? 1 : 0;
            }
        }
    }
    EXPECT_GE(numClusters, 6U);
    PlacedLight sphere = Make(LightType::Sphere);
    const LightTable even = Build({sphere, sphere}, warnings);
    EXPECT_EQ(even.nodes[0].cosineStrength[0], 0.0F);
    const LightTable up = Build({lights[0], lights[2]}, warnings);
    EXPECT_EQ(up.nodes[0].axisZ[0], 1.0F) << "who sees it looks towards +z";
}

/// Rows of lights that face each other, too close to be told apart: opposite directions are all
/// directions.
TEST(LightTableTest, DirectionsThatCancelOutAreAllDirections) {
    std::vector<PlacedLight> lights;
    for (int i = 0; i < 80; ++i) {
        lights.push_back(Make(LightType::Rect));
        lights.back().worldFromLight =
            glm::translate(glm::dmat4(1.0), {100.0 * (i / 2), 0.0, 0.0}) *
            glm::scale(glm::dmat4(1.0), {1.0, 1.0, i % 2 == 0 ? 1.0 : -1.0});
    }
    Warnings warnings;
    const LightTable table = Build(lights, warnings);
    const float each = table.lights[0].strength;
    std::size_t numClusters = 0;
    for (std::uint32_t slot = 0; slot < 8; ++slot) {
        const shared::HdsLightNode& root = table.nodes[0];
        if ((root.child[slot] & HDS_LIGHT_LEAF) == 0) {
            ++numClusters;
            EXPECT_NEAR(root.cosineStrength[slot], 0.0F, 1e-5F);
            const double count = root.strength[slot] / each;
            EXPECT_NEAR(count, std::round(count), 1e-4);
        }
    }
    EXPECT_GE(numClusters, 4U);
}

TEST(LightTableTest, WhatCannotBeRenderedIsLeftOutWithAWarning) {
    Warnings warnings;
    PlacedLight singular = Make(LightType::Sphere);
    singular.worldFromLight = glm::scale(glm::dmat4(1.0), {1.0, 0.0, 1.0});
    PlacedLight sizeless = Make(LightType::Disk);
    sizeless.name = "/sizeless";
    sizeless.light.radius = 0.0F;
    PlacedLight infinite = Make(LightType::Rect);
    infinite.name = "/infinite";
    infinite.light.exposure = 1e9F;
    PlacedLight nan = Make(LightType::Rect);
    nan.name = "/nan";
    nan.worldFromLight[3][0] = std::nan("");
    PlacedLight beyondFloats = Make(LightType::Rect);
    beyondFloats.name = "/beyondFloats";
    beyondFloats.light.color[0] = 3e38F;
    beyondFloats.light.intensity = 100.0F;
    PlacedLight negative = Make(LightType::Rect);
    negative.name = "/negative";
    negative.light.intensity = -1.0F;
    const LightTable table =
        Build({singular, sizeless, infinite, nan, beyondFloats, negative}, warnings);
    EXPECT_TRUE(table.lights.empty());
    EXPECT_EQ(warnings.Lines().size(), 6U);

    PlacedLight strong = Make(LightType::Rect);
    strong.light.intensity = 1e29F;
    strong.light.width = 1e9F;
    const LightTable strongTable = Build({strong, strong}, warnings);
    ASSERT_EQ(strongTable.lights.size(), 2U);
    EXPECT_TRUE(std::isfinite(strongTable.lights[0].strength + strongTable.lights[1].strength));

    PlacedLight black = Make(LightType::Rect);
    black.light.intensity = 0.0F;
    Warnings none;
    EXPECT_TRUE(Build({black}, none).lights.empty());
    PlacedLight saturated = Make(LightType::Rect);
    saturated.light.color = {1.0F, -0.1F, 0.2F};
    EXPECT_EQ(Build({saturated}, none).lights.size(), 1U);
    EXPECT_TRUE(none.Lines().empty()) << "neither black nor a colour beyond Rec. 709 is an error";
}

TEST(LightTableTest, IgnoredInputsWarn) {
    Warnings warnings;
    PlacedLight light = Make(LightType::Rect);
    light.light.textureFile.authoredPath = "missing.png";
    EXPECT_EQ(Build({light}, warnings).lights.size(), 1U);
    EXPECT_EQ(warnings.Lines().size(), 1U);
}

TEST(LightTableTest, PortalsAreRectsOfTheirDome) {
    PlacedLight dome = Make(LightType::Dome);
    Warnings warnings;
    const LightTable without = Build({dome}, warnings);
    EXPECT_FALSE(without.hasPortals);
    EXPECT_EQ(without.lights[0].treePlace, HDS_NONE);
    dome.portals.push_back({glm::scale(glm::dmat4(1.0), {0.0, 1.0, 1.0}), 1.0F, 1.0F});
    dome.portals.push_back({glm::scale(glm::dmat4(1.0), {2.0, 3.0, 1.0}), 0.5F, 1.0F});
    const LightTable table = Build({dome}, warnings);
    ASSERT_EQ(warnings.Lines().size(), 1U);
    EXPECT_NE(warnings.Lines()[0].find("portal"), std::string::npos);
    EXPECT_TRUE(table.hasPortals);
    const std::uint32_t base = table.lights[0].treePlace;
    EXPECT_EQ(Word(table, base), 1U);
    EXPECT_EQ(table.cdf.size(), base + HDS_DOME_PORTALS + sizeof(shared::HdsLight) / sizeof(float))
        << "sums for images alone";
    shared::HdsLight portal;
    std::memcpy(&portal, &table.cdf.at(base + HDS_DOME_PORTALS), sizeof(portal));
    EXPECT_FLOAT_EQ(portal.params[0], 1.0F);
    EXPECT_FLOAT_EQ(portal.params[1], 3.0F);
}

/// What says the same as nothing costs nothing: no record, no feature of the kernels.
TEST(LightTableTest, OnlyWhatShapesHasAShaping) {
    const auto isShaped = [](const PlacedLight& light) {
        Warnings warnings;
        const LightTable table = Build({light}, warnings);
        EXPECT_EQ(table.hasShaping, table.lights[0].shapingBase != HDS_NONE);
        EXPECT_FALSE(table.hasControls);
        return table.hasShaping;
    };
    for (const LightType type : {LightType::Sphere, LightType::Rect, LightType::Dome}) {
        PlacedLight light = Make(type);
        EXPECT_FALSE(isShaped(light));
        light.light.shaping.focusTint = {1.0F, 0.0F, 0.0F};
        EXPECT_FALSE(isShaped(light)) << "without focus";
        light.light.shaping.coneAngle = 90.0F; // the schema's fallback: all of a flat light
        EXPECT_EQ(isShaped(light), type == LightType::Sphere);
        light.light.shaping.coneSoftness = 0.5F;
        EXPECT_EQ(isShaped(light), type != LightType::Dome);
    }
}

TEST(LightTableTest, AConeWithoutANumberIsNone) {
    PlacedLight light = Make(LightType::Sphere);
    light.light.shaping.coneAngle = std::nanf("");
    Warnings warnings;
    const LightTable table = Build({light}, warnings);
    ASSERT_EQ(table.lights.size(), 1U);
    EXPECT_FALSE(table.hasShaping);
    ASSERT_EQ(warnings.Lines().size(), 1U);
    EXPECT_NE(warnings.Lines()[0].find("shaping:cone:angle"), std::string::npos);
}

TEST(LightTableTest, StrengthHoldsThePeakOfTheShaping) {
    const LoadIesProfile load = [](const AssetReference&) {
        return std::make_shared<const IesProfile>(
            IesProfile{{0.0F, 1.0F}, {0.0F, 6.2831855F}, {3.0F, 1.0F, 5.0F, 1.0F}});
    };
    PlacedLight light = Make(LightType::Sphere);
    const float plain = BuildOne(light).strength;
    light.light.shaping.iesFile.authoredPath = "lamp.ies";
    Warnings warnings;
    const LightTable table = BuildLightTable({light}, {}, {{}, load, {}}, warnings);
    EXPECT_FLOAT_EQ(table.lights[0].strength, 5.0F * plain);
}

TEST(LightTableTest, WhatIsNotPhysicalIsAControl) {
    const auto build = [](const PlacedLight& light) {
        Warnings warnings;
        LightTableInput input;
        input.links = {40, {std::vector<bool>(40, true)}};
        return BuildLightTable({light}, {}, input, warnings);
    };
    EXPECT_FALSE(build(Make(LightType::Sphere)).hasControls);
    PlacedLight dim = Make(LightType::Sphere);
    dim.light.diffuse = 0.5F;
    EXPECT_TRUE(build(dim).hasControls);
    EXPECT_EQ(build(dim).lights[0].flags & HDS_LIGHT_SAMPLED, 0U);
    PlacedLight linked = Make(LightType::Sphere);
    linked.lightLink = 0;
    EXPECT_TRUE(build(linked).hasControls);
    EXPECT_EQ(build(linked).lights[0].flags & HDS_LIGHT_SAMPLED, 0U);
    linked.shadowLink = 0;
    EXPECT_NE(build(linked).lights[0].flags & HDS_LIGHT_SAMPLED, 0U);
    PlacedLight shadowless = Make(LightType::Sphere);
    shadowless.light.shadow.enable = false;
    EXPECT_NE(build(shadowless).lights[0].flags & HDS_LIGHT_SAMPLED, 0U);
}

TEST(LightTableTest, ImagesOfRectsAndDomes) {
    const LoadLightImage images = [](const AssetReference&) {
        LightImage image{4, 2, std::vector<float>(24, 2.0F), 3};
        image.rgb[0] = 0.0F;
        return LightTexture{std::make_shared<LightImage>(image), 5};
    };
    Warnings warnings;
    PlacedLight rect = Make(LightType::Rect);
    rect.light.textureFile.authoredPath = "a.png";
    PlacedLight dome = Make(LightType::Dome);
    dome.light.textureFile.authoredPath = "b.exr";
    const LightTable table = Build({rect, dome}, warnings, images);
    for (int i = 0; i < 2; ++i) {
        const shared::HdsLight& light = table.lights[i];
        EXPECT_TRUE(light.flags & HDS_LIGHT_TEXTURED);
        const bool isDome = light.type == HDS_LIGHT_DOME;
        EXPECT_EQ(light.dataSize[0], 4U);
        EXPECT_EQ(light.dataSize[1], isDome ? 3U : 2U) << "cells";
        EXPECT_EQ(light.dataBase, 5U) << "its texture";
        EXPECT_EQ(light.params[3], 3.0F) << "the mip of the distribution";
    }
    EXPECT_EQ(table.numImages, 2U);
    EXPECT_EQ(table.cdf.size(), (3U + 2U * 5U) + (4U + 3U * 5U + 8U * 2U));
    const double luminance = 2.0 * (7.0 + 0.7152 + 0.0722) / 8.0; // of the image, without the red
    EXPECT_NEAR(table.lights[1].strength, 0.25 * luminance, 1e-5) << "power over 4 pi";
    EXPECT_TRUE(warnings.Lines().empty());

    Warnings missing;
    const LightTable untextured = Build({dome}, missing);
    EXPECT_FALSE(untextured.lights[0].flags & HDS_LIGHT_TEXTURED);
    EXPECT_EQ(missing.Lines().size(), 1U);
}

TEST(LightTableTest, LightsThatChangeHaveARecordForEachPartOfTheInterval) {
    PlacedLight disk = Make(LightType::Disk);
    disk.light.radius = 2.0F;
    disk.light.normalize = true;
    const glm::dmat4 flat(0.0); // it has no extent at the frame
    const glm::dmat4 turned = glm::rotate(glm::dmat4(1.0), 0.5, glm::dvec3(1.0, 0.0, 0.0));
    for (const auto& [radius, intensity, where] :
         {std::tuple(1.0F, 0.0F, glm::dmat4(1.0)), std::tuple(1.0F, 3.0F, glm::dmat4(1.0)),
          std::tuple(2.0F, 5.0F, glm::translate(turned, glm::dvec3(0.0, 0.0, 1.0))),
          std::tuple(2.0F, 5.0F, flat)}) {
        LightCell cell{disk.light, where};
        cell.light.radius = radius;
        cell.light.intensity = intensity;
        disk.cells.push_back(cell);
    }
    disk.light.intensity = 5.0F;
    disk.worldFromLight = flat;
    Warnings warnings;
    const LightTable table = Build({disk}, warnings);
    ASSERT_EQ(table.lights.size(), 1U);
    EXPECT_TRUE(table.hasMotion && table.hasControls);
    const shared::HdsLight& light = table.lights[0];
    shared::HdsLightControls controls;
    std::memcpy(&controls, &table.cdf[light.controlBase], sizeof(controls));
    ASSERT_EQ(controls.numCells, 4U);
    std::vector<shared::HdsLight> records(4);
    std::memcpy(records.data(), &table.cdf[controls.cellBase], 4 * sizeof(records[0]));
    const double pi = std::acos(-1.0);
    // A quarter of the intensity where that is normalized, whatever the size.
    const double strengths[] = {0.0, 0.75, 1.25, 0.0};
    const double radiances[] = {0.0, 3.0 / pi, 5.0 / (4.0 * pi), 0.0};
    for (std::size_t i = 0; i < 4; ++i) {
        EXPECT_NEAR(records[i].strength, strengths[i], 1e-6) << i;
        EXPECT_NEAR(records[i].radiance[0], radiances[i], 1e-6) << i;
        const auto at = [](const shared::HdsLight& one) {
            return glm::dvec3(one.center[0], one.center[1], one.center[2]);
        };
        EXPECT_LE(glm::distance(at(records[i]), at(light)) + records[i].boundRadius,
                  light.boundRadius * 1.00001)
            << i;
    }
    EXPECT_NEAR(records[2].params[0], 2.0F, 1e-6);
    EXPECT_NEAR(light.strength, 0.5, 1e-6) << "the mean";
    EXPECT_TRUE(warnings.Lines().empty());
}

TEST(LightTableTest, LightsAreDarkForAsLongAsTheirEmissionIsNoneOrUnusable) {
    for (const float intensity : {-2.0F, std::nanf("")}) {
        PlacedLight disk = Make(LightType::Disk);
        disk.cells.assign(2, LightCell{disk.light, disk.worldFromLight});
        disk.cells[0].light.intensity = intensity;
        Warnings warnings;
        const LightTable table = Build({disk}, warnings);
        ASSERT_EQ(table.lights.size(), 1U);
        shared::HdsLightControls controls;
        std::memcpy(&controls, &table.cdf[table.lights[0].controlBase], sizeof(controls));
        std::vector<shared::HdsLight> records(2);
        std::memcpy(records.data(), &table.cdf[controls.cellBase], 2 * sizeof(records[0]));
        EXPECT_EQ(records[0].strength, 0.0F);
        EXPECT_GT(records[1].strength, 0.0F);
        const bool isWarned = std::isnan(intensity);
        ASSERT_EQ(warnings.Lines().size(), isWarned ? 1U : 0U) << "below 0 is dark";
        if (isWarned) {
            EXPECT_NE(warnings.Lines()[0].find("dark then"), std::string::npos);
        }
    }
}

} // namespace
} // namespace hds
