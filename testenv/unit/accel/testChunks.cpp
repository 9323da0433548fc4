// SPDX-License-Identifier: Apache-2.0
// The chunk plan partitions a mesh; a geometry page holds the chunk's triangles in leaf order under
// a sound BVH, with the layout of kernels/shared/geometry.h.
#include "hdStream/accel/bvh.h"
#include "hdStream/accel/chunkPlan.h"
#include "kernels/shared/geometry.h"
#include "testenv/support/meshSource.h"
#include "testenv/support/pageView.h"
#include "testenv/support/traversalMeshes.h"
#include "testenv/unit/accel/bvhCheck.h"

#include <glm/common.hpp>
#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <algorithm>
#include <cstring>
#include <set>

namespace hds::test {
namespace {

ChunkPlan Plan(const TriangleMesh& mesh, std::uint32_t maxTriangles) {
    return PlanChunks(*SourceOf(mesh), maxTriangles);
}

TEST(ChunkPlan, PartitionsTheMesh) {
    const TriangleMesh mesh = BumpySphere(50);
    for (const std::uint32_t maxTriangles : {1U, 3U, 100U, 4000U, 1000000U}) {
        const ChunkPlan plan = Plan(mesh, maxTriangles);
        ASSERT_EQ(plan.groups.size(), mesh.triangles.size());
        EXPECT_EQ(std::set<std::uint32_t>(plan.groups.begin(), plan.groups.end()).size(),
                  mesh.triangles.size());
        ASSERT_GE(plan.begin.size(), 2U);
        EXPECT_EQ(plan.begin.front(), 0U);
        EXPECT_EQ(plan.begin.back(), mesh.triangles.size());
        for (std::size_t i = 0; i + 1 < plan.begin.size(); ++i) {
            const std::uint32_t count = plan.begin[i + 1] - plan.begin[i];
            EXPECT_LE(count, maxTriangles);
            EXPECT_EQ(count, plan.counts[i]);
        }
    }
}

TEST(ChunkPlan, TakesAMeshWithoutTriangles) {
    const ChunkPlan plan = Plan(TriangleMesh{}, 100);
    EXPECT_TRUE(plan.groups.empty());
    EXPECT_EQ(plan.NumChunks(), 0U);
}

// A triangle's word has room for so many vertices only, however large a chunk may be otherwise.
TEST(ChunkPlan, BoundsTheVerticesOfAChunk) {
    const TriangleMesh mesh = BumpySphere(50);
    const std::uint32_t maxVertices = 700;
    for (const std::uint32_t maxTriangles : {400U, 1500U, 0xffffffffU}) {
        const ChunkPlan plan = PlanChunks(*SourceOf(mesh), maxTriangles, maxVertices);
        EXPECT_EQ(plan.groups.size(), mesh.triangles.size());
        for (std::size_t i = 0; i + 1 < plan.begin.size(); ++i) {
            std::set<std::uint32_t> vertices;
            for (std::uint32_t k = plan.begin[i]; k < plan.begin[i + 1]; ++k) {
                for (int corner = 0; corner < 3; ++corner) {
                    vertices.insert(mesh.triangles[plan.groups[k]][corner]);
                }
            }
            EXPECT_LE(vertices.size(), maxVertices);
            EXPECT_GE(vertices.size(), maxVertices / 16) << "chunks are not cut finer than needed";
            EXPECT_LE(plan.begin[i + 1] - plan.begin[i], maxTriangles);
        }
    }
}

// All triangles at one place cannot be told apart: they are still cut to size.
TEST(ChunkPlan, CutsEqualTriangles) {
    TriangleMesh mesh;
    mesh.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
    mesh.triangles.assign(5000, {0, 1, 2});
    const ChunkPlan plan = Plan(mesh, 128);
    for (std::size_t i = 0; i + 1 < plan.begin.size(); ++i) {
        EXPECT_LE(plan.begin[i + 1] - plan.begin[i], 128U);
    }
}

TEST(ChunkPlan, DoesNotDependOnTheThreadCount) {
    const TriangleMesh mesh = BumpySphere(160);
    const auto plan = [&](std::size_t threads) {
        const tbb::global_control control(tbb::global_control::max_allowed_parallelism, threads);
        return Plan(mesh, 2000);
    };
    const ChunkPlan one = plan(1);
    const ChunkPlan four = plan(4);
    EXPECT_EQ(one.groups, four.groups);
    EXPECT_EQ(one.begin, four.begin);
}

// Cells of the grid that hold more than a chunk are planned by themselves, side by side: their
// chunks are whole and in order.
TEST(ChunkPlan, CutsCellsThatHoldMoreThanAChunk) {
    TriangleMesh mesh;
    for (std::uint32_t cluster = 0; cluster < 1000; ++cluster) {
        for (std::uint32_t i = 0; i < 40; ++i) {
            const float x = 100.0F * static_cast<float>(cluster) + static_cast<float>(i);
            const auto first = static_cast<std::uint32_t>(mesh.positions.size());
            mesh.positions.insert(mesh.positions.end(),
                                  {{x, 0, 0}, {x + 1, 0, 0}, {x, 1, static_cast<float>(i % 3)}});
            mesh.triangles.push_back({first, first + 1, first + 2});
        }
    }
    const auto source = SourceOf(mesh);
    const auto planBy = [&](std::size_t threads) {
        const tbb::global_control control(tbb::global_control::max_allowed_parallelism, threads);
        return PlanChunks(*source, 8);
    };
    const ChunkPlan plan = planBy(1);
    const ChunkPlan other = planBy(4);
    EXPECT_EQ(plan.groups, other.groups);
    EXPECT_EQ(plan.begin, other.begin);
    ASSERT_EQ(std::set<std::uint32_t>(plan.groups.begin(), plan.groups.end()).size(),
              mesh.triangles.size());
    ASSERT_EQ(plan.groups.size(), mesh.triangles.size());
    ASSERT_EQ(plan.begin.size(), plan.NumChunks() + 1);
    ASSERT_EQ(plan.counts.size(), plan.NumChunks());
    EXPECT_EQ(plan.begin.front(), 0U);
    EXPECT_EQ(plan.begin.back(), mesh.triangles.size());
    for (std::size_t i = 0; i < plan.NumChunks(); ++i) {
        ASSERT_LT(plan.begin[i], plan.begin[i + 1]);
        ASSERT_EQ(plan.counts[i], plan.begin[i + 1] - plan.begin[i]);
        ASSERT_LE(plan.counts[i], 8U);
        Bounds box;
        for (std::uint32_t k = plan.begin[i]; k < plan.begin[i + 1]; ++k) {
            const Bounds group = source->GroupBounds(plan.groups[k]);
            box = {glm::min(box.min, group.min), glm::max(box.max, group.max)};
        }
        ASSERT_EQ(plan.bounds[i].min, box.min) << i;
        ASSERT_EQ(plan.bounds[i].max, box.max) << i;
    }
}

ChunkGeometry WholeMesh(const TriangleMesh& mesh) {
    ChunkGeometry chunk;
    chunk.positions = mesh.positions;
    chunk.triangles = mesh.triangles;
    for (std::uint32_t i = 0; i < mesh.triangles.size(); ++i) {
        chunk.primIds.push_back(i);
    }
    for (std::uint32_t i = 0; i < mesh.positions.size(); ++i) {
        chunk.points.push_back(i);
    }
    return chunk;
}

TEST(GeometryPage, HoldsTheChunkInLeafOrder) {
    const TriangleMesh mesh = BumpySphere(20);
    ChunkGeometry chunk = WholeMesh(mesh);
    const GeometryPage page = BuildGeometryPage(chunk);

    EXPECT_EQ(page.bytes.size() % HDS_POOL_UNIT_BYTES, 0U);
    const PageView view(page.bytes.data());
    ASSERT_EQ(view.header.numTriangles, mesh.triangles.size());
    EXPECT_EQ(std::size_t{view.header.triangles} * HDS_POOL_UNIT_BYTES,
              sizeof(view.header) + page.numNodes * sizeof(shared::HdsBvhNode));
    const std::size_t vertexAt = std::size_t{view.header.vertices} * HDS_POOL_UNIT_BYTES;
    // A vertex is read as 16 bytes.
    ASSERT_GE(page.bytes.size(), vertexAt + chunk.positions.size() * sizeof(glm::vec3) + 4);

    std::vector<shared::HdsBvhNode> nodes(page.numNodes);
    std::memcpy(nodes.data(), page.bytes.data() + sizeof(view.header),
                nodes.size() * sizeof(nodes[0]));
    std::vector<Bounds> boxes;
    std::uint32_t nextNew = 0;
    EXPECT_EQ(view.primIds, chunk.primIds);
    for (std::size_t i = 0; i < view.triangles.size(); ++i) {
        Bounds box;
        for (int corner = 0; corner < 3; ++corner) {
            const std::uint32_t vertex = view.triangles[i][corner];
            EXPECT_EQ(vertex, chunk.triangles[i][corner]);
            ASSERT_LE(vertex, nextNew) << "vertices are numbered in order of first use";
            nextNew = std::max(nextNew, vertex + 1);
            glm::vec3 position;
            std::memcpy(&position.x, page.bytes.data() + vertexAt + 12 * std::size_t{vertex}, 12);
            const std::uint32_t point = mesh.triangles[view.primIds[i]][corner];
            EXPECT_EQ(position, mesh.positions[point]);
            EXPECT_EQ(chunk.points[vertex], point);
            box.min = glm::min(box.min, position);
            box.max = glm::max(box.max, position);
        }
        boxes.push_back(box);
    }
    const BvhFacts facts = BvhWalker(nodes, boxes).Walk();
    EXPECT_EQ(facts.numMalformed + facts.numOutside, 0U);
    EXPECT_EQ(facts.timesSeen, std::vector<std::uint32_t>(boxes.size(), 1));
}

TEST(GeometryPage, TakesOneToThreeTriangles) {
    for (std::uint32_t count = 1; count <= 3; ++count) {
        TriangleMesh mesh = BumpySphere(4);
        mesh.triangles.resize(count);
        ChunkGeometry chunk = WholeMesh(mesh);
        const GeometryPage page = BuildGeometryPage(chunk);
        EXPECT_EQ(page.numNodes, 1U);
        EXPECT_LE(chunk.positions.size(), 3 * count) << "unused vertices are dropped";
    }
}

// The bar of the node format: at most 26 bytes of nodes a triangle on a dense mesh.
TEST(GeometryPage, StaysBelowTheNodeBudget) {
    const TriangleMesh mesh = BumpySphere(60);
    ChunkGeometry chunk = WholeMesh(mesh);
    const GeometryPage page = BuildGeometryPage(chunk);
    EXPECT_LE(page.numNodes * sizeof(shared::HdsBvhNode), 26 * mesh.triangles.size());
}

} // namespace
} // namespace hds::test
