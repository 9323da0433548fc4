// SPDX-License-Identifier: Apache-2.0
// Prepared meshes keep every triangle exactly once within the chunk bound; their names in the cache
// follow what they are made of.
#include "hdStream/scene/meshCommit.h"

#include "hdStream/scene/meshKey.h"

#include "testenv/support/pageView.h"

#include <gtest/gtest.h>

namespace hds {
namespace {

/// A grid of quads in the plane z = 0.
MeshDescription Grid(std::int32_t size, const std::string& scheme) {
    MeshDescription mesh;
    std::vector<float> points;
    std::vector<std::int32_t> counts;
    std::vector<std::int32_t> indices;
    for (std::int32_t y = 0; y <= size; ++y) {
        for (std::int32_t x = 0; x <= size; ++x) {
            points.insert(points.end(), {static_cast<float>(x), static_cast<float>(y), 0.0F});
        }
    }
    for (std::int32_t y = 0; y < size; ++y) {
        for (std::int32_t x = 0; x < size; ++x) {
            const std::int32_t corner = y * (size + 1) + x;
            counts.push_back(4);
            indices.insert(indices.end(),
                           {corner, corner + 1, corner + size + 2, corner + size + 1});
        }
    }
    mesh.points = std::move(points);
    mesh.faceVertexCounts = std::move(counts);
    mesh.faceVertexIndices = std::move(indices);
    mesh.subdivisionScheme = scheme;
    return mesh;
}

PreparedMesh Prepare(const MeshDescription& mesh, MeshInputs inputs) {
    static Warnings warnings; // outlives the meshes
    inputs.mesh = std::make_shared<MeshDescription>(mesh);
    return PrepareMesh("/grid", inputs, nullptr, warnings);
}

TEST(MeshCommit, EveryTriangleIsInOneChunkWithinTheBound) {
    for (const std::uint64_t chunkBytes :
         {std::uint64_t{4096}, std::uint64_t{16384}, std::uint64_t{1} << 20U}) {
        MeshInputs inputs;
        inputs.chunkBytes = chunkBytes;
        const PreparedMesh mesh = Prepare(Grid(40, "none"), inputs);
        std::vector<int> seen(40 * 40, 0);
        for (const std::shared_ptr<ChunkPages>& chunk : mesh.chunks) {
            const std::uint64_t bound =
                chunk->Bytes(HDS_PAGE_GEOMETRY) + chunk->Bytes(HDS_PAGE_ATTRIBUTES);
            EXPECT_FALSE(chunk->IsExact());
            EXPECT_TRUE(chunk->Prepare({true, true}));
            const std::uint64_t bytes =
                chunk->Bytes(HDS_PAGE_GEOMETRY) + chunk->Bytes(HDS_PAGE_ATTRIBUTES);
            EXPECT_TRUE(chunk->IsExact());
            EXPECT_EQ(bytes, chunk->DataBytes());
            EXPECT_LE(bytes, bound);
            EXPECT_LE(bytes, chunkBytes);
        }
        const ChunkPlan& plan = mesh.mesh->plan;
        for (std::size_t i = 0; i < plan.NumChunks(); ++i) {
            const ChunkGeometry geometry = mesh.mesh->source->Gather(
                plan.units.data() + plan.begin[i], plan.begin[i + 1] - plan.begin[i]);
            EXPECT_EQ(geometry.triangles.size(), plan.counts[i]);
            for (const std::uint32_t face : geometry.faces) {
                ++seen.at(face);
            }
        }
        EXPECT_EQ(seen, std::vector<int>(seen.size(), 2));
        EXPECT_EQ(mesh.topNodes.empty(), mesh.chunks.size() == 1);
    }
}

TEST(MeshCommit, SurfacesAreDicedAsAsked) {
    MeshInputs inputs;
    EXPECT_EQ(Prepare(Grid(4, "catmullClark"), inputs).numTriangles, 32U);
    inputs.dicing.emplace();
    inputs.dicing->level = 2;
    EXPECT_EQ(Prepare(Grid(4, "catmullClark"), inputs).numTriangles, 32U * 16U);
}

// The same mesh has the same name in the cache; whatever its pages depend on gives another.
TEST(MeshCommit, KeysFollowEveryInput) {
    MeshInputs inputs;
    inputs.mesh = std::make_shared<MeshDescription>(Grid(3, "catmullClark"));
    std::vector<PageKey> keys = {MakeMeshKey(inputs)};
    const auto add = [&](const MeshInputs& changed) { keys.push_back(MakeMeshKey(changed)); };
    MeshInputs other = inputs;
    other.mesh = std::make_shared<MeshDescription>(Grid(3, "catmullClark"));
    EXPECT_EQ(MakeMeshKey(other), keys[0]);
    other.mesh = std::make_shared<MeshDescription>(Grid(3, "loop"));
    add(other);
    MeshDescription left = Grid(3, "catmullClark");
    left.leftHanded = true;
    other.mesh = std::make_shared<MeshDescription>(left);
    add(other);
    other = inputs;
    other.chunkBytes = 4096;
    add(other);
    other = inputs;
    other.displacements = {{0.25F, ""}};
    add(other);
    other.displacements = {{0.25F, "height"}};
    add(other);
    other = inputs;
    other.dicing.emplace();
    add(other);
    other.dicing->isAdaptive = true;
    add(other);
    other.dicing->view.cameraFromObject[3][2] = -5.0;
    add(other);
    for (std::size_t i = 0; i < keys.size(); ++i) {
        for (std::size_t k = 0; k < i; ++k) {
            EXPECT_NE(keys[i], keys[k]) << i << " and " << k;
        }
    }
}

} // namespace
} // namespace hds
