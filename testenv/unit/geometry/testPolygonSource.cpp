// SPDX-License-Identifier: Apache-2.0
// A polygon source gives, group by group and in any grouping, the triangles that the whole mesh has
// when it is interpreted at once, with the same values; boxes hold them; bad content is left out.
#include "hdStream/geometry/polygonSource.h"

#include "hdStream/geometry/attributePage.h"
#include "hdStream/geometry/primvars.h"
#include "testenv/unit/geometry/meshFixtures.h"

#include <glm/geometric.hpp>
#include <gtest/gtest.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

namespace hds::test {
namespace {

constexpr float kNan = std::numeric_limits<float>::quiet_NaN();

std::shared_ptr<const ChunkSource> SourceOf(const GeometryDescription& mesh, Warnings& warnings,
                                            const Displacement& displacement = {}) {
    return MakePolygonSource(std::make_shared<GeometryDescription>(mesh), "/World/mesh",
                             displacement, warnings);
}

std::vector<std::uint32_t> AllGroups(const ChunkSource& source) {
    std::vector<std::uint32_t> groups(source.NumPrimitiveGroups());
    std::iota(groups.begin(), groups.end(), 0U);
    return groups;
}

/// Tags random faces, with vertices that make some of them useless.
GeometryDescription MakeHostileMesh(std::mt19937& random) {
    const std::size_t numPoints = 60;
    std::vector<float> points(numPoints * 3);
    std::uniform_real_distribution<float> coordinate(99.0F, 101.0F); // far from 0: an origin
    std::generate(points.begin(), points.end(), [&] { return coordinate(random); });
    points[3 * (random() % numPoints)] = kNan;
    std::vector<std::int32_t> counts;
    std::vector<std::int32_t> indices;
    for (int face = 0; face < 300; ++face) {
        counts.push_back(static_cast<std::int32_t>(random() % 8));
        const bool isFlat = random() % 10 == 0;
        for (std::int32_t i = 0; i < counts.back(); ++i) {
            indices.push_back(isFlat ? 5 : static_cast<std::int32_t>(random() % (numPoints + 1)));
        }
    }
    GeometryDescription mesh;
    mesh.points = std::move(points);
    mesh.faceVertexCounts = std::move(counts);
    mesh.faceVertexIndices = std::move(indices);
    mesh.holeIndices = std::vector<std::int32_t>{3, 17, 299};
    mesh.subdivisionScheme = "none";
    mesh.subsets = {{"a", std::vector<std::int32_t>{1, 2, 5, 8, 200}}};
    AddAllPrimvars(mesh, random);
    return mesh;
}

/// A value of an attribute at corner k of a triangle.
std::vector<float> ValueAt(const GeometryAttribute& attribute, const ChunkGeometry& chunk,
                           std::size_t t, int k) {
    std::size_t element = 0;
    if (attribute.interpolation == Interpolation::Vertex) {
        element = chunk.points[chunk.triangles[t][k]];
    } else if (attribute.interpolation == Interpolation::Uniform) {
        element = chunk.faces[t];
    } else if (attribute.interpolation == Interpolation::FaceVarying) {
        element = chunk.corners[t][k];
    }
    const float* value = ValueOf(attribute, element);
    return {value, value + attribute.numComponents};
}

/// The chunk's triangles are those of the whole mesh from `first` on.
void ExpectEqual(const ChunkGeometry& chunk, const TriangleMesh& whole, std::size_t first) {
    for (std::size_t t = 0; t < chunk.triangles.size(); ++t) {
        const std::size_t w = first + t;
        ASSERT_LT(w, whole.triangles.size());
        ASSERT_EQ(chunk.faces[t], whole.faces[w]);
        ASSERT_EQ(chunk.corners[t], whole.corners[w]);
        EXPECT_EQ(chunk.materialEntries.empty() ? 0U : chunk.materialEntries[t],
                  whole.materialEntries.empty() ? 0U : whole.materialEntries[w]);
        for (int k = 0; k < 3; ++k) {
            const std::uint32_t local = chunk.triangles[t][k];
            ASSERT_EQ(chunk.points[local], whole.triangles[w][k]);
            ASSERT_EQ(chunk.positions[local], whole.positions[whole.triangles[w][k]]);
            for (std::size_t a = 0; a < whole.attributes.size(); ++a) {
                const GeometryAttribute& expected = whole.attributes[a];
                EXPECT_EQ(chunk.attributes[a].name, expected.name);
                std::size_t element = 0;
                switch (expected.interpolation) {
                case Interpolation::Vertex:
                    element = whole.triangles[w][k];
                    break;
                case Interpolation::Uniform:
                    element = whole.faces[w];
                    break;
                case Interpolation::FaceVarying:
                    element = whole.corners[w][k];
                    break;
                default:
                    break;
                }
                const float* value = ValueOf(expected, element);
                EXPECT_EQ(ValueAt(chunk.attributes[a], chunk, t, k),
                          std::vector<float>(value, value + expected.numComponents));
            }
        }
    }
}

TEST(PolygonSource, AnyGroupingGivesTheTrianglesOfTheWholeMesh) {
    std::mt19937 random(5);
    for (int round = 0; round < 20; ++round) {
        const GeometryDescription mesh = MakeHostileMesh(random);
        const Triangulated whole = RunTriangulate(mesh);
        Warnings warnings;
        const auto source = SourceOf(mesh, warnings);
        EXPECT_EQ(source->NumTriangles(), whole.mesh->triangles.size());
        EXPECT_EQ(source->Origin(), whole.mesh->origin);
        EXPECT_EQ(source->AllBounds().min, whole.mesh->bounds.min);
        EXPECT_EQ(source->AllBounds().max, whole.mesh->bounds.max);
        const std::vector<std::uint32_t> groups = AllGroups(*source);
        std::size_t numTriangles = 0;
        std::uint32_t lastPrimId = 0;
        for (std::size_t begin = 0; begin < groups.size();) {
            const std::size_t count =
                std::min<std::size_t>(1 + random() % 9, groups.size() - begin);
            const ChunkGeometry chunk = source->Gather(groups.data() + begin, count);
            ExpectEqual(chunk, *whole.mesh, numTriangles);
            for (const std::uint32_t primId : chunk.primIds) {
                EXPECT_TRUE(numTriangles == 0 || primId > lastPrimId);
                lastPrimId = primId;
                ++numTriangles;
            }
            begin += count;
        }
        EXPECT_EQ(numTriangles, whole.mesh->triangles.size());
        EXPECT_EQ(warnings.Lines(), whole.warnings);
    }
}

TEST(PolygonSource, BoxesHoldTheUnitsAndCountsBoundThem) {
    std::mt19937 random(6);
    const GeometryDescription mesh = MakeHostileMesh(random);
    Warnings warnings;
    const auto source = SourceOf(mesh, warnings);
    std::uint64_t bound = 0;
    for (const std::uint32_t group : AllGroups(*source)) {
        const ChunkGeometry chunk = source->Gather(&group, 1);
        const Bounds box = source->GroupBounds(group);
        bound += source->GroupTriangles(group);
        EXPECT_LE(chunk.triangles.size(), source->GroupTriangles(group));
        EXPECT_EQ(source->GroupTriangles(group) == 0, chunk.triangles.empty());
        for (const glm::vec3& position : chunk.positions) {
            for (int axis = 0; axis < 3; ++axis) {
                EXPECT_GE(position[axis], box.min[axis]);
                EXPECT_LE(position[axis], box.max[axis]);
            }
        }
    }
    EXPECT_GE(bound, source->NumTriangles());
}

TEST(PolygonSource, AFaceOfManyVerticesIsManyUnits) {
    const std::int32_t count = 5000;
    std::vector<float> points;
    std::vector<std::int32_t> indices;
    for (std::int32_t i = 0; i < count; ++i) {
        const double angle = 2.0 * 3.141592653589793 * i / count;
        points.insert(points.end(), {static_cast<float>(std::cos(angle)),
                                     static_cast<float>(std::sin(angle)), 0.0F});
        indices.push_back(i);
    }
    GeometryDescription mesh;
    mesh.points = std::move(points);
    mesh.faceVertexCounts = std::vector<std::int32_t>{count};
    mesh.faceVertexIndices = std::move(indices);
    Warnings warnings;
    const auto source = SourceOf(mesh, warnings);
    const Triangulated whole = RunTriangulate(mesh);
    ASSERT_GT(source->NumPrimitiveGroups(), 10U);
    std::size_t first = 0;
    for (const std::uint32_t group : AllGroups(*source)) {
        EXPECT_LE(source->GroupTriangles(group), 256U);
        const ChunkGeometry chunk = source->Gather(&group, 1);
        ExpectEqual(chunk, *whole.mesh, first);
        first += chunk.triangles.size();
    }
    EXPECT_EQ(first, whole.mesh->triangles.size());
}

TEST(PolygonSource, NormalsAreThoseOfTheWholeMesh) {
    std::mt19937 random(7);
    for (const char* scheme : {"catmullClark", "none"}) {
        GeometryDescription mesh = MakeFlatGrid(12);
        mesh.subdivisionScheme = scheme;
        Primvar normals =
            MakePrimvar(mesh, "normals", Interpolation::FaceVarying, 3, false, random);
        std::vector<float> values(normals.values.begin(), normals.values.end());
        std::fill(values.begin() + 30, values.begin() + 45, 0.0F); // to be repaired
        normals.values = std::move(values);
        mesh.primvars = {normals};
        const Triangulated whole = RunTriangulate(mesh);
        Warnings warnings;
        const auto source = SourceOf(mesh, warnings);
        const std::vector<std::uint32_t> groups = AllGroups(*source);
        // From many threads at once: the first chunk reads all values.
        std::vector<ChunkGeometry> chunks(groups.size());
        tbb::parallel_for(std::size_t{0}, groups.size(),
                          [&](std::size_t i) { chunks[i] = source->Gather(&groups[i], 1); });
        std::size_t w = 0;
        for (const ChunkGeometry& chunk : chunks) {
            for (std::size_t t = 0; t < chunk.triangles.size(); ++t, ++w) {
                for (int k = 0; k < 3; ++k) {
                    const std::size_t element =
                        whole.mesh->normals.interpolation == Interpolation::Vertex
                            ? whole.mesh->triangles[w][k]
                            : whole.mesh->corners[w][k];
                    const float* expected = ValueOf(whole.mesh->normals, element);
                    EXPECT_EQ(ValueAt(chunk.normals, chunk, t, k),
                              std::vector<float>(expected, expected + 3));
                }
            }
        }
        EXPECT_EQ(warnings.Lines(), whole.warnings);
    }
}

// A flat grid moves as a whole along its normal; a primvar makes it a height field.
TEST(PolygonSource, DisplacementMovesPointsAlongTheNormal) {
    for (const bool isLeftHanded : {false, true}) {
        GeometryDescription mesh = MakeFlatGrid(8);
        mesh.leftHanded = isLeftHanded;
        const std::size_t numPoints = mesh.points.size() / 3;
        std::vector<float> heights(numPoints);
        for (std::size_t i = 0; i < numPoints; ++i) {
            heights[i] = 0.25F * static_cast<float>(i % 5) - 0.5F;
        }
        Primvar primvar;
        primvar.name = "height";
        primvar.interpolation = Interpolation::Vertex;
        primvar.values = heights;
        mesh.primvars = {primvar};
        Warnings warnings;
        const auto flat = SourceOf(mesh, warnings);
        const auto displaced = SourceOf(mesh, warnings, {MakePrimvarAmount("height", 0.0)});
        for (const std::uint32_t group : AllGroups(*displaced)) {
            const ChunkGeometry before = flat->Gather(&group, 1);
            const ChunkGeometry after = displaced->Gather(&group, 1);
            const Bounds box = displaced->GroupBounds(group);
            ASSERT_EQ(before.points, after.points);
            const glm::vec3 cross = glm::cross(
                before.positions[before.triangles[0].y] - before.positions[before.triangles[0].x],
                before.positions[before.triangles[0].z] - before.positions[before.triangles[0].x]);
            const glm::vec3 normal = glm::normalize(cross) * (isLeftHanded ? -1.0F : 1.0F);
            for (std::size_t i = 0; i < after.positions.size(); ++i) {
                const glm::vec3 expected = before.positions[i] + normal * heights[before.points[i]];
                EXPECT_LT(glm::length(after.positions[i] - expected), 1e-5F);
                for (int axis = 0; axis < 3; ++axis) {
                    EXPECT_GE(after.positions[i][axis], box.min[axis]);
                    EXPECT_LE(after.positions[i][axis], box.max[axis]);
                }
            }
        }
        EXPECT_TRUE(warnings.Lines().empty());
    }
}

TEST(PolygonSource, AnUnusableMeshHasNothing) {
    GeometryDescription mesh;
    mesh.points = std::vector<float>{kNan, 0, 0, 1, 0, 0, 0, 1, 0};
    mesh.faceVertexCounts = std::vector<std::int32_t>{3};
    mesh.faceVertexIndices = std::vector<std::int32_t>{0, 1, 2};
    Warnings warnings;
    const auto source = SourceOf(mesh, warnings);
    EXPECT_EQ(source->NumTriangles(), 0U);
    EXPECT_EQ(source->NumPrimitiveGroups(), 0U);
    EXPECT_EQ(warnings.Lines().size(), 1U);
    const auto empty = SourceOf({}, warnings);
    EXPECT_EQ(empty->NumPrimitiveGroups(), 0U);
}

} // namespace
} // namespace hds::test
