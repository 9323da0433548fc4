// SPDX-License-Identifier: Apache-2.0
// Shading normals: which are used, where they point, and that every one that is read is a
// direction.
#include "hdStream/geometry/attributePage.h"
#include "hdStream/geometry/triangleMeshSource.h"
#include "testenv/unit/geometry/meshFixtures.h"

#include "kernels/shared/geometry.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>

namespace hds::test {
namespace {

constexpr float kNan = std::numeric_limits<float>::quiet_NaN();

Primvar MakeNormals(Interpolation interpolation, std::vector<float> values,
                    std::vector<std::int32_t> indices = {}) {
    Primvar primvar;
    primvar.name = "normals";
    primvar.interpolation = interpolation;
    primvar.numComponents = 3;
    primvar.values = std::move(values);
    primvar.indices = std::move(indices);
    return primvar;
}

/// A closed polyhedron inscribed in a sphere about `centre`: latitude bands of quads and triangles.
GeometryDescription MakeInscribed(glm::vec3 centre, double radius, int numSides, int numBands) {
    std::vector<glm::vec3> points = {centre - glm::vec3(0, 0, radius),
                                     centre + glm::vec3(0, 0, radius)};
    for (int band = 1; band < numBands; ++band) {
        const double latitude = M_PI * (double(band) / numBands - 0.5);
        for (int i = 0; i < numSides; ++i) {
            const double angle = 2.0 * M_PI * i / numSides;
            points.push_back(centre + glm::vec3(radius * std::cos(latitude) * std::cos(angle),
                                                radius * std::cos(latitude) * std::sin(angle),
                                                radius * std::sin(latitude)));
        }
    }
    std::vector<std::int32_t> counts;
    std::vector<std::int32_t> indices;
    const auto at = [&](int band, int i) { return 2 + (band - 1) * numSides + i % numSides; };
    for (int i = 0; i < numSides; ++i) {
        counts.push_back(3);
        indices.insert(indices.end(), {at(1, i + 1), at(1, i), 0});
        for (int band = 1; band + 1 < numBands; ++band) {
            counts.push_back(4);
            indices.insert(indices.end(),
                           {at(band, i), at(band, i + 1), at(band + 1, i + 1), at(band + 1, i)});
        }
        counts.push_back(3);
        indices.insert(indices.end(), {at(numBands - 1, i), at(numBands - 1, i + 1), 1});
    }
    return MakeMesh(points, counts, indices);
}

glm::dvec3 NormalAt(const TriangleMesh& mesh, std::size_t element) {
    const std::size_t index =
        mesh.normals.indices.empty() ? element : std::size_t(mesh.normals.indices[element]);
    const float* n = mesh.normals.values.data() + 3 * index;
    return {n[0], n[1], n[2]};
}

TEST(Normals, PolygonalMeshesAreFlat) {
    for (const char* scheme : {"none", "bilinear"}) {
        GeometryDescription mesh = MakeInscribed(glm::vec3(0), 1.0, 8, 6);
        mesh.subdivisionScheme = scheme;
        EXPECT_TRUE(RunTriangulate(mesh).mesh->normals.values.empty());
    }
}

TEST(Normals, SmoothNormalsAreRadialOnASphere) {
    // Max 1999: exact for points on a sphere. The tolerance is that of positions rounded to float,
    // 2^-24 relative to edges of about radius / 8, over each normal's few corners.
    for (const glm::vec3& centre : {glm::vec3(0), glm::vec3(3, -7, 200)}) {
        for (const bool isLeftHanded : {false, true}) {
            GeometryDescription description = MakeInscribed(centre, 5.0, 11, 9);
            description.subdivisionScheme = "catmullClark";
            description.leftHanded = isLeftHanded;
            const auto mesh = RunTriangulate(description).mesh;
            ASSERT_EQ(mesh->normals.interpolation, Interpolation::Vertex);
            const double scale = glm::length(glm::dvec3(centre)) / 5.0 + 1.0;
            for (std::size_t i = 0; i < mesh->positions.size(); ++i) {
                const glm::dvec3 radial = glm::normalize(glm::dvec3(mesh->positions[i]) +
                                                         mesh->origin - glm::dvec3(centre));
                const glm::dvec3 expected = isLeftHanded ? -radial : radial;
                EXPECT_LT(glm::length(NormalAt(*mesh, i) - expected), 1e-6 * scale);
            }
        }
    }
}

TEST(Normals, SubdivisionSurfacesIgnoreAuthoredNormals) {
    GeometryDescription description = MakeFlatGrid(2);
    description.primvars = {MakeNormals(Interpolation::Constant, {1, 0, 0})};
    for (const char* scheme : {"catmullClark", "loop"}) {
        description.subdivisionScheme = scheme;
        const auto mesh = RunTriangulate(description).mesh;
        EXPECT_EQ(NormalAt(*mesh, 4), glm::dvec3(0, 0, 1));
    }
    description.subdivisionScheme = "bilinear"; // flat, as its limit surface is
    EXPECT_TRUE(RunTriangulate(description).mesh->normals.values.empty());
    description.subdivisionScheme = "none";
    const auto mesh = RunTriangulate(description).mesh;
    EXPECT_EQ(mesh->normals.interpolation, Interpolation::Constant);
    EXPECT_EQ(NormalAt(*mesh, 0), glm::dvec3(1, 0, 0));
    EXPECT_TRUE(mesh->attributes.empty()); // normals are no user primvar
}

TEST(Normals, AuthoredNormalsOfLeftHandedMeshesAreKept) {
    GeometryDescription description = MakeFlatGrid(1);
    description.leftHanded = true;
    description.primvars = {MakeNormals(Interpolation::Uniform, {0, 0, -1})};
    EXPECT_EQ(NormalAt(*RunTriangulate(description).mesh, 0), glm::dvec3(0, 0, -1));
    description.primvars = {};
    description.subdivisionScheme = "loop";
    EXPECT_EQ(NormalAt(*RunTriangulate(description).mesh, 0), glm::dvec3(0, 0, -1));
}

TEST(Normals, FoldedSheetsTakeTheFirstFace) {
    // Two triangles back to back: the sum at each point is zero.
    GeometryDescription description =
        MakeMesh({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}, {3, 3}, {0, 1, 2, 0, 2, 1});
    description.subdivisionScheme = "loop";
    const auto mesh = RunTriangulate(description).mesh;
    for (std::size_t i = 0; i < 3; ++i) {
        EXPECT_EQ(NormalAt(*mesh, i), glm::dvec3(0, 0, 1));
    }
}

/// Reads HDS_SLOT_NORMAL of a page at corner k of a triangle, per the layout's documentation.
glm::dvec3 PageNormal(const std::vector<std::uint8_t>& bytes, const ChunkGeometry& chunk,
                      std::size_t triangle, int k) {
    const auto* words = reinterpret_cast<const std::uint32_t*>(bytes.data());
    const std::uint32_t word = words[HDS_SLOT_NORMAL];
    const std::uint32_t kind = word >> 29;
    const std::size_t index = kind == HDS_ATTR_TRIANGLE ? triangle
                              : kind == HDS_ATTR_VERTEX ? chunk.triangles[triangle][k]
                              : kind == HDS_ATTR_CORNER ? 3 * triangle + std::size_t(k)
                                                        : 0;
    float n[3];
    std::memcpy(n, words + std::size_t(word & 0x3ffffff) * 4 + 3 * index, sizeof(n));
    return {n[0], n[1], n[2]};
}

TEST(Normals, UnusableOnesBecomeFaceNormalsAndPagesHoldUnitVectors) {
    // A ridge: face 0 rises along x, face 1 falls. Points 2 and 3 are on the ridge.
    const std::vector<glm::vec3> points = {{0, 0, 0}, {0, 1, 0}, {1, 0, 1},
                                           {1, 1, 1}, {2, 0, 0}, {2, 1, 0}};
    const double s = std::sqrt(0.5);
    const glm::dvec3 rising(-s, 0, s);
    const glm::dvec3 falling(s, 0, s);
    struct Case {
        Interpolation interpolation;
        std::vector<float> values;
        int numReplaced;
    };
    const Case cases[] = {
        {Interpolation::Vertex,
         {0, 0, 9, 0, 0, 0, kNan, 0, 1, 0, 0, 9, 0, 0, 0, 0, 0, INFINITY},
         4},
        {Interpolation::Uniform, {0, 0, 0, 0, 0, 9}, 1},
        {Interpolation::FaceVarying,
         {0, 0, 0, 0, 0, 9, 0, 0, 9, 0, 0, 9, 0, kNan, 0, 0, 0, 9, 0, 0, 0, 0, 0, 9},
         3},
    };
    for (const Case& c : cases) {
        GeometryDescription description = MakeMesh(points, {4, 4}, {0, 2, 3, 1, 2, 4, 5, 3});
        description.primvars = {MakeNormals(c.interpolation, c.values)};
        const Triangulated run = RunTriangulate(description);
        const std::string count = std::to_string(c.numReplaced);
        EXPECT_TRUE(std::find(run.warnings.begin(), run.warnings.end(),
                              "/World/mesh: " + count +
                                  " normals replaced by face normals: zero or not finite") !=
                    run.warnings.end())
            << count;
        const std::uint32_t primIds[] = {3, 2, 1, 0};
        const ChunkGeometry chunk = TriangleMeshSource(run.mesh).Gather(primIds, 4);
        const auto page = BuildAttributePage(chunk);
        for (std::size_t t = 0; t < 4; ++t) {
            const std::uint32_t face = run.mesh->faces[primIds[t]];
            for (int k = 0; k < 3; ++k) {
                const std::uint32_t point = chunk.points[chunk.triangles[t][k]];
                const std::size_t element = c.interpolation == Interpolation::Uniform ? face
                                            : c.interpolation == Interpolation::Vertex
                                                ? point
                                                : FindCorner(description, face, points[point]);
                const float* authored = c.values.data() + 3 * element;
                // The ridge belongs to face 0, which comes first.
                const bool isRising =
                    c.interpolation == Interpolation::Vertex ? point < 4 : face == 0;
                const glm::dvec3 expected = authored[2] == 9.0F ? glm::dvec3(0, 0, 1)
                                            : isRising          ? rising
                                                                : falling;
                EXPECT_LT(glm::length(PageNormal(page, chunk, t, k) - expected), 1e-7)
                    << "triangle " << t << " corner " << k;
            }
        }
    }
}

TEST(Normals, WrongAuthoredNormalsAreNamedAndIgnored) {
    const auto check = [](Primvar primvar, const std::string& expected) {
        GeometryDescription description = MakeFlatGrid(2);
        description.primvars = {std::move(primvar)};
        const Triangulated run = RunTriangulate(description);
        EXPECT_EQ(run.warnings, std::vector<std::string>{"/World/mesh: " + expected});
        EXPECT_TRUE(run.mesh->normals.values.empty());
    };
    check(MakeNormals(Interpolation::Vertex, std::vector<float>(24, 1.0F)),
          "primvar \"normals\" ignored: vertex needs 9 values, has 8");
    check(MakeNormals(Interpolation::Constant, {0, 0, 0}),
          "primvar \"normals\" ignored: zero or not finite");
    Primvar two = MakeNormals(Interpolation::Constant, {1, 0});
    two.numComponents = 2;
    check(two, "primvar \"normals\" ignored: 2 components, 3 are needed");
}

} // namespace
} // namespace hds::test
