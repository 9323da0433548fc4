// SPDX-License-Identifier: Apache-2.0
// The attribute reader on the device gives the authored values, interpolated: against a reader in
// double that follows UsdGeom's text and finds face-vertices by position.
#include "hdStream/geometry/attributePage.h"
#include "hdStream/geometry/triangleMeshSource.h"
#include "testenv/support/deviceFixture.h"
#include "testenv/unit/geometry/meshFixtures.h"

#include "kernels/shared/geometry.h"

#include <glm/vec4.hpp>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <numeric>

namespace hds::test {
namespace {

const char* const kSource = R"(
#include "shading/attributes.clh"

kernel void read_all(global const uint* page, global const uint4* triangles,
                     global const float4* queries, uint numQueries, uint numSlots,
                     global float4* values, global uint2* integers) {
    uint id = get_global_id(0);
    if (id >= numQueries) {
        return;
    }
    float4 query = queries[id];
    const uint triangle = (uint)query.z;
    HdsAttributePoint point =
        attributes_atTriangle(triangle, triangles[triangle].xyz, query.xy);
    for (uint slot = 2u; slot < numSlots; ++slot) {
        values[id * numSlots + slot] = attributes_read(page, slot, &point, (float4)(-1.0f));
    }
    integers[id] = (uint2)(attributes_readInteger(page, HDS_SLOT_FACE, point.triangle, 77u),
                           attributes_readInteger(page, HDS_SLOT_MATERIAL, point.triangle, 99u));
}
)";

struct Query {
    float u, v, triangle, pad;
};

class Attributes : public DeviceFixture {
protected:
    /// Reads every slot of a mesh's page at random points of all its triangles.
    void Read(const GeometryDescription& description) {
        const Triangulated run = RunTriangulate(description);
        mesh = run.mesh;
        std::vector<std::uint32_t> primIds(mesh->triangles.size());
        std::iota(primIds.rbegin(), primIds.rend(), 0);
        chunk = TriangleMeshSource(mesh).Gather(primIds.data(), primIds.size());
        const auto page = BuildAttributePage(chunk);
        std::vector<glm::uvec4> triangles;
        std::mt19937 random(3);
        for (std::size_t t = 0; t < chunk.triangles.size(); ++t) {
            const glm::uvec3 v = chunk.triangles[t];
            triangles.emplace_back(v, 0U);
            for (int i = 0; i < 40; ++i) {
                float u = float(random() % 4097) / 4096.0F;
                float w = float(random() % 4097) / 4096.0F;
                if (u + w > 1.0F) {
                    u = 1.0F - u;
                    w = 1.0F - w;
                }
                queries.push_back({u, w, float(t), 0.0F});
            }
        }
        numSlots = static_cast<std::uint32_t>(HDS_SLOT_USER + mesh->attributes.size());
        Buffer pageBuffer = Upload(page);
        Buffer triangleBuffer = Upload(triangles);
        Buffer queryBuffer = Upload(queries);
        Buffer valueBuffer = Allocate(queries.size() * numSlots * 4 * sizeof(float));
        Buffer integerBuffer = Allocate(queries.size() * 2 * sizeof(std::uint32_t));
        const auto program = Build(kSource);
        Kernel kernel = program->GetKernel("read_all");
        kernel.Launch(queries.size(), pageBuffer, triangleBuffer, queryBuffer,
                      static_cast<std::uint32_t>(queries.size()), numSlots, valueBuffer,
                      integerBuffer);
        values = Download<float>(valueBuffer, queries.size() * numSlots * 4);
        integers = Download<std::uint32_t>(integerBuffer, queries.size() * 2);
    }

    float Value(std::size_t query, std::uint32_t slot, std::uint32_t c) const {
        return values[(query * numSlots + slot) * 4 + c];
    }

    std::shared_ptr<const TriangleMesh> mesh;
    ChunkGeometry chunk;
    std::vector<Query> queries;
    std::uint32_t numSlots = 0;
    std::vector<float> values;
    std::vector<std::uint32_t> integers;
};

/// As MakeMixedMesh's, with subsets.
GeometryDescription MakeDeviceMesh() {
    GeometryDescription mesh = MakeMixedMesh();
    mesh.subsets = {{"a", std::vector<std::int32_t>{1, 3}}, {"b", std::vector<std::int32_t>{4}}};
    return mesh;
}

TEST_F(Attributes, EveryInterpolationMatchesTheReference) {
    std::mt19937 random(41);
    GeometryDescription description = MakeDeviceMesh();
    AddAllPrimvars(description, random);
    Read(description);
    ASSERT_EQ(mesh->attributes.size(), description.primvars.size());
    for (std::size_t q = 0; q < queries.size(); ++q) {
        const auto t = static_cast<std::size_t>(queries[q].triangle);
        const std::uint32_t face = integers[2 * q];
        std::size_t corners[3];
        for (int k = 0; k < 3; ++k) {
            corners[k] = FindCorner(description, face, chunk.positions[chunk.triangles[t][k]]);
            ASSERT_LT(corners[k], description.faceVertexIndices.size());
        }
        for (std::size_t i = 0; i < description.primvars.size(); ++i) {
            const Primvar& primvar = description.primvars[i];
            const auto slot = static_cast<std::uint32_t>(HDS_SLOT_USER + i);
            for (std::uint32_t c = 0; c < 4; ++c) {
                double expected = 0.0;
                double largest = 0.0;
                if (c < primvar.numComponents) {
                    const double u = queries[q].u;
                    const double v = queries[q].v;
                    const double weights[3] = {1.0 - u - v, u, v};
                    for (int k = 0; k < 3; ++k) {
                        const double p = AuthoredValue(description, primvar, face, corners[k], c);
                        expected += weights[k] * p;
                        largest = std::fmax(largest, std::fabs(p));
                    }
                }
                // Two differences of at most 2 |p| and two fma of at most 3 |p|, each rounded to
                // half a unit in the last place (2^-24): below 8 * 2^-24 |p|.
                ASSERT_NEAR(Value(q, slot, c), expected, 8.0 * std::ldexp(largest, -24))
                    << primvar.name << " component " << c;
            }
        }
    }
}

TEST_F(Attributes, IntegersAndAbsentSlots) {
    Read(MakeDeviceMesh());
    for (std::size_t q = 0; q < queries.size(); ++q) {
        const auto t = static_cast<std::size_t>(queries[q].triangle);
        const std::uint32_t face = mesh->faces[chunk.primIds[t]];
        const std::uint32_t entries[] = {0, 1, 0, 1, 2};
        EXPECT_EQ(integers[2 * q], face);
        EXPECT_EQ(integers[2 * q + 1], entries[face]);
        EXPECT_EQ(Value(q, HDS_SLOT_NORMAL, 0), -1.0F); // the fallback
    }
}

TEST_F(Attributes, AbsentMaterialsGiveTheFallback) {
    GeometryDescription description = MakeDeviceMesh();
    description.subsets = {};
    description.subdivisionScheme = "catmullClark";
    Read(description);
    for (std::size_t q = 0; q < queries.size(); ++q) {
        EXPECT_EQ(integers[2 * q + 1], 99U);
    }
}

TEST_F(Attributes, EqualCornersGiveTheirValueExactly) {
    GeometryDescription description = MakeDeviceMesh();
    Primvar primvar;
    primvar.name = "displayColor";
    primvar.interpolation = Interpolation::FaceVarying;
    primvar.numComponents = 3;
    primvar.values = std::vector<float>{0.18F, 1.0F / 3.0F, 1e7F};
    primvar.indices = std::vector<std::int32_t>(description.faceVertexIndices.size(), 0);
    description.primvars = {primvar};
    Read(description);
    for (std::size_t q = 0; q < queries.size(); ++q) {
        EXPECT_EQ(Value(q, HDS_SLOT_USER, 0), 0.18F);
        EXPECT_EQ(Value(q, HDS_SLOT_USER, 1), 1.0F / 3.0F);
        EXPECT_EQ(Value(q, HDS_SLOT_USER, 2), 1e7F);
    }
}

} // namespace
} // namespace hds::test
