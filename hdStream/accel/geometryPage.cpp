// SPDX-License-Identifier: Apache-2.0
// The geometry page of a chunk: nodes, triangles in leaf order, vertices in order of first use.
#include "hdStream/accel/bvh.h"
#include "hdStream/accel/wideBvh.h"
#include "kernels/shared/geometry.h"

#include <cstring>

namespace hds {
namespace {

template <typename T>
void Permute(const std::vector<std::uint32_t>& order, std::vector<T>* values) {
    if (values->empty()) {
        return;
    }
    std::vector<T> permuted;
    permuted.reserve(order.size());
    for (const std::uint32_t from : order) {
        permuted.push_back((*values)[from]);
    }
    *values = std::move(permuted);
}

/// Applies the BVH's order to all that there is one of a triangle.
void ReorderTriangles(const std::vector<std::uint32_t>& order, ChunkGeometry* chunk) {
    Permute(order, &chunk->triangles);
    Permute(order, &chunk->primIds);
    Permute(order, &chunk->faces);
    Permute(order, &chunk->corners);
    Permute(order, &chunk->materialEntries);
}

/// Renumbers vertices in the order of first use; vertices that no triangle uses are dropped.
void ReorderVertices(ChunkGeometry* chunk) {
    std::vector<std::uint32_t> newIndex(chunk->positions.size(), HDS_NONE);
    std::vector<glm::vec3> positions;
    std::vector<std::uint32_t> points;
    positions.reserve(chunk->positions.size());
    points.reserve(chunk->points.size());
    for (glm::uvec3& triangle : chunk->triangles) {
        for (int corner = 0; corner < 3; ++corner) {
            std::uint32_t& index = newIndex[triangle[corner]];
            if (index == HDS_NONE) {
                index = static_cast<std::uint32_t>(positions.size());
                positions.push_back(chunk->positions[triangle[corner]]);
                points.push_back(chunk->points[triangle[corner]]);
            }
            triangle[corner] = index;
        }
    }
    chunk->positions = std::move(positions);
    chunk->points = std::move(points);
}

std::size_t AlignUnit(std::size_t bytes) {
    return (bytes + HDS_POOL_UNIT_BYTES - 1) / HDS_POOL_UNIT_BYTES * HDS_POOL_UNIT_BYTES;
}

} // namespace

GeometryPage BuildGeometryPage(ChunkGeometry& chunk) {
    std::vector<BoxRef> refs = MakeRefs(chunk.positions, chunk.triangles);
    const Bvh bvh = BuildWideBvh(refs, BvhOptions{});
    ReorderTriangles(bvh.order, &chunk);
    ReorderVertices(&chunk);

    GeometryPage page;
    page.bounds = bvh.bounds;
    page.numNodes = static_cast<std::uint32_t>(bvh.nodes.size());
    const std::size_t nodeBytes = bvh.nodes.size() * sizeof(shared::HdsBvhNode);
    const std::size_t triangleBytes = chunk.triangles.size() * sizeof(shared::HdsTriangle);
    const std::size_t vertexBytes = chunk.positions.size() * sizeof(glm::vec3);
    page.triangleOffset = static_cast<std::uint32_t>(nodeBytes / HDS_POOL_UNIT_BYTES);
    page.vertexOffset =
        static_cast<std::uint32_t>((nodeBytes + triangleBytes) / HDS_POOL_UNIT_BYTES);
    // Kernels read a vertex as four floats: the last one must not end the page.
    page.bytes.resize(AlignUnit(nodeBytes + triangleBytes + vertexBytes + sizeof(float)));
    std::memcpy(page.bytes.data(), bvh.nodes.data(), nodeBytes);
    for (std::size_t i = 0; i < chunk.triangles.size(); ++i) {
        const glm::uvec3& t = chunk.triangles[i];
        const shared::HdsTriangle triangle = {{t.x, t.y, t.z}, chunk.primIds[i]};
        std::memcpy(page.bytes.data() + nodeBytes + i * sizeof(triangle), &triangle,
                    sizeof(triangle));
    }
    if (vertexBytes != 0) {
        std::memcpy(page.bytes.data() + nodeBytes + triangleBytes, chunk.positions.data(),
                    vertexBytes);
    }
    return page;
}

} // namespace hds
