// SPDX-License-Identifier: Apache-2.0
// Subdivision against closed forms: uniform bicubic B-splines, Catmull and Clark's limit of a
// vertex, creases that keep a cube a cube, and primvars that must follow the points.
#include "hdStream/geometry/implicitMesh.h"
#include "testenv/unit/geometry/meshFixtures.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>

namespace hds::test {
namespace {

Triangulated Refine(const MeshDescription& mesh, int level) {
    Warnings warnings;
    auto result = Triangulate(mesh, "/World/mesh", warnings, level);
    return {std::move(result), warnings.Lines()};
}

MeshDescription MakeCubeCage() {
    ImplicitShape shape;
    shape.type = "Cube";
    shape.size = 2.0;
    MeshDescription mesh = MakeImplicitMesh(shape);
    mesh.subdivisionScheme = "catmullClark";
    return mesh;
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
glm::dvec3 EvaluateGrid(const MeshDescription& grid, int n, double s, double t, int ds, int dt) {
    const int x = std::min(static_cast<int>(s), n - 2);
    const int y = std::min(static_cast<int>(t), n - 2);
    const auto bs = BSpline(s - x, ds);
    const auto bt = BSpline(t - y, dt);
    glm::dvec3 sum(0.0);
    for (int j = 0; j < 4; ++j) {
        for (int i = 0; i < 4; ++i) {
            const float* p = grid.points.data() + 3 * ((y - 1 + j) * (n + 1) + x - 1 + i);
            sum += bs[i] * bt[j] * glm::dvec3(p[0], p[1], p[2]);
        }
    }
    return sum;
}

TEST(Subdivide, RegularGridsAreBicubicBSplines) {
    // Stam 1998: regular regions of a Catmull-Clark surface are uniform bicubic B-splines. x and y
    // of the grid are linear, so that a refined vertex tells its own parameters.
    constexpr int n = 6;
    for (const bool isLeftHanded : {false, true}) {
        MeshDescription grid =
            MakeGrid(n, [](float s, float t) { return 0.4F * std::sin(9.0F * s) * t + s * s; });
        grid.subdivisionScheme = "catmullClark";
        grid.leftHanded = isLeftHanded;
        const Triangulated run = Refine(grid, 3);
        EXPECT_TRUE(run.warnings.empty());
        ASSERT_EQ(run.mesh->triangles.size(), std::size_t(2 * n * n * 64));
        ASSERT_EQ(run.mesh->normals.interpolation, Interpolation::Vertex);
        int numInside = 0;
        for (std::size_t i = 0; i < run.mesh->positions.size(); ++i) {
            const glm::dvec3 p(run.mesh->positions[i]);
            const double s = p.x * n;
            const double t = p.y * n;
            if (s < 1.001 || s > n - 1.001 || t < 1.001 || t > n - 1.001) {
                continue; // the boundary has other rules
            }
            ++numInside;
            // Positions are rounded to float; the height changes by at most 4 per unit of s.
            EXPECT_NEAR(p.z, EvaluateGrid(grid, n, s, t, 0, 0).z, 2e-6);
            const glm::dvec3 normal = glm::normalize(
                glm::cross(EvaluateGrid(grid, n, s, t, 1, 0), EvaluateGrid(grid, n, s, t, 0, 1)));
            const float* computed = run.mesh->normals.values.data() + 3 * i;
            const double side = isLeftHanded ? -1.0 : 1.0;
            EXPECT_LT(
                glm::length(glm::dvec3(computed[0], computed[1], computed[2]) - side * normal),
                1e-5);
        }
        EXPECT_EQ(numInside, 31 * 31);
    }
}

TEST(Subdivide, CubeCornersGoToTheirLimit) {
    // Halstead, Kass, DeRose 1993: limit = (n^2 v + 4 sum of edge ends + sum of face diagonals) /
    // (n (n + 5)); for the corner (1,1,1) of a cube, n = 3: (9 + 4 - 1) / 24 = 1/2 per coordinate.
    const auto mesh = Refine(MakeCubeCage(), 2).mesh;
    int numFound = 0;
    for (const glm::vec3& p : mesh->positions) {
        numFound += std::fabs(std::fabs(p.x) - 0.5F) < 1e-6F &&
                            std::fabs(std::fabs(p.y) - 0.5F) < 1e-6F &&
                            std::fabs(std::fabs(p.z) - 0.5F) < 1e-6F
                        ? 1
                        : 0;
    }
    EXPECT_EQ(numFound, 8);
    EXPECT_EQ(mesh->triangles.size(), 6U * 16 * 2);
    // Closed and outwards: area vectors cancel, the volume is positive and below the cage's.
    glm::dvec3 sum(0.0);
    double volume = 0.0;
    for (std::size_t t = 0; t < mesh->triangles.size(); ++t) {
        sum += AreaVector(*mesh, t);
        volume +=
            glm::dot(AreaVector(*mesh, t), glm::dvec3(mesh->positions[mesh->triangles[t].x])) / 3.0;
    }
    EXPECT_LT(glm::length(sum), 1e-6);
    EXPECT_GT(volume, 1.0);
    EXPECT_LT(volume, 8.0);
}

TEST(Subdivide, FacesStayAuthoredAndInOrder) {
    MeshDescription mesh = MakeCubeCage();
    mesh.holeIndices = std::vector<std::int32_t>{2};
    mesh.subsets = {{"a", std::vector<std::int32_t>{4, 1}}};
    const Triangulated run = Refine(mesh, 2);
    EXPECT_TRUE(run.warnings.empty());
    std::map<std::uint32_t, int> numByFace;
    for (std::size_t t = 0; t < run.mesh->faces.size(); ++t) {
        const std::uint32_t face = run.mesh->faces[t];
        ++numByFace[face];
        EXPECT_TRUE(t == 0 || face >= run.mesh->faces[t - 1]);
        EXPECT_EQ(run.mesh->materialEntries[t], face == 4 || face == 1 ? 1U : 0U);
    }
    EXPECT_EQ(numByFace,
              (std::map<std::uint32_t, int>{{0, 32}, {1, 32}, {3, 32}, {4, 32}, {5, 32}}));
    // A hole is not drawn but shapes the surface: the corners' limits are the cube's.
    glm::vec3 high(0.0F);
    for (const glm::uvec3& t : run.mesh->triangles) {
        high.z = std::max(high.z, run.mesh->positions[t.x].z);
    }
    const auto whole = Refine(MakeCubeCage(), 2).mesh;
    EXPECT_EQ(high.z + run.mesh->origin.z, whole->bounds.max.z);
}

TEST(Subdivide, SharpCreasesKeepTheCubeAndItsNormals) {
    MeshDescription mesh = MakeCubeCage();
    std::vector<std::int32_t> creases;
    for (std::size_t f = 0; f < 6; ++f) {
        for (std::size_t k = 0; k < 4; ++k) {
            creases.push_back(mesh.faceVertexIndices[4 * f + k]);
            creases.push_back(mesh.faceVertexIndices[4 * f + (k + 1) % 4]);
        }
    }
    mesh.subdivTags.creaseLengths = std::vector<std::int32_t>(24, 2);
    mesh.subdivTags.creaseSharpnesses = std::vector<float>(24, 10.0F);
    mesh.subdivTags.creaseIndices = creases;
    mesh.subdivTags.cornerIndices = std::vector<std::int32_t>{0, 1, 2, 3, 4, 5, 6, 7};
    mesh.subdivTags.cornerSharpnesses = std::vector<float>(8, 10.0F);
    const Triangulated run = Refine(mesh, 3);
    EXPECT_TRUE(run.warnings.empty());
    EXPECT_NEAR(TotalArea(*run.mesh), 24.0, 1e-5);
    ASSERT_EQ(run.mesh->normals.interpolation, Interpolation::FaceVarying);
    for (std::size_t t = 0; t < run.mesh->triangles.size(); ++t) {
        const glm::dvec3 face = glm::normalize(AreaVector(*run.mesh, t));
        for (int k = 0; k < 3; ++k) {
            const std::size_t corner = run.mesh->corners[t][k];
            const std::size_t index = run.mesh->normals.indices.empty()
                                          ? corner
                                          : std::size_t(run.mesh->normals.indices[corner]);
            const float* n = run.mesh->normals.values.data() + 3 * index;
            EXPECT_LT(glm::length(glm::dvec3(n[0], n[1], n[2]) - face), 1e-5);
        }
    }
}

TEST(Subdivide, PrimvarsFollowThePoints) {
    // A vertex primvar that repeats the points must stay equal to them; so must a faceVarying one
    // with the points' topology when its boundary rule is the surface's. A cage of linear x as
    // varying is the bilinear surface; uniform values stay with their faces.
    MeshDescription mesh = MakeCubeCage();
    mesh.subdivTags.faceVaryingLinearInterpolation = "none";
    Primvar vertex;
    vertex.name = "a";
    vertex.interpolation = Interpolation::Vertex;
    vertex.numComponents = 3;
    vertex.values = mesh.points;
    Primvar corner = vertex;
    corner.name = "b";
    corner.interpolation = Interpolation::FaceVarying;
    corner.indices = mesh.faceVertexIndices;
    Primvar uniform;
    uniform.name = "c";
    uniform.interpolation = Interpolation::Uniform;
    uniform.values = std::vector<float>{10, 11, 12};
    uniform.indices = std::vector<std::int32_t>{0, 1, 2, 2, 1, 0};
    mesh.primvars = {vertex, corner, uniform};
    const auto refined = Refine(mesh, 2).mesh;
    ASSERT_EQ(refined->attributes.size(), 3U);
    const MeshAttribute& a = refined->attributes[0];
    const MeshAttribute& b = refined->attributes[1];
    const MeshAttribute& c = refined->attributes[2];
    ASSERT_EQ(b.interpolation, Interpolation::FaceVarying);
    const float byFace[] = {10, 11, 12, 12, 11, 10};
    for (std::size_t t = 0; t < refined->triangles.size(); ++t) {
        for (int k = 0; k < 3; ++k) {
            const std::size_t point = refined->triangles[t][k];
            for (int axis = 0; axis < 3; ++axis) {
                const float expected = refined->positions[point][axis];
                EXPECT_EQ(a.values[3 * point + axis], expected);
                EXPECT_NEAR(b.values[3 * std::size_t(b.indices[refined->corners[t][k]]) + axis],
                            expected, 1e-6);
            }
        }
    }
    // Read as the attribute page reads it: by the triangle's authored face.
    ASSERT_EQ(refined->faces.size(), 2U * 96U);
    for (std::size_t t = 0; t < refined->faces.size(); ++t) {
        const std::uint32_t face = refined->faces[t];
        EXPECT_EQ(face, t / 2 / 16);
        EXPECT_EQ(c.values[c.indices[face]], byFace[face]);
    }
}

TEST(Subdivide, SpheresAreRound) {
    ImplicitShape shape;
    shape.type = "Sphere";
    const Triangulated run = Refine(MakeImplicitMesh(shape), 3);
    EXPECT_TRUE(run.warnings.empty());
    // The limit lies inside the cage, whose points are on the sphere; 10 sides lose about 5 %.
    double low = 10.0;
    double high = 0.0;
    for (const glm::vec3& p : run.mesh->positions) {
        low = std::min(low, double(glm::length(p)));
        high = std::max(high, double(glm::length(p)));
    }
    EXPECT_LT(high, 1.0);
    EXPECT_GT(low, 0.9);
    for (const char* type : {"Cone", "Cylinder", "Capsule", "Cube", "Plane"}) {
        shape.type = type;
        EXPECT_TRUE(Refine(MakeImplicitMesh(shape), 2).warnings.empty()) << type;
    }
}

TEST(Subdivide, WhatCannotBeSubdividedDrawsItsCage) {
    MeshDescription quads = MakeCubeCage();
    quads.subdivisionScheme = "loop";
    const Triangulated loop = Refine(quads, 2);
    EXPECT_EQ(loop.mesh->triangles.size(), 12U);
    EXPECT_EQ(loop.warnings,
              std::vector<std::string>{"/World/mesh: not subdivided: loop needs triangles only"});
    MeshDescription tags = MakeCubeCage();
    tags.subdivTags.creaseLengths = std::vector<std::int32_t>{3};
    tags.subdivTags.cornerIndices = std::vector<std::int32_t>{8};
    tags.subdivTags.cornerSharpnesses = std::vector<float>{1.0F};
    EXPECT_EQ(Refine(tags, 1).warnings,
              (std::vector<std::string>{
                  "/World/mesh: corners ignored: indices and sharpnesses disagree",
                  "/World/mesh: creases ignored: lengths, indices and sharpnesses disagree"}));
    MeshDescription none = MakeCubeCage();
    none.subdivisionScheme = "none";
    EXPECT_EQ(Refine(none, 2).mesh->triangles.size(), 12U);
    EXPECT_TRUE(Refine(MeshDescription(), 2).mesh->triangles.empty());
}

TEST(Subdivide, GarbageNeverBreaksTheInvariants) {
    std::mt19937 random(37);
    for (int round = 0; round < 400; ++round) {
        MeshDescription mesh;
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
        const char* schemes[] = {"bilinear", "catmullClark", "loop"};
        mesh.subdivisionScheme = schemes[random() % 3];
        mesh.points = points;
        mesh.faceVertexCounts = counts;
        mesh.faceVertexIndices = indices;
        mesh.holeIndices = std::vector<std::int32_t>(random() % 3, std::int32_t(random() % 6) - 1);
        mesh.subdivTags.creaseLengths = std::vector<std::int32_t>(1, 3);
        mesh.subdivTags.creaseIndices = std::vector<std::int32_t>{0, 1, 5};
        mesh.subdivTags.creaseSharpnesses = std::vector<float>{random() % 2 == 0 ? 10.0F : 1.5F};
        Primvar primvar;
        primvar.name = "st";
        primvar.interpolation = static_cast<Interpolation>(random() % 5);
        primvar.numComponents = 2;
        primvar.values = std::vector<float>(2 * (points.size() / 3));
        mesh.primvars = {primvar};
        const auto result = Refine(mesh, 1 + int(random() % 2)).mesh;
        for (std::size_t t = 0; t < result->triangles.size(); ++t) {
            ASSERT_LT(result->faces[t], counts.size());
            ASSERT_GT(glm::length(AreaVector(*result, t)), 0.0);
        }
    }
}

} // namespace
} // namespace hds::test
