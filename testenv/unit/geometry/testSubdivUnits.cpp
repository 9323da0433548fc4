// SPDX-License-Identifier: Apache-2.0
// Units of diced surfaces: closed cages stay closed whatever the rates of their edges, any
// partition of the units gives the same bits, and boxes hold what they promise.
#include "hdStream/geometry/subdivDice.h"
#include "testenv/unit/geometry/subdivFixtures.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cstring>
#include <map>
#include <numeric>

namespace hds::test {
namespace {

using Bits = std::array<std::uint32_t, 3>;

Bits BitsOf(const glm::vec3& v) {
    Bits bits;
    std::memcpy(bits.data(), &v.x, sizeof(bits));
    return bits;
}

/// Cages with primvars of all kinds, tags and displacement by round.
GeometryDescription MakeCage(std::mt19937& random, int round) {
    GeometryDescription mesh = MakeRandomCage(random, round % 3 == 2);
    if (round % 4 >= 2) {
        AddRandomTags(mesh, random);
    }
    const auto add = [&](const char* name, Interpolation interpolation, std::size_t count) {
        Primvar primvar;
        primvar.name = name;
        primvar.interpolation = interpolation;
        std::vector<float> values(count);
        for (float& value : values) {
            value = float(random() % 1000) / 1000.0F;
        }
        primvar.values = values;
        mesh.primvars.push_back(primvar);
    };
    add("vertex", Interpolation::Vertex, mesh.points.size() / 3);
    add("varying", Interpolation::Varying, mesh.points.size() / 3);
    add("corner", Interpolation::FaceVarying, mesh.faceVertexIndices.size());
    add("face", Interpolation::Uniform, mesh.faceVertexCounts.size());
    add("all", Interpolation::Constant, 1);
    mesh.subsets = {{"a", std::vector<std::int32_t>{0, 3, 5}}};
    return mesh;
}

Displacement MakeDisplacement(int round) {
    switch (round % 4) {
    case 0:
        return {};
    case 1:
        return {MakeConstantAmount(0.125), MakePrimvarAmount("vertex", 0.0)};
    case 2:
        return {MakePrimvarAmount("corner", 0.0), MakeConstantAmount(-0.25)};
    default:
        return {nullptr, MakePrimvarAmount("face", 0.5)};
    }
}

/// A dice with a rate of its own for every edge.
SubdivDice MakeDice(const GeometryDescription& mesh, std::mt19937& random, std::uint32_t maxLevel,
                    const Displacement& displacement) {
    Warnings warnings;
    SubdivDice dice;
    dice.model =
        SubdivModel::Make(std::make_shared<GeometryDescription>(mesh), "/World/mesh", warnings);
    dice.edgeLevels.resize(std::size_t(dice.model->Level().GetNumEdges()));
    for (std::uint8_t& level : dice.edgeLevels) {
        level = std::uint8_t(random() % (maxLevel + 1));
    }
    std::vector<GeometryAttribute> attributes;
    for (const SubdivPrimvar& primvar : dice.model->Primvars()) {
        attributes.push_back(primvar.attribute);
    }
    dice.entries.assign(mesh.faceVertexCounts.size(), 0);
    for (const std::int32_t face : mesh.subsets[0].faces) {
        dice.entries[std::size_t(face)] = 1;
    }
    dice.displacement.owner = displacement;
    dice.displacement.amounts = BindAmounts(displacement, attributes);
    dice.displacement.range =
        RangeOf(dice.displacement.amounts, attributes, mesh, displacement.empty());
    dice.NumberGroups();
    return dice;
}

std::uint32_t NumPrimitiveGroups(const SubdivDice& dice) {
    return std::uint32_t(dice.groupTriangles.size() - 1);
}

TEST(SubdivGroups, ClosedCagesStayClosedBitForBit) {
    std::mt19937 random(21);
    for (int round = 0; round < 16; ++round) {
        SCOPED_TRACE(round);
        const GeometryDescription mesh = MakeCage(random, round);
        const SubdivDice dice = MakeDice(mesh, random, round < 14 ? 4 : 6, MakeDisplacement(round));
        // One chunk per unit: every edge between units is an edge between chunks.
        std::map<std::pair<Bits, Bits>, int> edges;
        for (std::uint32_t unit = 0; unit < NumPrimitiveGroups(dice); ++unit) {
            const ChunkGeometry chunk = DiceGroups(dice, &unit, 1);
            ASSERT_LE(chunk.triangles.size(),
                      dice.groupTriangles[unit + 1] - dice.groupTriangles[unit]);
            for (const glm::uvec3& t : chunk.triangles) {
                for (int k = 0; k < 3; ++k) {
                    ++edges[{BitsOf(chunk.positions[t[k]]),
                             BitsOf(chunk.positions[t[(k + 1) % 3]])}];
                }
            }
        }
        ASSERT_GT(edges.size(), 100U);
        for (const auto& [edge, count] : edges) {
            ASSERT_EQ(count, 1);
            ASSERT_EQ(edges.count({edge.second, edge.first}), 1U);
        }
    }
}

/// All that a chunk says of a triangle.
std::vector<float> Describe(const ChunkGeometry& chunk, std::size_t triangle) {
    std::vector<float> values = {float(chunk.faces[triangle]),
                                 float(chunk.materialEntries[triangle])};
    const auto add = [&](const GeometryAttribute& attribute) {
        for (int k = 0; k < 3; ++k) {
            const glm::uvec3 t = chunk.triangles[triangle];
            std::size_t element = 0;
            switch (attribute.interpolation) {
            case Interpolation::Vertex:
                element = chunk.points[t[k]];
                break;
            case Interpolation::FaceVarying:
                element = chunk.corners[triangle][k];
                break;
            case Interpolation::Uniform:
                element = chunk.faces[triangle];
                break;
            default:
                break;
            }
            if (!attribute.indices.empty()) {
                element = std::size_t(attribute.indices[element]);
            }
            for (std::uint32_t c = 0; c < attribute.numComponents; ++c) {
                values.push_back(attribute.values[element * attribute.numComponents + c]);
            }
        }
    };
    for (int k = 0; k < 3; ++k) {
        const glm::vec3 p = chunk.positions[chunk.triangles[triangle][k]];
        values.insert(values.end(), {p.x, p.y, p.z});
    }
    add(chunk.normals);
    for (const GeometryAttribute& attribute : chunk.attributes) {
        add(attribute);
    }
    return values;
}

TEST(SubdivGroups, AnyPartitionGivesTheSameBits) {
    std::mt19937 random(22);
    for (int round = 0; round < 12; ++round) {
        SCOPED_TRACE(round);
        const GeometryDescription mesh = MakeCage(random, round);
        const SubdivDice dice = MakeDice(mesh, random, 5, MakeDisplacement(round));
        std::vector<std::uint32_t> order(NumPrimitiveGroups(dice));
        std::iota(order.begin(), order.end(), 0U);
        const ChunkGeometry whole = DiceGroups(dice, order.data(), order.size());
        std::map<std::uint32_t, std::vector<float>> expected;
        for (std::size_t t = 0; t < whole.triangles.size(); ++t) {
            ASSERT_TRUE(expected.emplace(whole.primIds[t], Describe(whole, t)).second);
            ASSERT_TRUE(t == 0 || (whole.primIds[t] > whole.primIds[t - 1] &&
                                   whole.faces[t] >= whole.faces[t - 1]));
        }
        std::shuffle(order.begin(), order.end(), random);
        std::size_t numSeen = 0;
        for (std::size_t begin = 0; begin < order.size();) {
            const std::size_t count = std::min<std::size_t>(1 + random() % 7, order.size() - begin);
            const ChunkGeometry part = DiceGroups(dice, order.data() + begin, count);
            for (std::size_t t = 0; t < part.triangles.size(); ++t) {
                ASSERT_EQ(expected.at(part.primIds[t]), Describe(part, t));
                ++numSeen;
            }
            begin += count;
        }
        EXPECT_EQ(numSeen, whole.triangles.size());
    }
}

TEST(SubdivGroups, BoxesHoldTheTriangles) {
    std::mt19937 random(23);
    for (int round = 0; round < 24; ++round) {
        SCOPED_TRACE(round);
        GeometryDescription mesh = MakeCage(random, round);
        std::vector<float> moved(mesh.points.begin(), mesh.points.end());
        for (float& p : moved) {
            p += round % 5 == 4 ? 4096.0F : 0.0F;
        }
        mesh.points = moved;
        DicingOptions options;
        options.isAdaptive = round % 2 == 0;
        options.level = 5;
        options.view.imageSize = {400.0, 300.0};
        options.view.cameraFromObject[3] = glm::dvec4(0.5, 0.25, -3.0, 1.0);
        Warnings warnings;
        const auto source =
            MakeSubdivSource(std::make_shared<GeometryDescription>(mesh), "/World/mesh", options,
                             MakeDisplacement(round), warnings);
        ASSERT_TRUE(source);
        std::uint64_t sum = 0;
        for (std::uint32_t unit = 0; unit < source->NumPrimitiveGroups(); ++unit) {
            const ChunkGeometry chunk = source->Gather(&unit, 1);
            const Bounds box = source->GroupBounds(unit);
            sum += source->GroupTriangles(unit);
            for (const glm::vec3& p : chunk.positions) {
                for (int axis = 0; axis < 3; ++axis) {
                    ASSERT_GE(p[axis], box.min[axis]);
                    ASSERT_LE(p[axis], box.max[axis]);
                    ASSERT_GE(p[axis], source->AllBounds().min[axis]);
                    ASSERT_LE(p[axis], source->AllBounds().max[axis]);
                }
            }
        }
        EXPECT_EQ(sum, source->NumTriangles());
        std::vector<std::uint32_t> all(source->NumPrimitiveGroups());
        std::iota(all.begin(), all.end(), 0U);
        EXPECT_LE(source->Gather(all.data(), all.size()).positions.size(), source->NumVertices());
    }
}

} // namespace
} // namespace hds::test
