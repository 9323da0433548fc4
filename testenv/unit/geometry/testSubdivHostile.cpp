// SPDX-License-Identifier: Apache-2.0
// Subdivided content that cannot be drawn, or only in part: warnings as for polygons, never a
// crash.
#include "testenv/unit/geometry/subdivFixtures.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

namespace hds::test {
namespace {

TEST(SubdivHostile, WhatIsRefusedSaysSoOnce) {
    GeometryDescription quads = MakeCube();
    quads.subdivisionScheme = "loop";
    const Diced loop = DiceUniform(quads, 2);
    EXPECT_FALSE(loop.source);
    EXPECT_EQ(loop.warnings,
              std::vector<std::string>{"/World/mesh: not subdivided: loop needs triangles only"});
    GeometryDescription empty;
    empty.subdivisionScheme = "catmullClark";
    EXPECT_FALSE(DiceUniform(empty, 2).source);
    EXPECT_TRUE(DiceUniform(empty, 2).warnings.empty());
}

TEST(SubdivHostile, BadTagsAreIgnored) {
    GeometryDescription mesh = MakeCube();
    mesh.subdivTags.Edit().creaseLengths = std::vector<std::int32_t>{3};
    mesh.subdivTags.Edit().cornerIndices = std::vector<std::int32_t>{8};
    mesh.subdivTags.Edit().cornerSharpnesses = std::vector<float>{1.0F};
    const Diced diced = DiceUniform(mesh, 1);
    EXPECT_EQ(diced.warnings,
              (std::vector<std::string>{
                  "/World/mesh: corners ignored: indices and sharpnesses disagree",
                  "/World/mesh: creases ignored: lengths, indices and sharpnesses disagree"}));
    EXPECT_EQ(diced.chunk.triangles.size(), 48U);
}

TEST(SubdivHostile, UnknownRulesAreNamedAndReadAsTheFallback) {
    GeometryDescription mesh = MakeCube();
    mesh.subdivTags.Edit().interpolateBoundary = "edges";
    mesh.subdivTags.Edit().faceVaryingLinearInterpolation = "corners";
    mesh.subdivTags.Edit().triangleSubdivisionRule = "loop";
    const Diced diced = DiceUniform(mesh, 1);
    EXPECT_EQ(
        diced.warnings,
        (std::vector<std::string>{
            "/World/mesh: unknown faceVaryingLinearInterpolation \"corners\", cornersPlus1 is used",
            "/World/mesh: unknown interpolateBoundary \"edges\", edgeAndCorner is used",
            "/World/mesh: unknown triangleSubdivisionRule \"loop\", catmullClark is used"}));
    EXPECT_EQ(diced.chunk.triangles.size(), 48U);
}

TEST(SubdivHostile, BadFacesAreDropped) {
    GeometryDescription mesh = MakeCube();
    std::vector<float> points(mesh.points.begin(), mesh.points.end());
    points[3 * 7] = std::numeric_limits<float>::quiet_NaN(); // of three faces
    mesh.points = points;
    const Diced diced = DiceUniform(mesh, 1);
    ASSERT_TRUE(diced.source);
    EXPECT_EQ(diced.warnings, std::vector<std::string>{"/World/mesh: 3 faces dropped: point not "
                                                       "finite or beyond 1e18"});
    EXPECT_EQ(diced.chunk.triangles.size(), 24U);
}

TEST(SubdivHostile, HolesEverywhereDrawNothing) {
    GeometryDescription mesh = MakeCube();
    mesh.holeIndices = std::vector<std::int32_t>{0, 1, 2, 3, 4, 5};
    const Diced diced = DiceUniform(mesh, 2);
    ASSERT_TRUE(diced.source);
    EXPECT_EQ(diced.source->NumPrimitiveGroups(), 0U);
    EXPECT_GT(diced.source->AllBounds().min.x, diced.source->AllBounds().max.x);
    EXPECT_TRUE(diced.chunk.triangles.empty());
}

TEST(SubdivHostile, SingleAndDegenerateFaces) {
    GeometryDescription triangle = MakeMesh({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}, {3}, {0, 1, 2});
    triangle.subdivisionScheme = "catmullClark";
    EXPECT_EQ(DiceUniform(triangle, 0).chunk.triangles.size(), 1U);
    EXPECT_EQ(DiceUniform(triangle, 1).chunk.triangles.size(), 6U);
    triangle.subdivisionScheme = "loop";
    EXPECT_EQ(DiceUniform(triangle, 1).chunk.triangles.size(), 4U);
    // Repeated points: triangles without an area are left out, normals are unit.
    GeometryDescription tip =
        MakeMesh({{0, 0, 1}, {0, 0, 1}, {1, 1, 0}, {-1, 1, 0}}, {4}, {0, 1, 2, 3});
    tip.subdivisionScheme = "bilinear";
    const Diced diced = DiceUniform(tip, 2);
    EXPECT_LT(diced.chunk.triangles.size(), diced.source->NumTriangles());
    tip.subdivisionScheme = "catmullClark";
    const Diced smooth = DiceUniform(tip, 2);
    for (std::size_t i = 0; i < smooth.chunk.normals.values.size(); i += 3) {
        const float* n = smooth.chunk.normals.values.data() + i;
        EXPECT_NEAR(glm::length(glm::dvec3(n[0], n[1], n[2])), 1.0, 1e-6);
    }
    GeometryDescription line = MakeMesh({{0, 0, 0}, {1, 0, 0}, {2, 0, 0}}, {3}, {0, 1, 2});
    line.subdivisionScheme = "catmullClark";
    EXPECT_TRUE(DiceUniform(line, 2).chunk.triangles.empty());
}

TEST(SubdivHostile, CrowdedPointsAndFaces) {
    // A disc and a cone of n sides; with too many, the cage is drawn.
    const auto makeCone = [](int n, bool hasTip) {
        std::vector<glm::vec3> points;
        std::vector<std::int32_t> counts;
        std::vector<std::int32_t> indices;
        for (int i = 0; i < n; ++i) {
            const double angle = 6.283185307179586 * i / n;
            points.emplace_back(std::cos(angle), std::sin(angle), 0.0);
            if (hasTip) {
                counts.push_back(3);
                indices.insert(indices.end(), {i, (i + 1) % n, n});
            } else {
                indices.push_back(i);
            }
        }
        if (hasTip) {
            points.emplace_back(0.0F, 0.0F, 1.0F);
        } else {
            counts.push_back(n);
        }
        GeometryDescription mesh = MakeMesh(points, counts, indices);
        mesh.subdivisionScheme = "catmullClark";
        return mesh;
    };
    for (const bool hasTip : {false, true}) {
        const Diced diced = DiceUniform(makeCone(80, hasTip), 2);
        ASSERT_TRUE(diced.source);
        EXPECT_EQ(diced.chunk.triangles.size(), 80U * 8 * (hasTip ? 3 : 1));
        for (const glm::vec3& p : diced.chunk.positions) {
            EXPECT_LT(glm::length(p), 1.01F);
        }
        const Diced refused = DiceUniform(makeCone(513, hasTip), 2);
        EXPECT_FALSE(refused.source);
        EXPECT_EQ(refused.warnings,
                  std::vector<std::string>{"/World/mesh: not subdivided: a " +
                                           std::string(hasTip ? "point" : "face") +
                                           " has more than 512 edges"});
    }
}

TEST(SubdivHostile, NonManifoldCagesStayWhole) {
    // Three sheets on one edge, and two cubes that share a point.
    GeometryDescription fan = MakeMesh({{0, 0, 0},
                                        {0, 0, 1},
                                        {1, 0, 0},
                                        {1, 0, 1},
                                        {-1, 1, 0},
                                        {-1, 1, 1},
                                        {-1, -1, 0},
                                        {-1, -1, 1}},
                                       {4, 4, 4}, {0, 2, 3, 1, 0, 4, 5, 1, 0, 6, 7, 1});
    fan.subdivisionScheme = "catmullClark";
    const Diced diced = DiceUniform(fan, 2);
    ASSERT_TRUE(diced.source);
    EXPECT_EQ(diced.chunk.triangles.size(), 96U);
    EXPECT_EQ(diced.chunk.normals.interpolation, Interpolation::FaceVarying);
}

TEST(SubdivHostile, GarbageNeverBreaksTheInvariants) {
    std::mt19937 random(37);
    int numDrawn = 0;
    for (int round = 0; round < 3000; ++round) {
        GeometryDescription mesh;
        std::vector<float> points(random() % 40);
        for (float& p : points) {
            p = random() % 40 == 0 ? std::numeric_limits<float>::quiet_NaN() : float(random() % 7);
        }
        std::vector<std::int32_t> counts(random() % 9);
        for (std::int32_t& count : counts) {
            count = std::int32_t(random() % 7) - 1;
        }
        std::vector<std::int32_t> indices(random() % 40);
        for (std::int32_t& index : indices) {
            index = std::int32_t(random() % 14) - (random() % 40 == 0 ? 5 : 0);
        }
        const char* const schemes[] = {"bilinear", "catmullClark", "loop"};
        mesh.subdivisionScheme = schemes[random() % 3];
        mesh.points = points;
        mesh.faceVertexCounts = counts;
        mesh.faceVertexIndices = indices;
        mesh.holeIndices = std::vector<std::int32_t>(random() % 3, std::int32_t(random() % 6) - 1);
        mesh.subdivTags.Edit().creaseLengths = std::vector<std::int32_t>(1, 3);
        mesh.subdivTags.Edit().creaseIndices = std::vector<std::int32_t>{0, 1, 5};
        mesh.subdivTags.Edit().creaseSharpnesses =
            std::vector<float>{random() % 2 == 0 ? 10.0F : 1.5F};
        const char* const boundaries[] = {"none", "edgeOnly", "edgeAndCorner"};
        mesh.subdivTags.Edit().interpolateBoundary = boundaries[random() % 3];
        Primvar primvar;
        primvar.name = "st";
        primvar.interpolation = static_cast<Interpolation>(random() % 5);
        primvar.numComponents = 2;
        std::vector<float> values(2 * (random() % 2 == 0 ? points.size() / 3 : indices.size()));
        for (float& value : values) {
            value = random() % 20 == 0 ? std::numeric_limits<float>::infinity() : 0.5F;
        }
        primvar.values = values;
        mesh.primvars = {primvar};
        DicingOptions options;
        options.isAdaptive = random() % 2 == 0;
        options.level = random() % 4;
        options.view.imageSize = glm::dvec2(random() % 2 == 0 ? 0.0 : 200.0);
        Displacement displacement;
        if (random() % 2 == 0) {
            displacement = {MakePrimvarAmount("st", double(std::nanf("")))};
        }
        const Diced diced = DiceAll(mesh, options, displacement);
        numDrawn += diced.chunk.triangles.empty() ? 0 : 1;
        for (std::size_t t = 0; t < diced.chunk.triangles.size(); ++t) {
            ASSERT_LT(diced.chunk.faces[t], counts.size());
            for (int k = 0; k < 3; ++k) {
                const glm::vec3 p = diced.chunk.positions[diced.chunk.triangles[t][k]];
                ASSERT_TRUE(std::isfinite(p.x) && std::isfinite(p.y) && std::isfinite(p.z));
            }
        }
    }
    EXPECT_GT(numDrawn, 150);
}

} // namespace
} // namespace hds::test
