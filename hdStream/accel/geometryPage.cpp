// SPDX-License-Identifier: Apache-2.0
// The geometry page of a chunk: header, nodes, triangles in leaf order, vertices in order of first
// use; of curves and points in their own order, with radii. Nodes and vertices that move are there
// once for each key.
#include "hdStream/accel/bvh.h"
#include "hdStream/accel/wideBvh.h"
#include "hdStream/base/error.h"
#include "kernels/shared/geometry.h"

#include <glm/common.hpp>

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
    Permute(order, &chunk->primitiveBounds);
    for (ChunkKey& key : chunk->keys) {
        Permute(order, &key.primitiveBounds);
    }
}

bool Moves(const ChunkGeometry& chunk) {
    return !chunk.keys.empty();
}

void Pack(const SplatShape& shape, std::vector<float>* packed) {
    packed->insert(packed->end(), shape.turn.begin(), shape.turn.end());
    packed->insert(packed->end(), shape.sizes.begin(), shape.sizes.end());
    packed->push_back(shape.cutoff);
}

/// Vertices of curves and points as kernels read them.
std::vector<float> PackSolidVertices(const ChunkGeometry& chunk) {
    std::vector<float> packed;
    for (std::size_t i = 0; i < chunk.positions.size(); ++i) {
        const glm::vec3& position = chunk.positions[i];
        packed.insert(packed.end(), {position.x, position.y, position.z, chunk.radii[i]});
        if (!chunk.jointNormals.empty()) {
            const glm::vec3& normal = chunk.jointNormals[i];
            packed.insert(packed.end(), {normal.x, normal.y, normal.z, 0.0F});
        }
        if (!chunk.shapes.empty()) {
            Pack(chunk.shapes[i], &packed);
        }
        for (const ChunkKey& key : chunk.keys) {
            const glm::vec3& later = key.positions[i];
            packed.insert(packed.end(), {later.x, later.y, later.z, key.radii[i]});
            if (!key.shapes.empty()) {
                Pack(key.shapes[i], &packed);
            }
        }
    }
    return packed;
}

/// Positions when the shutter opens, and behind each those at the later keys.
std::vector<glm::vec3> PackMovingVertices(const ChunkGeometry& chunk) {
    std::vector<glm::vec3> packed;
    packed.reserve((1 + chunk.keys.size()) * chunk.positions.size());
    for (std::size_t i = 0; i < chunk.positions.size(); ++i) {
        packed.push_back(chunk.positions[i]);
        for (const ChunkKey& key : chunk.keys) {
            packed.push_back(key.positions[i]);
        }
    }
    return packed;
}

Bounds Union(const Bounds& a, const Bounds& b) {
    return {glm::min(a.min, b.min), glm::max(a.max, b.max)};
}

std::vector<Bounds> BoundTriangles(const std::vector<glm::vec3>& positions,
                                   const std::vector<glm::uvec3>& triangles) {
    std::vector<Bounds> boxes;
    boxes.reserve(triangles.size());
    for (const glm::uvec3& triangle : triangles) {
        Bounds box;
        for (int corner = 0; corner < 3; ++corner) {
            const glm::vec3& position = positions[triangle[corner]];
            box = Union(box, {position, position});
        }
        boxes.push_back(box);
    }
    return boxes;
}

/// Boxes of the primitives of a chunk that moves, at its keys.
std::vector<std::vector<Bounds>> MovingBoxes(const ChunkGeometry& chunk) {
    const bool hasTriangles = chunk.primitives == HDS_PRIMITIVE_TRIANGLES;
    std::vector<std::vector<Bounds>> keys;
    keys.push_back(hasTriangles ? BoundTriangles(chunk.positions, chunk.triangles)
                                : chunk.primitiveBounds);
    for (const ChunkKey& key : chunk.keys) {
        keys.push_back(hasTriangles ? BoundTriangles(key.positions, chunk.triangles)
                                    : key.primitiveBounds);
    }
    // What kernels round when they interpolate depends on the larger of two keys.
    constexpr float kRounding = 8.0F / (1U << 24U);
    for (std::size_t i = 0; i < keys[0].size(); ++i) {
        Bounds all;
        for (const std::vector<Bounds>& key : keys) {
            all = Union(all, key[i]);
        }
        const glm::vec3 pad = kRounding * glm::max(glm::abs(all.min), glm::abs(all.max));
        for (std::vector<Bounds>& key : keys) {
            key[i] = {key[i].min - pad, key[i].max + pad};
        }
    }
    return keys;
}

Bvh BuildPageBvh(const ChunkGeometry& chunk) {
    if (Moves(chunk)) {
        return BuildMovingBvh(MovingBoxes(chunk), BvhOptions{});
    }
    std::vector<BoxRef> refs = chunk.primitives != HDS_PRIMITIVE_TRIANGLES
                                   ? MakeRefs(chunk.primitiveBounds)
                                   : MakeRefs(chunk.positions, chunk.triangles);
    return BuildWideBvh(refs, BvhOptions{});
}

/// Renumbers vertices in the order of first use; vertices that no triangle uses are dropped.
void ReorderVertices(ChunkGeometry* chunk) {
    std::vector<std::uint32_t> newIndex(chunk->positions.size(), HDS_NONE);
    std::vector<glm::vec3> positions;
    std::vector<std::vector<glm::vec3>> later(chunk->keys.size());
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
                for (std::size_t i = 0; i < later.size(); ++i) {
                    later[i].push_back(chunk->keys[i].positions[triangle[corner]]);
                }
            }
            triangle[corner] = index;
        }
    }
    chunk->positions = std::move(positions);
    for (std::size_t i = 0; i < later.size(); ++i) {
        chunk->keys[i].positions = std::move(later[i]);
    }
    chunk->points = std::move(points);
}

std::size_t AlignUnit(std::size_t bytes) {
    return (bytes + HDS_POOL_UNIT_BYTES - 1) / HDS_POOL_UNIT_BYTES * HDS_POOL_UNIT_BYTES;
}

shared::HdsTriangle PackTriangle(const glm::uvec3& corners) {
    return {std::uint64_t{corners.x} | std::uint64_t{corners.y} << HDS_VERTEX_BITS |
            std::uint64_t{corners.z} << (2U * HDS_VERTEX_BITS)};
}

/// Appends arrays to a page, each from a multiple of 16 bytes on.
class PageWriter {
public:
    /// \return the offset in units of 16 bytes.
    template <typename T>
    std::uint32_t Append(const std::vector<T>& values) {
        const std::size_t begin = AlignUnit(_bytes.size());
        _bytes.resize(begin + values.size() * sizeof(T));
        if (!values.empty()) {
            std::memcpy(_bytes.data() + begin, values.data(), values.size() * sizeof(T));
        }
        return static_cast<std::uint32_t>(begin / HDS_POOL_UNIT_BYTES);
    }
    /// \param spareBytes that may be read behind the last array.
    std::vector<std::uint8_t> Finish(const shared::HdsPageHeader& header, std::size_t spareBytes) {
        _bytes.resize(AlignUnit(_bytes.size() + spareBytes));
        std::memcpy(_bytes.data(), &header, sizeof(header));
        return std::move(_bytes);
    }

private:
    std::vector<std::uint8_t> _bytes = std::vector<std::uint8_t>(sizeof(shared::HdsPageHeader));
};

} // namespace

GeometryPage BuildGeometryPage(ChunkGeometry& chunk) {
    const bool isSolid = chunk.primitives != HDS_PRIMITIVE_TRIANGLES;
    Bvh bvh = BuildPageBvh(chunk);
    if (bvh.nodes.empty()) {
        bvh.nodes.emplace_back(); // all of a group's triangles may turn out to have no area
    }
    ReorderTriangles(bvh.order, &chunk);
    if (!isSolid) {
        ReorderVertices(&chunk);
    }
    HDS_VERIFY(chunk.positions.size() <= HDS_MAX_CHUNK_VERTICES,
               std::to_string(chunk.positions.size()) + " vertices");

    std::vector<shared::HdsTriangle> triangles;
    triangles.reserve(chunk.triangles.size());
    for (const glm::uvec3& corners : chunk.triangles) {
        triangles.push_back(PackTriangle(corners));
    }
    PageWriter writer;
    shared::HdsPageHeader header{};
    writer.Append(bvh.nodes);
    writer.Append(bvh.laterNodes);
    header.triangles = writer.Append(triangles);
    header.primIds = writer.Append(chunk.primIds);
    header.vertices = isSolid        ? writer.Append(PackSolidVertices(chunk))
                      : Moves(chunk) ? writer.Append(PackMovingVertices(chunk))
                                     : writer.Append(chunk.positions);
    if (Moves(chunk)) {
        HDS_VERIFY(header.vertices <= HDS_PAGE_VERTICES &&
                       chunk.keys.size() <= HDS_MAX_DEFORMATION_SEGMENTS,
                   std::to_string(header.vertices) + ", " + std::to_string(chunk.keys.size()));
        header.vertices |= HDS_PAGE_MOVES | (static_cast<std::uint32_t>(chunk.keys.size()) - 1)
                                                << HDS_PAGE_SEGMENTS_SHIFT;
    }
    header.vertices |= bvh.laterNodes.empty() ? 0U : HDS_PAGE_BOXES_MOVE;
    header.numTriangles = static_cast<std::uint32_t>(triangles.size()) | chunk.primitives
                                                                             << HDS_PRIMITIVE_SHIFT;
    GeometryPage page;
    // Kernels read a vertex as four floats: the last one must not end the page.
    page.bytes = writer.Finish(header, sizeof(float));
    page.bounds = bvh.bounds;
    page.numNodes = static_cast<std::uint32_t>(bvh.nodes.size());
    return page;
}

} // namespace hds
