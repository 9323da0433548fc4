// SPDX-License-Identifier: Apache-2.0
// Displaced surfaces against closed forms: spheres that grow, planes that become height fields, and
// what happens where amounts differ.
#include "testenv/unit/geometry/subdivFixtures.h"

#include <glm/geometric.hpp>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>

namespace hds::test {
namespace {

Primvar MakePrimvar(const char* name, Interpolation interpolation, std::vector<float> values) {
    Primvar primvar;
    primvar.name = name;
    primvar.interpolation = interpolation;
    primvar.values = std::move(values);
    return primvar;
}

GeometryDescription MakeSheet(int n) {
    GeometryDescription sheet = MakeFlatGrid(n);
    sheet.subdivisionScheme = "catmullClark";
    return sheet;
}

/// Points are x, y in [0, 1]; the inner part of a sheet has its limit where the cage is linear.
bool IsInner(const glm::vec3& p) {
    return p.x > 0.2F && p.x < 0.8F && p.y > 0.2F && p.y < 0.8F;
}

TEST(Displacement, ConstantsMoveAlongTheLimitNormal) {
    for (const bool isLeftHanded : {false, true}) {
        GeometryDescription cube = MakeCube();
        cube.leftHanded = isLeftHanded;
        const Diced still = DiceUniform(cube, 3);
        const Diced moved = DiceUniform(cube, 3, {MakeConstantAmount(0.25)});
        ASSERT_EQ(still.chunk.triangles, moved.chunk.triangles);
        for (std::size_t i = 0; i < still.chunk.positions.size(); ++i) {
            const float* n = still.chunk.normals.values.data() + 3 * i;
            const glm::vec3 expected =
                still.chunk.positions[i] + 0.25F * glm::vec3(n[0], n[1], n[2]);
            EXPECT_LT(glm::length(moved.chunk.positions[i] - expected), 1e-6F);
        }
        // A parallel surface has the same normals.
        EXPECT_TRUE(std::equal(still.chunk.normals.values.begin(), still.chunk.normals.values.end(),
                               moved.chunk.normals.values.begin()));
    }
}

TEST(Displacement, PrimvarsMakeHeightFieldsWithTheirNormals) {
    constexpr int n = 16;
    GeometryDescription sheet = MakeSheet(n);
    std::vector<float> heights;
    for (std::size_t i = 0; i < sheet.points.size(); i += 3) {
        heights.push_back(0.25F * sheet.points[i] + 0.5F * sheet.points[i + 1]);
    }
    sheet.primvars = {MakePrimvar("bumps", Interpolation::Vertex, heights)};
    const Diced diced = DiceUniform(sheet, 2, {MakePrimvarAmount("bumps", 9.0)});
    const glm::dvec3 slope = glm::normalize(glm::dvec3(-0.25, -0.5, 1.0));
    int numInner = 0;
    for (std::size_t i = 0; i < diced.chunk.positions.size(); ++i) {
        const glm::vec3 p = diced.chunk.positions[i];
        if (IsInner(p)) {
            ++numInner;
            EXPECT_NEAR(p.z, 0.25F * p.x + 0.5F * p.y, 1e-6F);
            const float* normal = diced.chunk.normals.values.data() + 3 * i;
            EXPECT_LT(glm::length(glm::dvec3(normal[0], normal[1], normal[2]) - slope), 1e-5);
        }
    }
    EXPECT_GT(numInner, 1000);
}

TEST(Displacement, CurvedHeightFieldsHaveTheirNormals) {
    constexpr int n = 64;
    GeometryDescription sheet = MakeSheet(n);
    std::vector<float> heights;
    for (std::size_t i = 0; i < sheet.points.size(); i += 3) {
        heights.push_back(0.05F * std::sin(9.0F * sheet.points[i]));
    }
    sheet.primvars = {MakePrimvar("bumps", Interpolation::Vertex, heights)};
    const Diced diced = DiceUniform(sheet, 1, {MakePrimvarAmount("bumps", 0.0)});
    for (std::size_t i = 0; i < diced.chunk.positions.size(); ++i) {
        const glm::dvec3 p(diced.chunk.positions[i]);
        if (!IsInner(glm::vec3(p))) {
            continue;
        }
        // B-splines smooth the samples: by 1 - (9 / 64)^2 / 6 = 0.33 %.
        EXPECT_NEAR(p.z, 0.05 * std::sin(9.0 * p.x), 3e-4);
        const glm::dvec3 expected = glm::normalize(glm::dvec3(-0.45 * std::cos(9.0 * p.x), 0, 1));
        const float* normal = diced.chunk.normals.values.data() + 3 * i;
        EXPECT_LT(glm::length(glm::dvec3(normal[0], normal[1], normal[2]) - expected), 3e-3);
    }
}

TEST(Displacement, MissingPrimvarsLeaveTheFallback) {
    const Diced fallback = DiceUniform(MakeCube(), 1, {MakePrimvarAmount("none", 0.5)});
    const Diced constant = DiceUniform(MakeCube(), 1, {MakeConstantAmount(0.5)});
    EXPECT_EQ(fallback.chunk.positions, constant.chunk.positions);
}

TEST(Displacement, EntriesMeetInTheMiddle) {
    GeometryDescription sheet = MakeSheet(8);
    std::vector<std::int32_t> right;
    for (int face = 0; face < 64; ++face) {
        if (face % 8 >= 4) {
            right.push_back(face);
        }
    }
    sheet.subsets = {{"right", right}};
    const Diced diced = DiceUniform(sheet, 2, {MakeConstantAmount(0.5), MakeConstantAmount(-0.25)});
    for (const glm::vec3& p : diced.chunk.positions) {
        if (IsInner(p)) {
            const float expected = p.x < 0.4999F ? 0.5F : p.x > 0.5001F ? -0.25F : 0.125F;
            EXPECT_NEAR(p.z, expected, 1e-6F);
        }
    }
    // Subsets beyond the list are not displaced.
    const Diced half = DiceUniform(sheet, 2, {MakeConstantAmount(0.5)});
    for (const glm::vec3& p : half.chunk.positions) {
        if (IsInner(p)) {
            EXPECT_NEAR(p.z, p.x < 0.4999F ? 0.5F : p.x > 0.5001F ? 0.0F : 0.25F, 1e-6F);
        }
    }
}

TEST(Displacement, PointAmountsAreMeansOverFaces) {
    GeometryDescription grid = MakeFlatGrid(2);
    grid.primvars = {MakePrimvar("uniform", Interpolation::Uniform, {1, 2, 3, 4})};
    GeometryAttribute attribute;
    attribute.name = "uniform";
    attribute.interpolation = Interpolation::Uniform;
    attribute.values = grid.primvars[0].values;
    const std::vector<float> amounts = PointAmounts(grid, grid.points, {0.0, 4.0}, {}, {attribute},
                                                    {MakePrimvarAmount("uniform", 0.0)});
    EXPECT_EQ(amounts, (std::vector<float>{1, 1.5, 2, 2, 2.5, 3, 3, 3.5, 4}));
    const std::vector<float> entries =
        PointAmounts(grid, grid.points, {0.0, 4.0}, {0, 1, 0, 1}, {attribute},
                     {nullptr, MakeConstantAmount(4.0)});
    EXPECT_EQ(entries, (std::vector<float>{0, 2, 4, 0, 2, 4, 0, 2, 4}));
}

/// Any surface P(s, t) = s A + t B, whatever two directions on it the differences are along.
TEST(Displacement, TangentSpaceIsThatOfTheCoordinates) {
    std::mt19937 random(3);
    const auto uniform = [&] { return std::uniform_real_distribution<double>(-2.0, 2.0)(random); };
    const auto vector = [&] { return glm::dvec3(uniform(), uniform(), uniform()); };
    int numMirrored = 0;
    for (int round = 0; round < 2000; ++round) {
        const glm::dvec3 a = vector();
        const glm::dvec3 b = vector();
        const glm::dvec3 amount = vector();
        CoordinateFrame frame;
        frame.coordinatesU = {uniform(), uniform()};
        frame.coordinatesV = {uniform(), uniform()};
        frame.pointU = frame.coordinatesU.x * a + frame.coordinatesU.y * b;
        frame.pointV = frame.coordinatesV.x * a + frame.coordinatesV.y * b;
        const double determinant = frame.coordinatesU.x * frame.coordinatesV.y -
                                   frame.coordinatesU.y * frame.coordinatesV.x;
        // A smooth normal is not quite that of the surface, on either side of it.
        const glm::dvec3 flat = glm::normalize(glm::cross(a, b));
        frame.normal = glm::normalize((round % 2 == 0 ? 1.0 : -1.0) * flat + 0.1 * vector());
        const glm::dvec3 tangent = glm::normalize(a - glm::dot(a, frame.normal) * frame.normal);
        const glm::dvec3 left = b - glm::dot(b, frame.normal) * frame.normal;
        const glm::dvec3 across = left - glm::dot(left, tangent) * tangent;
        if (std::fabs(determinant) < 0.01 || glm::length(across) < 0.01) {
            continue; // where rounding decides
        }
        const glm::dvec3 bitangent = glm::normalize(across);
        numMirrored += glm::dot(glm::cross(tangent, bitangent), frame.normal) < 0.0 ? 1 : 0;
        const glm::dvec3 expected =
            amount.x * tangent + amount.y * bitangent + amount.z * frame.normal;
        const glm::dvec3 found = FromTangentSpace(frame, amount);
        ASSERT_LT(glm::length(found - expected), 1e-9) << round;
        ASSERT_NEAR(glm::length(found), glm::length(amount), 1e-9) << "bounds rely on it";
    }
    EXPECT_GT(numMirrored, 500);
}

TEST(Displacement, CoordinatesThatSpanNothingLeaveTheNormal) {
    CoordinateFrame frame;
    frame.normal = {0.0, 0.0, 1.0};
    frame.pointU = {1.0, 0.0, 0.0};
    frame.pointV = {0.0, 1.0, 0.0};
    const glm::dvec3 up(0.0, 0.0, 3.0);
    EXPECT_EQ(FromTangentSpace(frame, {1.0, 2.0, 3.0}), up);
    frame.coordinatesU = {1.0, 2.0};
    frame.coordinatesV = {2.0, 4.0};
    EXPECT_EQ(FromTangentSpace(frame, {1.0, 2.0, 3.0}), up);
    frame.coordinatesV = {2.0, std::numeric_limits<double>::infinity()};
    EXPECT_EQ(FromTangentSpace(frame, {1.0, 2.0, 3.0}), up);
}

} // namespace
} // namespace hds::test
