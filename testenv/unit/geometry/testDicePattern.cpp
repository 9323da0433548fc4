// SPDX-License-Identifier: Apache-2.0
// Patterns of diced faces as topology: every triangle counter-clockwise in the face's parameters,
// areas that sum to the face, edges shared by two triangles inside and used once at the border.
#include "hdStream/geometry/dicePattern.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <map>
#include <set>

namespace hds::test {
namespace {

constexpr double kPi = 3.14159265358979323846;

/// A convex polygon in the plane whose sub-quads are bilinear: where a face's parameters lie.
glm::dvec2 Place(FaceShape shape, int numEdges, const FacePoint& at) {
    if (shape != FaceShape::SubQuads) {
        return at.uv;
    }
    const auto corner = [&](int i) {
        const double angle = 2.0 * kPi * i / numEdges;
        return glm::dvec2(std::cos(angle), std::sin(angle));
    };
    const glm::dvec2 c = corner(at.subFace);
    const glm::dvec2 next = 0.5 * (c + corner(at.subFace + 1));
    const glm::dvec2 before = 0.5 * (c + corner(at.subFace - 1));
    const double u = at.uv.x;
    const double v = at.uv.y;
    return (1 - u) * (1 - v) * c + u * (1 - v) * next + (1 - u) * v * before;
}

double WholeArea(FaceShape shape, int numEdges) {
    return shape == FaceShape::Quad       ? 1.0
           : shape == FaceShape::Triangle ? 0.5
                                          : 0.5 * numEdges * std::sin(2.0 * kPi / numEdges);
}

void CheckPattern(FaceShape shape, const std::vector<std::uint8_t>& levels) {
    const auto numEdges = static_cast<int>(levels.size());
    const DicePattern pattern(shape, std::uint32_t(numEdges), levels.data());
    std::string label = "levels";
    for (const std::uint8_t level : levels) {
        label += " " + std::to_string(level);
    }
    SCOPED_TRACE(label);
    std::map<std::pair<std::uint32_t, std::uint32_t>, int> edges;
    double area = 0.0;
    std::set<std::uint32_t> used;
    for (std::uint32_t tile = 0; tile < pattern.NumTiles(); ++tile) {
        std::vector<glm::uvec3> triangles;
        pattern.AddTile(tile, triangles);
        const std::uint32_t bound = pattern.TileTriangles(tile);
        ASSERT_LE(triangles.size(), bound);
        ASSERT_LE(bound, 2 * DicePattern::kTileCells * DicePattern::kTileCells);
        ASSERT_TRUE(pattern.NumTiles() > 1 || triangles.size() == bound);
        const PatternBox box = pattern.TileBox(tile);
        for (const glm::uvec3& t : triangles) {
            std::array<glm::dvec2, 3> p;
            for (int k = 0; k < 3; ++k) {
                ASSERT_LT(t[k], pattern.NumVertices());
                const PatternVertex vertex = pattern.Locate(t[k]);
                p[k] = Place(shape, numEdges, vertex.at);
                used.insert(t[k]);
                ++edges[{t[k], t[(k + 1) % 3]}];
                if (shape == FaceShape::Quad) {
                    ASSERT_GE(vertex.at.uv.x, box.low.x);
                    ASSERT_LE(vertex.at.uv.x, box.high.x);
                    ASSERT_GE(vertex.at.uv.y, box.low.y);
                    ASSERT_LE(vertex.at.uv.y, box.high.y);
                }
            }
            const glm::dvec2 a = p[1] - p[0];
            const glm::dvec2 b = p[2] - p[0];
            const double twice = a.x * b.y - a.y * b.x;
            ASSERT_GT(twice, 1e-9) << t.x << " " << t.y << " " << t.z;
            area += 0.5 * twice;
        }
    }
    EXPECT_NEAR(area, WholeArea(shape, numEdges), 1e-9);
    EXPECT_EQ(used.size(), pattern.NumVertices());
    std::size_t numBorder = 0;
    for (const auto& [edge, count] : edges) {
        ASSERT_EQ(count, 1);
        numBorder += edges.count({edge.second, edge.first}) == 0 ? 1 : 0;
    }
    std::size_t expected = 0;
    for (const std::uint8_t level : levels) {
        expected += std::size_t(1) << level;
    }
    EXPECT_EQ(numBorder, expected);
}

/// Rates 1 to 64: every kind of strip, faces of one tile and of many.
constexpr std::uint8_t kLevels[] = {0, 1, 2, 3, 6};

TEST(DicePattern, QuadsOfAllLevels) {
    for (const std::uint8_t a : kLevels) {
        for (const std::uint8_t b : kLevels) {
            for (const std::uint8_t c : kLevels) {
                for (const std::uint8_t d : kLevels) {
                    CheckPattern(FaceShape::Quad, {a, b, c, d});
                }
            }
        }
    }
}

TEST(DicePattern, LoopTrianglesOfAllLevels) {
    for (std::uint8_t a = 0; a < 7; ++a) {
        for (std::uint8_t b = 0; b < 7; ++b) {
            for (std::uint8_t c = 0; c < 7; ++c) {
                CheckPattern(FaceShape::Triangle, {a, b, c});
            }
        }
    }
}

TEST(DicePattern, OtherPolygons) {
    for (const std::uint8_t a : kLevels) {
        for (const std::uint8_t b : kLevels) {
            for (const std::uint8_t c : kLevels) {
                CheckPattern(FaceShape::SubQuads, {a, b, c});
            }
            CheckPattern(FaceShape::SubQuads, {a, 0, b, 1, 2, 4});
        }
    }
    CheckPattern(FaceShape::SubQuads, {0, 0, 0, 0, 0});
    CheckPattern(FaceShape::SubQuads, {7, 8, 6, 7, 7});
    CheckPattern(FaceShape::Quad, {8, 0, 0, 3});
}

} // namespace
} // namespace hds::test
