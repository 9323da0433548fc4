// SPDX-License-Identifier: Apache-2.0
// Light tables: meshes that emit, and how they are cut.
#include "testenv/unit/shading/lightTableQueries.h"

#include <gtest/gtest.h>

#include <glm/geometric.hpp>

#include <cmath>
#include <cstdint>
#include <vector>

namespace hds {
namespace {

using test::LightOfMesh;
using test::Make;
using test::Word;

TEST(MeshLightTableTest, EmissiveMeshesBecomeLights) {
    EmissiveMesh mesh;
    mesh.name = "/mesh";
    mesh.radiance = glm::dvec3(2.0);
    mesh.triangles.push_back({{{0, 0, 0}, {2, 0, 0}, {0, 2, 0}}, 7});
    mesh.triangles.push_back({{{0, 0, 0}, {0, 0, 0}, {0, 2, 0}}, 8}); // no area
    mesh.triangles.push_back({{{0, 0, 0}, {4, 0, 0}, {0, 3, 0}}, 9});
    EmissiveMesh black = mesh;
    black.radiance = glm::dvec3(0.0);
    Warnings warnings;
    const LightTable table = BuildLightTable({Make(LightType::Rect)}, {black, mesh}, {}, warnings);
    EXPECT_EQ(table.tableByMesh[0], HDS_NONE);
    ASSERT_EQ(LightOfMesh(table, 1), 1U);
    const shared::HdsLight& light = table.lights[1];
    EXPECT_EQ(light.type, HDS_LIGHT_MESH);
    EXPECT_FLOAT_EQ(light.area, 8.0F);
    EXPECT_EQ(light.dataSize[0], 2U);
    ASSERT_EQ(table.triangles.size(), 2U);
    EXPECT_EQ(table.triangles[1].primId, 9U);
    EXPECT_FLOAT_EQ(table.cdf[light.cdfBase + 1], 0.25F);
    EXPECT_FLOAT_EQ(table.cdf[light.cdfBase + 2], 1.0F);
    EXPECT_GE(light.boundRadius, 2.5F);
}

/// Rows of squares of two triangles each, all facing +z. primIds run against the order of places.
EmissiveMesh MakeSquares(const std::vector<glm::dvec2>& corners) {
    EmissiveMesh mesh;
    mesh.name = "/squares";
    auto primId = std::uint32_t(2 * corners.size());
    for (const glm::dvec2& c : corners) {
        const glm::dvec3 p[4] = {
            {c.x, c.y, 0}, {c.x + 1, c.y, 0}, {c.x + 1, c.y + 1, 0}, {c.x, c.y + 1, 0}};
        mesh.triangles.push_back({{p[0], p[1], p[2]}, --primId});
        mesh.triangles.push_back({{p[0], p[2], p[3]}, --primId});
    }
    return mesh;
}

TEST(MeshLightTableTest, MeshesAreCutWherePartsAreApart) {
    EXPECT_EQ(ClusterTriangles(MakeSquares({{0, 0}})).clusters.size(), 1U);
    const EmissiveMesh apart = MakeSquares({{0, 0}, {100, 0}, {0, 100}, {100, 100}});
    const EmissiveClusters all = ClusterTriangles(apart);
    ASSERT_EQ(all.clusters.size(), 4U);
    for (const EmissiveCluster& cluster : all.clusters) {
        EXPECT_NEAR(cluster.area, 1.0, 1e-12);
        EXPECT_NEAR(glm::length(cluster.high - cluster.low), std::sqrt(2.0), 1e-12);
        EXPECT_EQ(cluster.axis, glm::dvec3(0, 0, 1));
        EXPECT_EQ(cluster.flatness, 1.0);
    }
}

/// Each primId leads to a triangle of that primId, in a light whose range holds it.
TEST(MeshLightTableTest, TrianglesOfMeshesFindTheirLights) {
    const EmissiveMesh mesh = MakeSquares({{0, 0}, {100, 0}, {0, 100}, {100, 100}});
    Warnings warnings;
    const LightTable table =
        BuildLightTable({Make(LightType::Rect), Make(LightType::Dome)}, {mesh}, {}, warnings);
    ASSERT_EQ(table.lights.size(), 6U);
    const std::size_t base = table.tableByMesh[0];
    EXPECT_EQ(Word(table, base + HDS_MESH_LIGHT), HDS_NONE);
    ASSERT_EQ(Word(table, base + HDS_MESH_LIGHT_COUNT), 8U);
    for (std::uint32_t i = 0; i < 8; ++i) {
        EXPECT_EQ(Word(table, base + HDS_MESH_LIGHT_TRIANGLES + i), i);
        const std::uint32_t index = Word(table, base + HDS_MESH_LIGHT_TRIANGLES + 8 + i);
        EXPECT_EQ(table.triangles[index].primId, i);
        const shared::HdsLight& light = table.lights[table.triangles[index].light];
        EXPECT_EQ(light.type, HDS_LIGHT_MESH);
        EXPECT_GE(index, light.dataBase);
        EXPECT_LT(index, light.dataBase + light.dataSize[0]);
    }
}

/// A glow is a share of the samples; what seems dark keeps a sixteenth of the mean.
TEST(MeshLightTableTest, GlowWeighsTriangles) {
    EmissiveMesh mesh = MakeSquares({{0, 0}});
    mesh.hasTexturedEmission = true;
    mesh.radiance = glm::dvec3(2.0);
    mesh.triangles[0].meanEmission = 3.0;
    mesh.triangles[1].meanEmission = 0.0;
    Warnings warnings;
    const LightTable table = BuildLightTable({}, {mesh}, {}, warnings);
    ASSERT_EQ(table.lights.size(), 1U);
    const shared::HdsLight& light = table.lights[0];
    EXPECT_EQ(light.flags, HDS_LIGHT_TEXTURED_EMISSION | HDS_LIGHT_WEIGHED);
    const double weights[2] = {0.5 * 3.0, 0.5 * 1.5 / 16.0};
    const bool isSwapped = table.triangles[0].primId == 0U; // primId 1 is the bright one
    EXPECT_FLOAT_EQ(table.cdf[light.cdfBase + 1],
                    float(weights[isSwapped ? 1 : 0] / (weights[0] + weights[1])));
    EXPECT_FLOAT_EQ(light.strength, float(2.0 * (weights[0] + weights[1]) / 4.0));
}

/// UsdLux inputs of a mesh light are factors; normalize divides by the area of the whole mesh.
TEST(MeshLightTableTest, MeshLightsHaveTheirInputs) {
    EmissiveMesh mesh = MakeSquares({{0, 0}});
    mesh.radiance = glm::dvec3(0.5, 1.0, 0.0);
    mesh.lux = Make(LightType::Mesh);
    mesh.lux->light.intensity = 3.0F;
    mesh.lux->light.exposure = 1.0F;
    mesh.lux->light.normalize = true;
    mesh.wholeArea = 4.0;
    EmissiveMesh dark = mesh;
    dark.lux->light.intensity = 0.0F;
    Warnings warnings;
    const LightTable table = BuildLightTable({}, {mesh, dark}, {}, warnings);
    ASSERT_EQ(table.lights.size(), 2U);
    EXPECT_FLOAT_EQ(table.lights[0].radiance[0], 0.75F);
    EXPECT_FLOAT_EQ(table.lights[0].radiance[1], 1.5F);
    EXPECT_EQ(table.lights[1].strength, 0.0F);
    EXPECT_EQ(table.lights[1].dataSize[0], 0U);
    EXPECT_EQ(LightOfMesh(table, 1), 1U);
}

} // namespace
} // namespace hds
