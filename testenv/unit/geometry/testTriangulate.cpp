// SPDX-License-Identifier: Apache-2.0
// What Triangulate keeps, drops and says: hostile content gives exact counts and one line each.
#include "testenv/unit/geometry/meshFixtures.h"

#include "hdStream/geometry/attributePage.h"
#include "hdStream/geometry/triangleMeshSource.h"

#include <gtest/gtest.h>

#include <tbb/global_control.h>

#include <cmath>
#include <cstring>
#include <limits>

namespace hds::test {
namespace {

using Lines = std::vector<std::string>;
constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
constexpr float kInf = std::numeric_limits<float>::infinity();

/// A row of `n` unit quads along x; quad i has the points 4 i .. 4 i + 3 of its own.
GeometryDescription MakeRow(int n) {
    std::vector<glm::vec3> points;
    std::vector<std::int32_t> indices;
    for (int i = 0; i < n; ++i) {
        const auto x = static_cast<float>(2 * i);
        points.insert(points.end(), {{x, 0, 0}, {x + 1, 0, 0}, {x + 1, 1, 0}, {x, 1, 0}});
        indices.insert(indices.end(), {4 * i, 4 * i + 1, 4 * i + 2, 4 * i + 3});
    }
    return MakeMesh(points, std::vector<std::int32_t>(n, 4), indices);
}

template <typename T>
std::vector<T> ToVector(const SharedSpan<T>& span) {
    return {span.begin(), span.end()};
}

TEST(Triangulate, GoodMeshIsTakenOverWithoutWarning) {
    const Triangulated result = RunTriangulate(MakeRow(3));
    EXPECT_TRUE(result.warnings.empty());
    ASSERT_EQ(result.mesh->triangles.size(), 6U);
    EXPECT_EQ(result.mesh->faces, (std::vector<std::uint32_t>{0, 0, 1, 1, 2, 2}));
    EXPECT_EQ(result.mesh->triangles[2], glm::uvec3(4, 5, 6));
    EXPECT_EQ(result.mesh->triangles[3], glm::uvec3(4, 6, 7));
    EXPECT_EQ(result.mesh->corners[3], glm::uvec3(4, 6, 7));
    EXPECT_TRUE(result.mesh->materialEntries.empty());
    EXPECT_TRUE(result.mesh->normals.values.empty());
    EXPECT_EQ(result.mesh->bounds.max, glm::vec3(5, 1, 0));
}

TEST(Triangulate, EmptyMeshesAreSilent) {
    EXPECT_TRUE(RunTriangulate(GeometryDescription()).warnings.empty());
    GeometryDescription pointsOnly;
    pointsOnly.points = std::vector<float>{0, 0, 0, 1, 1, 1};
    const Triangulated result = RunTriangulate(pointsOnly);
    EXPECT_TRUE(result.warnings.empty());
    EXPECT_TRUE(result.mesh->triangles.empty());
    EXPECT_GT(result.mesh->bounds.min.x, result.mesh->bounds.max.x);
}

TEST(Triangulate, BadIndicesAreCounted) {
    GeometryDescription mesh = MakeRow(6);
    auto indices = ToVector(mesh.faceVertexIndices);
    indices[1] = -1;
    indices[4] = 24; // one beyond the last point
    indices[5] = std::numeric_limits<std::int32_t>::max();
    indices[20] = std::numeric_limits<std::int32_t>::min();
    mesh.faceVertexIndices = indices;
    const Triangulated result = RunTriangulate(mesh);
    EXPECT_EQ(result.warnings, Lines{"/World/mesh: 3 faces dropped: point index out of range"});
    EXPECT_EQ(result.mesh->faces, (std::vector<std::uint32_t>{2, 2, 3, 3, 4, 4}));
}

TEST(Triangulate, UnusablePointsAreCounted) {
    GeometryDescription mesh = MakeRow(5);
    auto points = ToVector(mesh.points);
    points[3 * 0 + 1] = kNan;
    points[3 * 5 + 2] = kInf;
    points[3 * 6 + 0] = -kInf;
    points[3 * 9 + 0] = 2e18F;
    mesh.points = points;
    const Triangulated result = RunTriangulate(mesh);
    EXPECT_EQ(result.warnings,
              Lines{"/World/mesh: 3 faces dropped: point not finite or beyond 1e18"});
    EXPECT_EQ(result.mesh->faces, (std::vector<std::uint32_t>{3, 3, 4, 4}));
    // Nothing of them is left in what other layers read.
    EXPECT_EQ(result.mesh->bounds.min.x + result.mesh->origin.x, 6.0);
    for (const glm::vec3& p : result.mesh->positions) {
        EXPECT_TRUE(std::isfinite(p.x) && std::isfinite(p.y) && std::isfinite(p.z));
    }
}

TEST(Triangulate, SmallCountsAreCounted) {
    GeometryDescription mesh = MakeRow(3);
    mesh.faceVertexCounts = std::vector<std::int32_t>{2, 0, 1, -7, 1, 4, 4};
    const Triangulated result = RunTriangulate(mesh);
    EXPECT_EQ(result.warnings, Lines{"/World/mesh: 5 faces dropped: fewer than 3 vertices"});
    EXPECT_EQ(result.mesh->faces, (std::vector<std::uint32_t>{5, 5, 6, 6}));
}

TEST(Triangulate, ShortAndLongIndexArraysAreNamed) {
    GeometryDescription mesh = MakeRow(4);
    mesh.faceVertexCounts = std::vector<std::int32_t>{4, 4, 4, 4, 4, 3};
    EXPECT_EQ(RunTriangulate(mesh).warnings,
              (Lines{"/World/mesh: 2 faces dropped: faceVertexIndices end before them",
                     "/World/mesh: faceVertexCounts ask for 23 faceVertexIndices, there are 16"}));
    EXPECT_EQ(RunTriangulate(mesh).mesh->triangles.size(), 8U);
    mesh.faceVertexCounts = std::vector<std::int32_t>{4, 4, 4};
    EXPECT_EQ(RunTriangulate(mesh).warnings,
              (Lines{"/World/mesh: faceVertexCounts ask for 12 faceVertexIndices, there are 16"}));
    EXPECT_EQ(RunTriangulate(mesh).mesh->triangles.size(), 6U);
}

TEST(Triangulate, HugeCountsAllocateNothing) {
    GeometryDescription mesh = MakeRow(2);
    mesh.faceVertexCounts =
        std::vector<std::int32_t>(1000, std::numeric_limits<std::int32_t>::max());
    const Triangulated result = RunTriangulate(mesh);
    EXPECT_TRUE(result.mesh->triangles.empty());
    EXPECT_EQ(result.warnings.size(), 2U);
}

TEST(Triangulate, ZeroAreaFacesAreCountedAndOrderIsKept) {
    const GeometryDescription mesh =
        MakeMesh({{0, 0, 0}, {1, 0, 0}, {2, 0, 0}, {0, 1, 0}, {1e-30F, 0, 0}, {0, 1e-30F, 0}},
                 {3, 3, 3, 4, 3, 3},
                 {0, 1, 3,    // fine
                  0, 1, 2,    // in a line
                  0, 0, 3,    // a repeated point
                  0, 1, 2, 1, // a folded line
                  0, 4, 5,    // its normal underflows
                  1, 2, 3});
    const Triangulated result = RunTriangulate(mesh);
    EXPECT_EQ(result.warnings, Lines{"/World/mesh: 4 faces dropped: zero area"});
    EXPECT_EQ(result.mesh->faces, (std::vector<std::uint32_t>{0, 5}));
}

TEST(Triangulate, EachReasonHasOneLineAndAFaceCountsOnce) {
    GeometryDescription mesh =
        MakeMesh({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {kNan, 0, 0}}, {3, 3, 3, 2, 3, 3},
                 {0, 1, 2, 3, 9, 9, 3, 3, 0, 0, 1, 0, 0, 1, 0});
    EXPECT_EQ(RunTriangulate(mesh).warnings,
              (Lines{"/World/mesh: 1 face dropped: faceVertexIndices end before them",
                     "/World/mesh: 1 face dropped: fewer than 3 vertices",
                     "/World/mesh: 1 face dropped: point index out of range",
                     "/World/mesh: 1 face dropped: point not finite or beyond 1e18",
                     "/World/mesh: 1 face dropped: zero area",
                     "/World/mesh: faceVertexCounts ask for 17 faceVertexIndices, there are 15"}));
}

TEST(Triangulate, HolesAreLeftOut) {
    GeometryDescription mesh = MakeRow(4);
    mesh.holeIndices = std::vector<std::int32_t>{2, 0, 2};
    const Triangulated result = RunTriangulate(mesh);
    EXPECT_TRUE(result.warnings.empty());
    EXPECT_EQ(result.mesh->faces, (std::vector<std::uint32_t>{1, 1, 3, 3}));
    mesh.holeIndices = std::vector<std::int32_t>{-1, 4, 3};
    EXPECT_EQ(RunTriangulate(mesh).warnings,
              Lines{"/World/mesh: 2 holeIndices ignored: out of range"});
    EXPECT_EQ(RunTriangulate(mesh).mesh->triangles.size(), 6U);
}

TEST(Triangulate, SubsetsGiveMaterialEntries) {
    GeometryDescription mesh = MakeRow(4);
    mesh.subsets = {{"/World/mesh/a", std::vector<std::int32_t>{3, 1}},
                    {"/World/mesh/b", std::vector<std::int32_t>{1, 2, 4, -2}},
                    {"/World/mesh/none", {}}};
    const Triangulated result = RunTriangulate(mesh);
    EXPECT_EQ(result.mesh->materialEntries, (std::vector<std::uint32_t>{0, 0, 1, 1, 2, 2, 1, 1}));
    EXPECT_EQ(
        result.warnings,
        (Lines{"/World/mesh: subset /World/mesh/b: 1 faces ignored: taken by an earlier subset",
               "/World/mesh: subset /World/mesh/b: 2 faces ignored: out of range"}));
    mesh.subsets = {{"/World/mesh/none", {}}};
    EXPECT_TRUE(RunTriangulate(mesh).mesh->materialEntries.empty());
}

TEST(Triangulate, LeftHandedKeepsTheWinding) {
    GeometryDescription mesh = MakeRow(2);
    const auto right = RunTriangulate(mesh).mesh;
    mesh.leftHanded = true;
    const auto left = RunTriangulate(mesh).mesh;
    EXPECT_EQ(left->triangles, right->triangles);
    EXPECT_TRUE(left->leftHanded);
    EXPECT_FALSE(right->leftHanded);
}

TEST(Triangulate, FarMeshesAreRecentredExactly) {
    std::mt19937 random(11);
    std::uniform_real_distribution<float> offset(-30.0F, 30.0F);
    for (const glm::vec3& centre :
         {glm::vec3(1e7F, 0, 0), glm::vec3(-3e5F, 2e5F, 7.0F), glm::vec3(500, 500, 500)}) {
        std::vector<glm::vec3> points;
        std::vector<std::int32_t> indices;
        for (int i = 0; i < 300; ++i) {
            points.push_back(centre + glm::vec3(offset(random), offset(random), offset(random)));
            indices.push_back(i);
        }
        const auto mesh =
            RunTriangulate(MakeMesh(points, std::vector<std::int32_t>(100, 3), indices)).mesh;
        EXPECT_NE(mesh->origin, glm::dvec3(0.0));
        for (std::size_t i = 0; i < points.size(); ++i) {
            // Exact: the authored float comes back from the double sum.
            EXPECT_EQ(glm::dvec3(mesh->positions[i]) + mesh->origin, glm::dvec3(points[i]));
        }
        // Two thirds of the way off at most on an axis that did not move: 4 half diagonals.
        const glm::vec3 middle = 0.5F * (mesh->bounds.min + mesh->bounds.max);
        EXPECT_LE(glm::length(middle), 4.0F * glm::length(mesh->bounds.max - middle));
    }
}

TEST(Triangulate, NearMeshesAreNotMoved) {
    const auto mesh = RunTriangulate(MakeRow(3)).mesh;
    EXPECT_EQ(mesh->origin, glm::dvec3(0.0));
    // A stray point that no face uses moves neither bounds nor origin.
    GeometryDescription withStray = MakeRow(3);
    auto points = ToVector(withStray.points);
    points.insert(points.end(), {1e9F, 1e9F, 1e9F});
    withStray.points = points;
    EXPECT_EQ(RunTriangulate(withStray).mesh->bounds.max, mesh->bounds.max);
}

TEST(Triangulate, UnknownSchemeAndOddPointsWarn) {
    GeometryDescription mesh = MakeRow(1);
    mesh.subdivisionScheme = "doo-sabin";
    auto points = ToVector(mesh.points);
    points.push_back(1.0F);
    mesh.points = points;
    EXPECT_EQ(RunTriangulate(mesh).warnings,
              (Lines{"/World/mesh: 1 floats after the last point ignored",
                     "/World/mesh: unknown subdivisionScheme \"doo-sabin\", drawn as none"}));
}

/// All arrays of a mesh as one list of words.
std::vector<std::uint32_t> Words(const TriangleMesh& mesh) {
    std::vector<std::uint32_t> words(mesh.faces);
    const auto append = [&](const void* data, std::size_t bytes) {
        const std::size_t begin = words.size();
        words.resize(begin + bytes / 4);
        if (bytes > 0) {
            std::memcpy(words.data() + begin, data, bytes);
        }
    };
    append(mesh.triangles.data(), mesh.triangles.size() * sizeof(glm::uvec3));
    append(mesh.corners.data(), mesh.corners.size() * sizeof(glm::uvec3));
    append(mesh.positions.data(), mesh.positions.size() * sizeof(glm::vec3));
    append(mesh.normals.values.data(), mesh.normals.values.size() * sizeof(float));
    append(&mesh.bounds, sizeof(mesh.bounds));
    return words;
}

TEST(Triangulate, BitsDoNotDependOnThreads) {
    GeometryDescription mesh = MakeGrid(150, [](float s, float t) { return std::sin(9 * s) * t; });
    mesh.subdivisionScheme = "catmullClark";
    auto indices = ToVector(mesh.faceVertexIndices);
    for (std::size_t i = 0; i < indices.size(); i += 4 * 37) {
        indices[i + 1] = indices[i]; // some degenerate corners
        indices[i + 2] = i % 3 == 0 ? -1 : indices[i + 2];
    }
    mesh.faceVertexIndices = indices;
    std::vector<std::vector<std::uint32_t>> results;
    for (const std::size_t numThreads : {1, 2, 7}) {
        const tbb::global_control control(tbb::global_control::max_allowed_parallelism, numThreads);
        results.push_back(Words(*RunTriangulate(mesh).mesh));
    }
    EXPECT_EQ(results[0], results[1]);
    EXPECT_EQ(results[0], results[2]);
}

TEST(Triangulate, GarbageNeverBreaksTheInvariants) {
    std::mt19937 random(23);
    const auto integer = [&](std::int64_t low, std::int64_t high) {
        return static_cast<std::int32_t>(low + std::int64_t(random() % (high - low + 1)));
    };
    const float special[] = {kNan, kInf, -kInf, 0.0F, -0.0F, 1e38F, 1e-45F, 3e18F};
    for (int round = 0; round < 3000; ++round) {
        GeometryDescription mesh;
        std::vector<float> points(random() % 40);
        for (float& p : points) {
            p = random() % 20 == 0 ? special[random() % 8] : float(integer(-3, 3));
        }
        std::vector<std::int32_t> counts(random() % 12);
        for (std::int32_t& count : counts) {
            count = random() % 30 == 0 ? integer(-2147483647, 2147483646) : integer(-1, 9);
        }
        std::vector<std::int32_t> indices(random() % 60);
        for (std::int32_t& index : indices) {
            index = random() % 60 == 0 ? integer(-2147483647, 2147483646) : integer(0, 12);
        }
        const char* schemes[] = {"none", "bilinear", "catmullClark", "loop", ""};
        mesh.subdivisionScheme = schemes[random() % 5];
        mesh.leftHanded = random() % 2 == 0;
        mesh.points = points;
        mesh.faceVertexCounts = counts;
        mesh.faceVertexIndices = indices;
        mesh.holeIndices = std::vector<std::int32_t>(random() % 3, integer(-2, 12));
        mesh.subsets = {{"a", std::vector<std::int32_t>(random() % 4, integer(-2, 12))}};
        Primvar primvar;
        primvar.name = random() % 2 == 0 ? "normals" : "st";
        primvar.interpolation = static_cast<Interpolation>(random() % 6);
        primvar.numComponents = random() % 6;
        primvar.values = std::vector<float>(random() % 50, special[random() % 8]);
        if (random() % 2 == 0) {
            primvar.indices = std::vector<std::int32_t>(random() % 20, integer(-1, 12));
        }
        mesh.primvars = {primvar};

        const auto result = RunTriangulate(mesh).mesh;
        ASSERT_EQ(result->faces.size(), result->triangles.size());
        ASSERT_EQ(result->corners.size(), result->triangles.size());
        std::vector<std::uint32_t> primIds;
        for (std::uint32_t t = 0; t < result->triangles.size(); ++t) {
            ASSERT_GT(glm::length(AreaVector(*result, t)), 0.0);
            ASSERT_LT(result->faces[t], counts.size());
            for (int k = 0; k < 3; ++k) {
                ASSERT_LT(result->triangles[t][k], result->positions.size());
                ASSERT_EQ(std::int32_t(result->triangles[t][k]), indices[result->corners[t][k]]);
            }
            ASSERT_TRUE(t == 0 || result->faces[t] >= result->faces[t - 1]);
            primIds.push_back(t);
        }
        const TriangleMeshSource source(result);
        BuildAttributePage(source.Gather(primIds.data(), primIds.size()));
    }
}

} // namespace
} // namespace hds::test
