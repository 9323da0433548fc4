// SPDX-License-Identifier: Apache-2.0
// Diced surfaces against the limit masks of uniform refinement: every vertex, normal and
// face-varying value of a uniform level, for all tags, schemes and kinds of faces.
#include "hdStream/geometry/implicitMesh.h"
#include "hdStream/geometry/limitCage.h"
#include "testenv/unit/geometry/subdivFixtures.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <set>

namespace hds::test {
namespace {

/// Finds points by position: cells of a grid much larger than rounding, smaller than edges.
class PointFinder {
public:
    explicit PointFinder(const std::vector<glm::dvec3>& points) : _points(points) {
        for (std::size_t i = 0; i < points.size(); ++i) {
            _cells[Cell(points[i], 0, 0, 0)].push_back(i);
        }
    }

    /// All points within `distance`, which is at most a cell.
    std::vector<std::size_t> Near(const glm::dvec3& point, double distance) const {
        std::vector<std::size_t> found;
        for (int dz = -1; dz <= 1; ++dz) {
            for (int dy = -1; dy <= 1; ++dy) {
                for (int dx = -1; dx <= 1; ++dx) {
                    const auto cell = _cells.find(Cell(point, dx, dy, dz));
                    if (cell == _cells.end()) {
                        continue;
                    }
                    for (const std::size_t i : cell->second) {
                        if (glm::length(_points[i] - point) <= distance) {
                            found.push_back(i);
                        }
                    }
                }
            }
        }
        return found;
    }

private:
    static constexpr double kCell = 1e-3;
    static std::array<long, 3> Cell(const glm::dvec3& p, int dx, int dy, int dz) {
        return {std::lround(p.x / kCell) + dx, std::lround(p.y / kCell) + dy,
                std::lround(p.z / kCell) + dz};
    }
    const std::vector<glm::dvec3>& _points;
    std::map<std::array<long, 3>, std::vector<std::size_t>> _cells;
};

glm::dvec3 PositionOf(const Diced& diced, std::size_t vertex) {
    return diced.source->Origin() + glm::dvec3(diced.chunk.positions[vertex]);
}

glm::dvec3 NormalOf(const ChunkGeometry& chunk, std::size_t triangle, int k) {
    const GeometryAttribute& normals = chunk.normals;
    std::size_t element = normals.interpolation == Interpolation::FaceVarying
                              ? chunk.corners[triangle][k]
                              : chunk.points[chunk.triangles[triangle][k]];
    if (!normals.indices.empty()) {
        element = std::size_t(normals.indices[element]);
    }
    const float* n = normals.values.data() + 3 * element;
    return {n[0], n[1], n[2]};
}

/// Every vertex of the diced mesh is a vertex of the refined one, and the other way round.
void CheckAgainstLimit(const GeometryDescription& mesh, int level) {
    const Diced diced = DiceUniform(mesh, std::uint32_t(level));
    ASSERT_TRUE(diced.source);
    const LimitLevel limit = RefineToLimit(mesh, level);
    std::set<int> used;
    for (const auto& face : limit.faces) {
        used.insert(face.begin(), face.end());
    }
    const PointFinder finder(limit.points);
    std::set<std::size_t> met;
    std::vector<std::size_t> pointOf(diced.chunk.positions.size());
    for (std::size_t i = 0; i < diced.chunk.positions.size(); ++i) {
        auto near = finder.Near(PositionOf(diced, i), 2e-6);
        if (near.empty()) { // only masks of darts are inexact
            near = finder.Near(PositionOf(diced, i), 2e-3);
            near.erase(std::remove_if(near.begin(), near.end(),
                                      [&](std::size_t point) { return !limit.isDart[point]; }),
                       near.end());
        }
        ASSERT_FALSE(near.empty()) << i;
        pointOf[i] = near.front();
        met.insert(near.begin(), near.end());
    }
    ASSERT_EQ(diced.chunk.positions.size(), used.size());
    for (const int point : used) {
        EXPECT_TRUE(met.count(std::size_t(point)) == 1);
    }
    const double side = mesh.leftHanded ? -1.0 : 1.0;
    for (std::size_t t = 0; t < diced.chunk.triangles.size(); ++t) {
        for (int k = 0; k < 3; ++k) {
            const std::size_t point = pointOf[diced.chunk.triangles[t][k]];
            if (mesh.subdivisionScheme != "bilinear" && !limit.isSharp[point] &&
                limit.normals[point] != glm::dvec3(0.0)) {
                ASSERT_LT(glm::length(NormalOf(diced.chunk, t, k) - side * limit.normals[point]),
                          2e-3);
            }
        }
    }
}

TEST(SubdivSource, VerticesAreOnTheLimitSurface) {
    std::mt19937 random(11);
    for (int round = 0; round < 24; ++round) {
        SCOPED_TRACE(round);
        GeometryDescription mesh = MakeRandomCage(random, round % 3 == 2);
        if (round % 6 == 1) {
            mesh.subdivisionScheme = "bilinear";
        }
        mesh.leftHanded = round % 2 == 1;
        if (round >= 6) {
            AddRandomTags(mesh, random);
        }
        if (round >= 12) {
            mesh.holeIndices = std::vector<std::int32_t>{1, 4};
        }
        for (int level = 1; level <= 3; ++level) {
            CheckAgainstLimit(mesh, level);
        }
    }
}

TEST(SubdivSource, OpenCagesFollowEveryBoundaryRule) {
    std::mt19937 random(12);
    for (int round = 0; round < 18; ++round) {
        SCOPED_TRACE(round);
        GeometryDescription mesh =
            MakeGrid(4, [&](float, float) { return float(random() % 100) / 300; });
        mesh.subdivisionScheme = "catmullClark";
        if (round >= 6) {
            AddRandomTags(mesh, random);
        }
        const char* const rules[] = {"none", "edgeOnly", "edgeAndCorner"};
        mesh.subdivTags.Edit().interpolateBoundary = rules[round % 3];
        CheckAgainstLimit(mesh, 2);
    }
}

/// Elements of an attribute at a triangle's corner.
const float* ValueAt(const ChunkGeometry& chunk, const GeometryAttribute& attribute, std::size_t t,
                     int k) {
    std::size_t element = 0;
    switch (attribute.interpolation) {
    case Interpolation::Vertex:
        element = chunk.points[chunk.triangles[t][k]];
        break;
    case Interpolation::FaceVarying:
        element = chunk.corners[t][k];
        break;
    case Interpolation::Uniform:
        element = chunk.faces[t];
        break;
    default:
        break;
    }
    if (!attribute.indices.empty()) {
        element = std::size_t(attribute.indices[element]);
    }
    return attribute.values.data() + element * attribute.numComponents;
}

TEST(SubdivSource, FaceVaryingValuesFollowTheirOwnTopology) {
    // Seams: every fifth corner has a value of its own, the others share one a point.
    std::mt19937 random(13);
    const char* const rules[] = {"none",         "cornersOnly", "cornersPlus1",
                                 "cornersPlus2", "boundaries",  "all"};
    for (int round = 0; round < 12; ++round) {
        SCOPED_TRACE(rules[round % 6]);
        GeometryDescription mesh = MakeRandomCage(random, round >= 6);
        mesh.subdivTags.Edit().faceVaryingLinearInterpolation = rules[round % 6];
        std::vector<glm::dvec2> uv;
        std::vector<int> indices;
        std::map<int, int> shared;
        for (const int point : mesh.faceVertexIndices) {
            const bool isOwn = random() % 5 == 0;
            if (isOwn || shared.count(point) == 0) {
                if (!isOwn) {
                    shared[point] = int(uv.size());
                }
                indices.push_back(int(uv.size()));
                uv.emplace_back(float(random() % 1000) / 1000.0F, float(random() % 1000) / 1000.0F);
            } else {
                indices.push_back(shared[point]);
            }
        }
        Primvar primvar;
        primvar.name = "st";
        primvar.interpolation = Interpolation::FaceVarying;
        primvar.numComponents = 2;
        std::vector<float> values;
        for (const glm::dvec2& v : uv) {
            values.insert(values.end(), {float(v.x), float(v.y)});
        }
        primvar.values = values;
        primvar.indices = std::vector<std::int32_t>(indices.begin(), indices.end());
        mesh.primvars = {primvar};
        const Diced diced = DiceUniform(mesh, 2);
        const LimitLevel limit = RefineToLimit(mesh, 2, uv, indices);
        const PointFinder finder(limit.points);
        ASSERT_EQ(diced.chunk.attributes.size(), 1U);
        std::map<std::pair<int, int>, std::vector<glm::dvec2>> expected; // by cage face and point
        for (std::size_t f = 0; f < limit.faces.size(); ++f) {
            for (std::size_t k = 0; k < limit.faces[f].size(); ++k) {
                expected[{limit.cageFaces[f], limit.faces[f][k]}].push_back(limit.uvs[f][k]);
            }
        }
        for (std::size_t t = 0; t < diced.chunk.triangles.size(); ++t) {
            for (int k = 0; k < 3; ++k) {
                const auto near = finder.Near(PositionOf(diced, diced.chunk.triangles[t][k]), 2e-6);
                ASSERT_EQ(near.size(), 1U);
                const float* st = ValueAt(diced.chunk, diced.chunk.attributes[0], t, k);
                double distance = 1.0;
                for (const glm::dvec2& v :
                     expected[{int(diced.chunk.faces[t]), int(near.front())}]) {
                    distance = std::min(distance, glm::length(v - glm::dvec2(st[0], st[1])));
                }
                ASSERT_LT(distance, 2e-3); // near extraordinary values end caps approximate
            }
        }
    }
}

TEST(SubdivSource, PrimvarsFollowThePoints) {
    // A vertex primvar that repeats the points must stay equal to them; x as a varying one is the
    // bilinear cage's; uniform and constant values stay with their faces.
    GeometryDescription mesh = MakeCube();
    Primvar vertex;
    vertex.name = "a";
    vertex.interpolation = Interpolation::Vertex;
    vertex.numComponents = 3;
    vertex.values = mesh.points;
    Primvar varying = vertex;
    varying.name = "b";
    varying.interpolation = Interpolation::Varying;
    Primvar uniform;
    uniform.name = "c";
    uniform.interpolation = Interpolation::Uniform;
    uniform.values = std::vector<float>{10, 11, 12};
    uniform.indices = std::vector<std::int32_t>{0, 1, 2, 2, 1, 0};
    Primvar constant;
    constant.name = "d";
    constant.values = std::vector<float>{7};
    mesh.primvars = {varying, uniform, constant, vertex};
    const Diced diced = DiceUniform(mesh, 2);
    GeometryDescription linear = MakeCube();
    linear.subdivisionScheme = "bilinear";
    const Diced cage = DiceUniform(linear, 2);
    EXPECT_TRUE(cage.chunk.normals.values.empty());
    ASSERT_EQ(diced.chunk.attributes.size(), 4U);
    ASSERT_EQ(cage.chunk.triangles, diced.chunk.triangles);
    const float byFace[] = {10, 11, 12, 12, 11, 10};
    for (std::size_t t = 0; t < diced.chunk.triangles.size(); ++t) {
        EXPECT_EQ(*ValueAt(diced.chunk, diced.chunk.attributes[2], t, 0),
                  byFace[diced.chunk.faces[t]]);
        EXPECT_EQ(*ValueAt(diced.chunk, diced.chunk.attributes[3], t, 0), 7.0F);
        for (int k = 0; k < 3; ++k) {
            const std::uint32_t point = diced.chunk.triangles[t][k];
            for (int axis = 0; axis < 3; ++axis) {
                EXPECT_EQ(ValueAt(diced.chunk, diced.chunk.attributes[0], t, k)[axis],
                          diced.chunk.positions[point][axis]);
                EXPECT_NEAR(ValueAt(diced.chunk, diced.chunk.attributes[1], t, k)[axis],
                            cage.chunk.positions[point][axis], 1e-6);
            }
        }
    }
}

TEST(SubdivSource, SharpCreasesKeepTheCubeAndItsNormals) {
    GeometryDescription mesh = MakeCube();
    std::vector<std::int32_t> creases;
    for (std::size_t f = 0; f < 6; ++f) {
        for (std::size_t k = 0; k < 4; ++k) {
            creases.push_back(mesh.faceVertexIndices[4 * f + k]);
            creases.push_back(mesh.faceVertexIndices[4 * f + (k + 1) % 4]);
        }
    }
    mesh.subdivTags.Edit().creaseLengths = std::vector<std::int32_t>(24, 2);
    mesh.subdivTags.Edit().creaseSharpnesses = std::vector<float>(24, 10.0F);
    mesh.subdivTags.Edit().creaseIndices = creases;
    const Diced diced = DiceUniform(mesh, 3);
    EXPECT_TRUE(diced.warnings.empty());
    ASSERT_EQ(diced.chunk.normals.interpolation, Interpolation::FaceVarying);
    double area = 0.0;
    for (std::size_t t = 0; t < diced.chunk.triangles.size(); ++t) {
        const glm::uvec3 triangle = diced.chunk.triangles[t];
        const glm::dvec3 p0 = PositionOf(diced, triangle.x);
        const glm::dvec3 cross =
            glm::cross(PositionOf(diced, triangle.y) - p0, PositionOf(diced, triangle.z) - p0);
        area += 0.5 * glm::length(cross);
        for (int k = 0; k < 3; ++k) {
            EXPECT_LT(glm::length(NormalOf(diced.chunk, t, k) - glm::normalize(cross)), 1e-5);
        }
    }
    EXPECT_NEAR(area, 24.0, 1e-5);
}

TEST(SubdivSource, CubeCornersGoToTheirLimit) {
    // Halstead, Kass, DeRose 1993: limit = (n^2 v + 4 sum of edge ends + sum of face diagonals) /
    // (n (n + 5)); for the corner (1,1,1) of a cube, n = 3: (9 + 4 - 1) / 24 = 1/2 per coordinate.
    // At level 0 as well.
    for (std::uint32_t level = 0; level < 3; ++level) {
        const Diced diced = DiceUniform(MakeCube(), level);
        int numFound = 0;
        for (const glm::vec3& p : diced.chunk.positions) {
            const glm::vec3 distance = glm::abs(glm::abs(p) - 0.5F);
            numFound += std::max({distance.x, distance.y, distance.z}) < 1e-6F ? 1 : 0;
        }
        EXPECT_EQ(numFound, 8);
        EXPECT_EQ(diced.chunk.triangles.size(), 12U << (2 * level));
    }
}

TEST(SubdivSource, FacesAndSubsetsStayAuthored) {
    GeometryDescription mesh = MakeCube();
    mesh.holeIndices = std::vector<std::int32_t>{2, 17};
    mesh.subsets = {{"a", std::vector<std::int32_t>{4, 1}}};
    const Diced diced = DiceUniform(mesh, 2);
    EXPECT_EQ(diced.warnings,
              std::vector<std::string>{"/World/mesh: 1 holeIndices ignored: out of range"});
    std::map<std::uint32_t, int> numByFace;
    for (std::size_t t = 0; t < diced.chunk.triangles.size(); ++t) {
        const std::uint32_t face = diced.chunk.faces[t];
        ++numByFace[face];
        EXPECT_EQ(diced.chunk.primIds[t], t);
        EXPECT_EQ(diced.chunk.materialEntries[t], face == 4 || face == 1 ? 1U : 0U);
    }
    EXPECT_EQ(numByFace,
              (std::map<std::uint32_t, int>{{0, 32}, {1, 32}, {3, 32}, {4, 32}, {5, 32}}));
}

/// Values (derivative 0) or slopes (1) of the four cubic B-splines that are not zero at t in [0,
/// 1].
std::array<double, 4> BSpline(double t, int derivative) {
    const double s = 1.0 - t;
    if (derivative == 0) {
        return {s * s * s / 6.0, (3 * t * t * t - 6 * t * t + 4) / 6.0,
                (-3 * t * t * t + 3 * t * t + 3 * t + 1) / 6.0, t * t * t / 6.0};
    }
    return {-s * s / 2.0, (3 * t * t - 4 * t) / 2.0, (-3 * t * t + 2 * t + 1) / 2.0, t * t / 2.0};
}

/// The bicubic patch of a grid of (n + 1)^2 points in cell (x, y) of its interior.
glm::dvec3 EvaluateGrid(const GeometryDescription& grid, int n, double s, double t, int ds,
                        int dt) {
    const int x = std::min(static_cast<int>(s), n - 2);
    const int y = std::min(static_cast<int>(t), n - 2);
    const auto bs = BSpline(s - x, ds);
    const auto bt = BSpline(t - y, dt);
    glm::dvec3 sum(0.0);
    for (int j = 0; j < 4; ++j) {
        for (int i = 0; i < 4; ++i) {
            const float* p = grid.points.data() + 3 * ((y - 1 + j) * (n + 1) + x - 1 + i);
            sum += bs[std::size_t(i)] * bt[std::size_t(j)] * glm::dvec3(p[0], p[1], p[2]);
        }
    }
    return sum;
}

TEST(SubdivSource, RegularGridsAreBicubicBSplines) {
    // Stam 1998: regular regions of a Catmull-Clark surface are uniform bicubic B-splines. x and y
    // of the grid are linear, so that a vertex tells its own parameters.
    constexpr int n = 6;
    for (const bool isLeftHanded : {false, true}) {
        GeometryDescription grid =
            MakeGrid(n, [](float s, float t) { return 0.4F * std::sin(9.0F * s) * t + s * s; });
        grid.subdivisionScheme = "catmullClark";
        grid.leftHanded = isLeftHanded;
        const Diced diced = DiceUniform(grid, 4);
        EXPECT_EQ(diced.source->IsLeftHanded(), isLeftHanded);
        int numInside = 0;
        for (std::size_t i = 0; i < diced.chunk.positions.size(); ++i) {
            const glm::dvec3 p(diced.chunk.positions[i]);
            const double s = p.x * n;
            const double t = p.y * n;
            if (s < 1.001 || s > n - 1.001 || t < 1.001 || t > n - 1.001) {
                continue; // the boundary has other rules
            }
            ++numInside;
            // Positions are rounded to float; the height changes by at most 4 per group of s.
            EXPECT_NEAR(p.z, EvaluateGrid(grid, n, s, t, 0, 0).z, 2e-6);
            const glm::dvec3 normal = glm::normalize(
                glm::cross(EvaluateGrid(grid, n, s, t, 1, 0), EvaluateGrid(grid, n, s, t, 0, 1)));
            const float* computed = diced.chunk.normals.values.data() + 3 * i;
            const double side = isLeftHanded ? -1.0 : 1.0;
            EXPECT_LT(
                glm::length(glm::dvec3(computed[0], computed[1], computed[2]) - side * normal),
                1e-5);
        }
        EXPECT_EQ(numInside, 63 * 63);
    }
}

/// How far a point is from a shape about the z axis with radius 1 and height 2, ends left out.
double DistanceFrom(const std::string& type, const glm::dvec3& p) {
    const double toAxis = std::hypot(p.x, p.y);
    if (type == "Sphere") {
        return std::abs(glm::length(p) - 1.0);
    }
    if (type == "Capsule") {
        return std::abs(std::hypot(toAxis, std::max(std::abs(p.z) - 1.0, 0.0)) - 1.0);
    }
    const double radius = type == "Cone" ? 0.5 * (1.0 - p.z) : 1.0;
    return std::abs(p.z) == 1.0 ? std::max(toAxis - radius, 0.0) : std::abs(toAxis - radius);
}

TEST(SubdivSource, FittedCagesOfImplicitShapesAreRound) {
    struct Expected {
        const char* type;
        double farthest; ///< between the vertices of the cage; capsules change their curvature
    };
    const Expected cases[] = {
        {"Sphere", 0.002}, {"Capsule", 0.04}, {"Cylinder", 0.002}, {"Cone", 0.002}};
    for (const Expected& e : cases) {
        SCOPED_TRACE(e.type);
        ImplicitShape shape;
        shape.type = e.type;
        GeometryDescription mesh = MakeImplicitMesh(shape);
        FitLimitSurface(mesh);
        // By OpenSubdiv: vertices of the cage are on the shape, all others close to it.
        const Diced vertices = DiceUniform(mesh, 0);
        EXPECT_TRUE(vertices.warnings.empty());
        ASSERT_FALSE(vertices.chunk.positions.empty());
        for (const glm::vec3& p : vertices.chunk.positions) {
            EXPECT_LT(DistanceFrom(e.type, p), 1e-6);
        }
        for (const glm::vec3& p : DiceUniform(mesh, 3).chunk.positions) {
            EXPECT_LT(DistanceFrom(e.type, p), e.farthest);
        }
    }
}

TEST(SubdivSource, WhatHasNoLimitSurfaceIsNotFitted) {
    ImplicitShape shape;
    shape.type = "Cube"; // bilinear
    const auto pointsOf = [](const GeometryDescription& mesh) {
        return std::vector<float>(mesh.points.begin(), mesh.points.end());
    };
    GeometryDescription mesh = MakeImplicitMesh(shape);
    const std::vector<float> authored = pointsOf(mesh);
    FitLimitSurface(mesh);
    EXPECT_EQ(pointsOf(mesh), authored);
    mesh.subdivisionScheme = "catmullClark";
    mesh.faceVertexIndices = std::vector<std::int32_t>{0, 1, 2, 8};
    FitLimitSurface(mesh); // more corners are counted, and one is no point
    EXPECT_EQ(pointsOf(mesh), authored);
}

TEST(SubdivSource, FarCagesKeepTheirDetail) {
    GeometryDescription cube = MakeCube();
    std::vector<float> points(cube.points.begin(), cube.points.end());
    for (float& p : points) {
        p += 1048576.0F;
    }
    cube.points = points;
    const Diced far = DiceUniform(cube, 3);
    const Diced near = DiceUniform(MakeCube(), 3);
    ASSERT_EQ(far.chunk.positions.size(), near.chunk.positions.size());
    for (std::size_t i = 0; i < far.chunk.positions.size(); ++i) {
        const glm::dvec3 moved = PositionOf(far, i) - 1048576.0;
        EXPECT_LT(glm::length(moved - PositionOf(near, i)), 1e-6);
    }
}

} // namespace
} // namespace hds::test
