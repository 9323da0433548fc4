// SPDX-License-Identifier: Apache-2.0
// Chunks hold the mesh's triangles, and attribute pages the authored values: read back with a
// reader written from the page's documented layout, against one written from UsdGeom's text.
#include "testenv/unit/geometry/meshFixtures.h"

#include "hdStream/geometry/attributePage.h"
#include "hdStream/geometry/triangleMeshSource.h"
#include "kernels/shared/geometry.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <numeric>
#include <set>

namespace hds::test {
namespace {

constexpr float kNan = std::numeric_limits<float>::quiet_NaN();

/// Reads kernels/shared/geometry.h's layout.
class PageReader {
public:
    explicit PageReader(const std::vector<std::uint8_t>& bytes) : _words(bytes.size() / 4) {
        std::memcpy(_words.data(), bytes.data(), bytes.size());
    }
    std::uint32_t Kind(std::uint32_t slot) const { return _words.at(slot) >> 29; }
    std::uint32_t NumComponents(std::uint32_t slot) const { return (_words.at(slot) >> 26) & 7; }
    std::uint32_t Word(std::uint32_t slot, std::size_t index) const {
        return _words.at(std::size_t(_words.at(slot) & 0x3ffffff) * 4 + index);
    }
    /// Component c at corner k of a chunk's triangle.
    float Value(std::uint32_t slot, const ChunkGeometry& chunk, std::size_t triangle, int k,
                std::uint32_t c) const {
        std::size_t index = 0;
        switch (Kind(slot)) {
        case HDS_ATTR_TRIANGLE:
            index = triangle;
            break;
        case HDS_ATTR_VERTEX:
            index = chunk.triangles[triangle][k];
            break;
        case HDS_ATTR_CORNER:
            index = 3 * triangle + std::size_t(k);
            break;
        default:
            break;
        }
        const std::uint32_t word = Word(slot, index * NumComponents(slot) + c);
        float value = 0.0F;
        std::memcpy(&value, &word, sizeof(value));
        return value;
    }

private:
    std::vector<std::uint32_t> _words;
};

/// The triangles [begin, end) of a mesh, backwards, so that the order differs from the mesh's.
ChunkGeometry GatherRange(const std::shared_ptr<const TriangleMesh>& mesh, std::uint32_t begin,
                          std::uint32_t end) {
    std::vector<std::uint32_t> primIds(end - begin);
    std::iota(primIds.rbegin(), primIds.rend(), begin);
    return TriangleMeshSource(mesh).Gather(primIds.data(), primIds.size());
}

TEST(ChunkSource, GatherKeepsTrianglesAndNumbersVerticesOnce) {
    const auto mesh = RunTriangulate(MakeFlatGrid(20)).mesh;
    const ChunkGeometry chunk = GatherRange(mesh, 100, 333);
    ASSERT_EQ(chunk.primIds.size(), 233U);
    EXPECT_EQ(chunk.primIds.front(), 332U);
    ASSERT_EQ(chunk.positions.size(), chunk.points.size());
    EXPECT_EQ(std::set<std::uint32_t>(chunk.points.begin(), chunk.points.end()).size(),
              chunk.points.size());
    std::uint32_t numSeen = 0;
    for (std::size_t t = 0; t < chunk.triangles.size(); ++t) {
        for (int k = 0; k < 3; ++k) {
            const std::uint32_t local = chunk.triangles[t][k];
            ASSERT_LE(local, numSeen); // order of first use
            numSeen = std::max(numSeen, local + 1);
            EXPECT_EQ(chunk.points[local], mesh->triangles[chunk.primIds[t]][k]);
            EXPECT_EQ(chunk.positions[local], mesh->positions[chunk.points[local]]);
        }
    }
    EXPECT_EQ(numSeen, chunk.positions.size());
    EXPECT_TRUE(TriangleMeshSource(mesh).Gather(nullptr, 0).triangles.empty());
}

TEST(AttributePage, EveryInterpolationReadsTheAuthoredValues) {
    std::mt19937 random(17);
    GeometryDescription description = MakeMixedMesh();
    AddAllPrimvars(description, random);
    const Triangulated run = RunTriangulate(description);
    const auto& mesh = run.mesh;
    // Indexed constants are given more than one value by the fixture's index list of one entry.
    EXPECT_TRUE(run.warnings.empty());
    ASSERT_EQ(mesh->attributes.size(), description.primvars.size());
    const auto numTriangles = static_cast<std::uint32_t>(mesh->triangles.size());
    ASSERT_EQ(numTriangles, 9U);
    for (const std::uint32_t begin : {0U, 3U}) {
        const ChunkGeometry chunk = GatherRange(mesh, begin, numTriangles);
        const auto bytes = BuildAttributePage(chunk);
        EXPECT_EQ(bytes.size() % 16, 0U);
        const PageReader page(bytes);
        for (std::size_t t = 0; t < chunk.triangles.size(); ++t) {
            const std::uint32_t face = page.Word(HDS_SLOT_FACE, t);
            for (int k = 0; k < 3; ++k) {
                const std::size_t corner =
                    FindCorner(description, face, chunk.positions[chunk.triangles[t][k]]);
                ASSERT_LT(corner, description.faceVertexIndices.size());
                for (std::size_t i = 0; i < description.primvars.size(); ++i) {
                    const Primvar& primvar = description.primvars[i];
                    const auto slot = static_cast<std::uint32_t>(HDS_SLOT_USER + i);
                    ASSERT_EQ(page.NumComponents(slot), primvar.numComponents);
                    for (std::uint32_t c = 0; c < primvar.numComponents; ++c) {
                        EXPECT_EQ(page.Value(slot, chunk, t, k, c),
                                  AuthoredValue(description, primvar, face, corner, c));
                    }
                }
            }
        }
    }
}

TEST(AttributePage, SlotsFollowTheOrderOfNames) {
    GeometryDescription description = MakeFlatGrid(1);
    const auto constant = [](const std::string& name, float value) {
        Primvar primvar;
        primvar.name = name;
        primvar.values = std::vector<float>{value};
        return primvar;
    };
    description.primvars = {constant("st", 3), constant("displayColor", 2), constant("Ab", 1),
                            constant("st", 4)};
    const Triangulated run = RunTriangulate(description);
    EXPECT_EQ(run.warnings,
              std::vector<std::string>{"/World/mesh: 1 primvars ignored: repeated name"});
    const ChunkGeometry chunk = GatherRange(run.mesh, 0, 2);
    const PageReader page(BuildAttributePage(chunk));
    for (std::uint32_t i = 0; i < 3; ++i) {
        EXPECT_EQ(page.Kind(HDS_SLOT_USER + i), HDS_ATTR_CONSTANT);
        EXPECT_EQ(page.Value(HDS_SLOT_USER + i, chunk, 0, 0, 0), float(i + 1));
    }
    EXPECT_EQ(page.Kind(HDS_SLOT_NORMAL), HDS_ATTR_ABSENT);
    EXPECT_EQ(page.Kind(HDS_SLOT_MATERIAL), HDS_ATTR_ABSENT);
}

TEST(AttributePage, MaterialsAreAbsentConstantOrPerTriangle) {
    GeometryDescription description = MakeFlatGrid(4);
    description.subsets = {{"a", std::vector<std::int32_t>{4, 5, 6, 7}},
                           {"b", std::vector<std::int32_t>{10}}};
    const auto mesh = RunTriangulate(description).mesh;
    const auto pageOf = [&](std::uint32_t begin, std::uint32_t end) {
        return PageReader(BuildAttributePage(GatherRange(mesh, begin, end)));
    };
    EXPECT_EQ(pageOf(0, 8).Kind(HDS_SLOT_MATERIAL), HDS_ATTR_ABSENT);
    EXPECT_EQ(pageOf(8, 16).Kind(HDS_SLOT_MATERIAL), HDS_ATTR_CONSTANT);
    EXPECT_EQ(pageOf(8, 16).Word(HDS_SLOT_MATERIAL, 0), 1U);
    const PageReader mixed = pageOf(14, 24);
    ASSERT_EQ(mixed.Kind(HDS_SLOT_MATERIAL), HDS_ATTR_TRIANGLE);
    for (std::uint32_t i = 0; i < 10; ++i) {
        const std::uint32_t face = (23 - i) / 2;
        EXPECT_EQ(mixed.Word(HDS_SLOT_FACE, i), face);
        EXPECT_EQ(mixed.Word(HDS_SLOT_MATERIAL, i), face == 7 ? 1U : (face == 10 ? 2U : 0U));
    }
}

TEST(AttributePage, UnusableValuesReadAsZero) {
    GeometryDescription description = MakeFlatGrid(1);
    Primvar primvar;
    primvar.name = "displayColor";
    primvar.interpolation = Interpolation::Vertex;
    primvar.values = std::vector<float>{1, kNan, 3, -INFINITY};
    description.primvars = {primvar};
    const Triangulated run = RunTriangulate(description);
    EXPECT_EQ(run.warnings,
              std::vector<std::string>{"/World/mesh: primvar \"displayColor\": 2 floats "
                                       "are not finite, read as 0"});
    const ChunkGeometry chunk = GatherRange(run.mesh, 0, 2);
    const PageReader page(BuildAttributePage(chunk));
    const float expected[] = {1, 0, 3, 0};
    for (std::size_t t = 0; t < 2; ++t) {
        for (int k = 0; k < 3; ++k) {
            EXPECT_EQ(page.Value(HDS_SLOT_USER, chunk, t, k, 0),
                      expected[chunk.points[chunk.triangles[t][k]]]);
        }
    }
}

TEST(AttributePage, EstimateBoundsBothPages) {
    std::mt19937 random(29);
    GeometryDescription description = MakeMixedMesh();
    AddAllPrimvars(description, random);
    description.subdivisionScheme = "catmullClark"; // computed vertex normals
    description.subsets = {{"a", std::vector<std::int32_t>{0}}};
    const auto mesh = RunTriangulate(description).mesh;
    const std::size_t estimate = TriangleMeshSource(mesh).BoundBytes().Both();
    const std::size_t headerAndPadding = (HDS_SLOT_USER + mesh->attributes.size()) * (4 + 16);
    for (std::uint32_t t = 0; t < mesh->triangles.size(); ++t) {
        // A chunk of one triangle shares no vertices: the worst case.
        const ChunkGeometry chunk = GatherRange(mesh, t, t + 1);
        const std::size_t bytes = BuildAttributePage(chunk).size() +
                                  chunk.positions.size() * sizeof(glm::vec3) +
                                  sizeof(shared::HdsTriangle) + sizeof(std::uint32_t);
        EXPECT_LE(bytes, estimate + headerAndPadding);
    }
}

TEST(Primvars, WrongContentIsNamedAndIgnored) {
    const auto warningOf = [](Interpolation interpolation, std::uint32_t numComponents,
                              std::vector<float> values, std::vector<std::int32_t> indices) {
        GeometryDescription description = MakeFlatGrid(2); // 9 points, 4 faces, 16 corners
        Primvar primvar;
        primvar.name = "st";
        primvar.interpolation = interpolation;
        primvar.numComponents = numComponents;
        primvar.values = std::move(values);
        primvar.indices = std::move(indices);
        description.primvars = {primvar};
        const Triangulated run = RunTriangulate(description);
        EXPECT_EQ(run.mesh->attributes.size(), run.warnings.empty() ? 1U : 0U);
        const std::string prefix = "/World/mesh: primvar \"st\" ignored: ";
        return run.warnings.empty() ? "" : run.warnings[0].substr(prefix.size());
    };
    using F = std::vector<float>;
    using I = std::vector<std::int32_t>;
    EXPECT_EQ(warningOf(Interpolation::Vertex, 2, F(18), I()), "");
    EXPECT_EQ(warningOf(Interpolation::Vertex, 2, F(2), I(9, 0)), "");
    EXPECT_EQ(warningOf(Interpolation::Vertex, 2, F(16), I()), "vertex needs 9 values, has 8");
    EXPECT_EQ(warningOf(Interpolation::Varying, 1, F(10), I()), "varying needs 9 values, has 10");
    EXPECT_EQ(warningOf(Interpolation::Uniform, 3, F(9), I()), "uniform needs 4 values, has 3");
    EXPECT_EQ(warningOf(Interpolation::FaceVarying, 1, F(9), I()),
              "faceVarying needs 16 values, has 9");
    EXPECT_EQ(warningOf(Interpolation::FaceVarying, 1, F(9), I(15, 0)),
              "faceVarying needs 16 values, has 15");
    EXPECT_EQ(warningOf(Interpolation::FaceVarying, 1, F(9), I(16, 9)), "16 indices out of range");
    EXPECT_EQ(warningOf(Interpolation::Uniform, 1, F(4), I{0, 1, -1, 3}), "1 indices out of range");
    EXPECT_EQ(warningOf(Interpolation::Constant, 3, F(), I()), "constant needs 1 values, has 0");
    EXPECT_EQ(warningOf(Interpolation::Vertex, 2, F(17), I()), "17 floats are not a multiple of 2");
    EXPECT_EQ(warningOf(Interpolation::Constant, 5, F(5), I()),
              "5 components, 1 to 4 are supported");
    EXPECT_EQ(warningOf(Interpolation::Constant, 0, F(5), I()),
              "0 components, 1 to 4 are supported");
}

TEST(Primvars, LongConstantsGiveTheirFirstValue) {
    for (const bool isIndexed : {false, true}) {
        GeometryDescription description = MakeFlatGrid(1);
        Primvar primvar;
        primvar.name = "displayColor";
        primvar.numComponents = 3;
        primvar.values = std::vector<float>{1, 2, 3, 4, 5, 6};
        if (isIndexed) {
            primvar.indices = std::vector<std::int32_t>{1, 0};
        }
        description.primvars = {primvar};
        const Triangulated run = RunTriangulate(description);
        EXPECT_EQ(run.warnings,
                  std::vector<std::string>{"/World/mesh: primvar \"displayColor\": constant with 2 "
                                           "values, the first is used"});
        const ChunkGeometry chunk = GatherRange(run.mesh, 0, 2);
        const PageReader page(BuildAttributePage(chunk));
        for (std::uint32_t c = 0; c < 3; ++c) {
            EXPECT_EQ(page.Value(HDS_SLOT_USER, chunk, 0, 0, c), float(c + (isIndexed ? 4 : 1)));
        }
    }
}

TEST(Primvars, ArraysAreSharedNotCopied) {
    std::mt19937 random(31);
    GeometryDescription description = MakeFlatGrid(3);
    for (const bool isIndexed : {false, true}) {
        description.primvars = {
            MakePrimvar(description, "st", Interpolation::FaceVarying, 2, isIndexed, random)};
        const auto mesh = RunTriangulate(description).mesh;
        EXPECT_EQ(mesh->attributes.at(0).values.data(), description.primvars[0].values.data());
        EXPECT_EQ(mesh->attributes.at(0).indices.data(), description.primvars[0].indices.data());
    }
}

} // namespace
} // namespace hds::test
