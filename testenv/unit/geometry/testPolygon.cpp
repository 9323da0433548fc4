// SPDX-License-Identifier: Apache-2.0
// Faces are covered exactly once by their triangles: areas against the shoelace formula, and points
// against an even-odd test, for convex, concave, collinear and self-touching faces.
#include "testenv/unit/geometry/meshFixtures.h"

#include <gtest/gtest.h>

#include <glm/vec2.hpp>

#include <cmath>

namespace hds::test {
namespace {

using Polygon = std::vector<glm::vec2>;

double Shoelace(const Polygon& polygon) {
    double sum = 0.0;
    for (std::size_t i = 0; i < polygon.size(); ++i) {
        const glm::dvec2 a(polygon[i]);
        const glm::dvec2 b(polygon[(i + 1) % polygon.size()]);
        sum += a.x * b.y - a.y * b.x;
    }
    return 0.5 * sum;
}

bool IsInside(const Polygon& polygon, glm::dvec2 p) {
    bool isInside = false;
    for (std::size_t i = 0; i < polygon.size(); ++i) {
        const glm::dvec2 a(polygon[i]);
        const glm::dvec2 b(polygon[(i + 1) % polygon.size()]);
        if ((a.y > p.y) != (b.y > p.y) && p.x < a.x + (p.y - a.y) / (b.y - a.y) * (b.x - a.x)) {
            isInside = !isInside;
        }
    }
    return isInside;
}

int CountCovering(const TriangleMesh& mesh, glm::dvec2 p) {
    int count = 0;
    for (const glm::uvec3& t : mesh.triangles) {
        int numLeft = 0;
        for (int k = 0; k < 3; ++k) {
            const glm::dvec2 a(mesh.positions[t[k]]);
            const glm::dvec2 b(mesh.positions[t[(k + 1) % 3]]);
            numLeft += (b.x - a.x) * (p.y - a.y) - (b.y - a.y) * (p.x - a.x) > 0.0 ? 1 : 0;
        }
        count += numLeft == 3 ? 1 : 0;
    }
    return count;
}

/// Checks the face in its own plane and, for the area, in three other planes.
void CheckCovered(const Polygon& polygon, const std::string& label) {
    SCOPED_TRACE(label);
    std::vector<glm::vec3> points;
    for (const glm::vec2& p : polygon) {
        points.emplace_back(p.x, p.y, 0.0F);
    }
    const Triangulated flat = RunTriangulate(MakePolygon(points));
    EXPECT_TRUE(flat.warnings.empty());
    EXPECT_LE(flat.mesh->triangles.size(), polygon.size() - 2);
    const double area = Shoelace(polygon);
    ASSERT_NE(area, 0.0);
    const double side = area > 0.0 ? 1.0 : -1.0;
    double sum = 0.0;
    for (std::size_t t = 0; t < flat.mesh->triangles.size(); ++t) {
        const double signedArea = AreaVector(*flat.mesh, t).z;
        EXPECT_GT(signedArea * side, 0.0) << "triangle " << t << " is turned over";
        sum += signedArea;
    }
    // Both are sums of exact float products in double: rounding of about count * 2^-53.
    EXPECT_NEAR(sum, area, 1e-12 * polygon.size() * std::fabs(area));

    std::mt19937 random(7);
    glm::dvec2 low(polygon[0]);
    glm::dvec2 high(polygon[0]);
    for (const glm::vec2& p : polygon) {
        low = glm::dvec2(std::fmin(low.x, p.x), std::fmin(low.y, p.y));
        high = glm::dvec2(std::fmax(high.x, p.x), std::fmax(high.y, p.y));
    }
    if (side > 0.0) {
        for (int i = 0; i < 300; ++i) {
            // Random points do not lie on an edge.
            const glm::dvec2 s(double(random()) / 4294967296.0, double(random()) / 4294967296.0);
            const glm::dvec2 p = low + s * (high - low);
            ASSERT_EQ(CountCovering(*flat.mesh, p), IsInside(polygon, p) ? 1 : 0)
                << "at " << p.x << ", " << p.y;
        }
    }

    // A plane that is not parallel to an axis; its float points are flat to 2^-24 only.
    for (const glm::dvec3& u : {glm::dvec3(0.6, 0.0, 0.8), glm::dvec3(0.0, -0.8, 0.6)}) {
        const glm::dvec3 v = glm::normalize(glm::cross(glm::dvec3(0.36, 0.48, 0.8), u));
        std::vector<glm::vec3> tilted;
        for (const glm::vec2& p : polygon) {
            tilted.emplace_back(u * double(p.x) + v * double(p.y));
        }
        const double tiltedArea = std::fabs(area) * glm::length(glm::cross(u, v));
        EXPECT_NEAR(TotalArea(*RunTriangulate(MakePolygon(tilted)).mesh), tiltedArea,
                    1e-5 * tiltedArea);
    }
}

/// A simple polygon: random radii at rising angles.
Polygon MakeStar(int count, std::mt19937& random) {
    std::uniform_real_distribution<double> radius(0.1, 1.0);
    Polygon polygon;
    for (int i = 0; i < count; ++i) {
        const double angle = 2.0 * M_PI * i / count;
        const double r = radius(random);
        polygon.emplace_back(r * std::cos(angle), r * std::sin(angle));
    }
    return polygon;
}

Polygon Reversed(Polygon polygon) {
    return {polygon.rbegin(), polygon.rend()};
}

/// A band of constant width wound around itself: nearly every vertex of one side is reflex.
Polygon MakeSpiral(int numTurns, int perTurn) {
    Polygon polygon;
    const int count = numTurns * perTurn;
    for (int i = 0; i <= count; ++i) {
        const double angle = 2.0 * M_PI * i / perTurn;
        const double r = 1.0 + double(i) / perTurn;
        polygon.emplace_back(r * std::cos(angle), r * std::sin(angle));
    }
    for (int i = count; i >= 0; --i) {
        const double angle = 2.0 * M_PI * i / perTurn;
        const double r = 0.6 + double(i) / perTurn;
        polygon.emplace_back(r * std::cos(angle), r * std::sin(angle));
    }
    return Shoelace(polygon) > 0.0 ? polygon : Reversed(polygon);
}

TEST(Polygon, RandomStarsAreCovered) {
    std::mt19937 random(1);
    for (int count = 4; count < 40; ++count) {
        for (int repeat = 0; repeat < 5; ++repeat) {
            const Polygon star = MakeStar(count, random);
            CheckCovered(star, "star of " + std::to_string(count));
            CheckCovered(Reversed(star), "reversed star of " + std::to_string(count));
        }
    }
}

TEST(Polygon, ConvexFacesAreFans) {
    for (int count = 5; count < 12; ++count) {
        std::vector<glm::vec3> points;
        for (int i = 0; i < count; ++i) {
            points.emplace_back(std::cos(2.0 * M_PI * i / count), std::sin(2.0 * M_PI * i / count),
                                0.0F);
        }
        const auto mesh = RunTriangulate(MakePolygon(points)).mesh;
        ASSERT_EQ(mesh->triangles.size(), std::size_t(count - 2));
        for (std::uint32_t t = 0; t < mesh->triangles.size(); ++t) {
            EXPECT_EQ(mesh->triangles[t], glm::uvec3(0, t + 1, t + 2));
        }
    }
}

TEST(Polygon, QuadsSplitAtTheValidDiagonal) {
    const auto split = [](const std::vector<glm::vec3>& points) {
        return RunTriangulate(MakePolygon(points)).mesh->triangles;
    };
    using Triangles = std::vector<glm::uvec3>;
    const Triangles at02 = {{0, 1, 2}, {0, 2, 3}};
    const Triangles at13 = {{0, 1, 3}, {1, 2, 3}};
    EXPECT_EQ(split({{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}}), at02);
    EXPECT_EQ(split({{0, 0, 0}, {2, 0, 0}, {0.5F, 0.5F, 0}, {0, 2, 0}}), at02); // reflex at 2
    EXPECT_EQ(split({{0.5F, 0.5F, 0}, {0, 2, 0}, {0, 0, 0}, {2, 0, 0}}), at02); // reflex at 0
    EXPECT_EQ(split({{2, 0, 0}, {0.5F, 0.5F, 0}, {0, 2, 0}, {0, 0, 0}}), at13); // reflex at 1
    EXPECT_EQ(split({{0, 2, 0}, {0, 0, 0}, {2, 0, 0}, {0.5F, 0.5F, 0}}), at13); // reflex at 3
    EXPECT_EQ(split({{0, 0, 0}, {1, 0, 0}, {2, 0, 0}, {1, 2, 0}}), at13);       // straight at 1
    // A face whose last two points coincide, as at a cone's tip, keeps its one triangle.
    EXPECT_EQ(split({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 1, 0}}), Triangles({{0, 1, 2}}));
}

TEST(Polygon, StraightAndRepeatedVerticesKeepTheArea) {
    const Polygon straight = {{0, 0}, {1, 0}, {2, 0}, {4, 0}, {4, 1},
                              {4, 4}, {2, 4}, {0, 4}, {0, 2}};
    CheckCovered(straight, "square with points on its sides");
    const auto mesh = RunTriangulate(
        MakePolygon({{0, 0, 0}, {1, 0, 0}, {2, 0, 0}, {1, 1, 0}, {0, 2, 0}, {0, 1, 0}}));
    // Every point on a side is used: neighbours that share it see no gap.
    EXPECT_EQ(mesh.mesh->triangles.size(), 4U);
    CheckCovered({{0, 0}, {0, 0}, {3, 0}, {3, 3}, {3, 3}, {3, 3}, {1, 1}, {0, 3}}, "repeated");
}

TEST(Polygon, BridgedHolesAreCovered) {
    // A square with a square hole, reached by a bridge that is walked twice.
    CheckCovered({{0, 0}, {6, 0}, {6, 6}, {0, 6}, {0, 0}, {2, 2}, {2, 4}, {4, 4}, {4, 2}, {2, 2}},
                 "one hole");
    CheckCovered({{0, 0},
                  {12, 0},
                  {12, 6},
                  {9, 4},
                  {10, 4},
                  {10, 2},
                  {8, 2},
                  {8, 4},
                  {9, 4},
                  {12, 6},
                  {3, 6},
                  {3, 4},
                  {4, 4},
                  {4, 2},
                  {2, 2},
                  {2, 4},
                  {3, 4},
                  {3, 6},
                  {0, 6}},
                 "two holes");
}

TEST(Polygon, CombsAndSpiralsAreCovered) {
    Polygon comb = {{0.0F, -1.0F}, {40.0F, -1.0F}};
    for (int i = 40; i > 0; --i) {
        comb.emplace_back(float(i) - 0.5F, (i % 2) == 0 ? 5.0F : 0.25F);
    }
    CheckCovered(comb, "comb");
    CheckCovered(MakeSpiral(4, 30), "spiral");
    CheckCovered(Reversed(MakeSpiral(3, 17)), "reversed spiral");
}

TEST(Polygon, LargeConcaveFacesAreCovered) {
    std::mt19937 random(3);
    const Polygon star = MakeStar(20000, random);
    std::vector<glm::vec3> points;
    for (const glm::vec2& p : star) {
        points.emplace_back(p.x, p.y, 0.0F);
    }
    const auto mesh = RunTriangulate(MakePolygon(points)).mesh;
    EXPECT_EQ(mesh->triangles.size(), star.size() - 2);
    EXPECT_NEAR(TotalArea(*mesh), Shoelace(star), 1e-9);
}

TEST(Polygon, SelfCrossingFacesEndAndStayInside) {
    // Undefined in USD: no crash, no more than count - 2 triangles, only points of the face.
    std::mt19937 random(5);
    std::uniform_real_distribution<float> coordinate(-1.0F, 1.0F);
    for (int count = 4; count < 200; count += 7) {
        std::vector<glm::vec3> points;
        for (int i = 0; i < count; ++i) {
            points.emplace_back(coordinate(random), coordinate(random), coordinate(random));
        }
        const auto mesh = RunTriangulate(MakePolygon(points)).mesh;
        EXPECT_LE(mesh->triangles.size(), std::size_t(count - 2));
        EXPECT_GT(mesh->triangles.size(), 0U);
    }
}

} // namespace
} // namespace hds::test
