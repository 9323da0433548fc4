// SPDX-License-Identifier: Apache-2.0
// Prepared meshes keep every triangle exactly once within the chunk bound; refine levels stay in
// bounds.
#include "hdStream/scene/meshCommit.h"

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

PreparedMesh Prepare(const MeshDescription& mesh, const MeshOptions& options) {
    static Warnings warnings; // outlives the meshes
    return PrepareMesh("/grid", std::make_shared<MeshDescription>(mesh), options, nullptr, warnings);
}

TEST(MeshCommit, EveryTriangleIsInOneChunkWithinTheBound) {
    for (const std::uint64_t chunkBytes :
         {std::uint64_t{4096}, std::uint64_t{16384}, std::uint64_t{1} << 20U}) {
        MeshOptions options;
        options.chunkBytes = chunkBytes;
        const PreparedMesh mesh = Prepare(Grid(40, "none"), options);
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

TEST(MeshCommit, SubdivisionFollowsTheOption) {
    MeshOptions options;
    const auto numTriangles = [&](Subdivision subdivision, std::uint32_t level,
                                  const char* scheme) {
        options.subdivision = subdivision;
        options.refineLevel = level;
        return Prepare(Grid(4, scheme), options).numTriangles;
    };
    EXPECT_EQ(numTriangles(Subdivision::Cage, 2, "catmullClark"), 32U);
    EXPECT_EQ(numTriangles(Subdivision::Complexity, 0, "catmullClark"), 32U);
    EXPECT_EQ(numTriangles(Subdivision::Complexity, 2, "catmullClark"), 32U * 16U);
    EXPECT_EQ(numTriangles(Subdivision::Adaptive, 0, "catmullClark"), 32U * 64U);
    EXPECT_EQ(numTriangles(Subdivision::Adaptive, 0, "none"), 32U);
}

TEST(MeshCommit, AdaptiveLevelsStayBelowTheirBound) {
    const MeshOptions options;
    for (std::size_t faces = 1; faces < (std::size_t{1} << 20U); faces = faces * 3 + 1) {
        const std::uint32_t level = ChooseRefineLevel(options, faces);
        EXPECT_LE(level, 3U);
        EXPECT_TRUE(level == 0 || (faces << (2 * level)) <= (std::size_t{1} << 17U)) << faces;
    }
}

} // namespace
} // namespace hds
