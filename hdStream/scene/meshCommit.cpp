// SPDX-License-Identifier: Apache-2.0
#include "hdStream/scene/meshCommit.h"

#include "hdStream/scene/transforms.h"

#include <tbb/parallel_for.h>

#include <algorithm>

namespace hds {

namespace {

PreparedChunk PrepareChunk(const ChunkSource& source, const std::uint32_t* triangles,
                           std::size_t count) {
    ChunkGeometry geometry = source.Gather(triangles, count);
    GeometryPage page = BuildGeometryPage(geometry);
    PreparedChunk chunk;
    chunk.bounds = page.bounds;
    chunk.geometry = std::make_shared<PreparedPage>(std::move(page.bytes));
    chunk.attributes = std::make_shared<PreparedPage>(BuildAttributePage(source.Mesh(), geometry));
    return chunk;
}

/// Orders the chunks by the leaves of a BVH over their boxes.
void BuildTopTree(PreparedMesh* mesh) {
    std::vector<Bounds> boxes;
    boxes.reserve(mesh->chunks.size());
    for (const PreparedChunk& chunk : mesh->chunks) {
        boxes.push_back(chunk.bounds);
    }
    BvhOptions options;
    options.maxLeafItems = 1;
    Bvh tree = BuildBvh(boxes, options);
    std::vector<PreparedChunk> ordered;
    ordered.reserve(mesh->chunks.size());
    for (const std::uint32_t chunk : tree.order) {
        ordered.push_back(std::move(mesh->chunks[chunk]));
    }
    mesh->chunks = std::move(ordered);
    mesh->topNodes = std::move(tree.nodes);
}

/// Bounds of Subdivision::Adaptive.
constexpr std::uint32_t kMaxAdaptiveLevel = 3;
constexpr std::size_t kMaxAdaptiveFaces = std::size_t{1} << 17U;

} // namespace

std::uint32_t ChooseRefineLevel(const MeshOptions& options, std::size_t numFaces) {
    switch (options.subdivision) {
    case Subdivision::Cage:
        return 0;
    case Subdivision::Complexity:
        return options.refineLevel;
    case Subdivision::Adaptive:
        break;
    }
    std::uint32_t level = 0;
    while (level < kMaxAdaptiveLevel && (numFaces << (2 * (level + 1))) <= kMaxAdaptiveFaces) {
        ++level;
    }
    return level;
}

std::shared_ptr<const TriangleMesh> TriangulateMesh(const std::string& path,
                                                    const MeshDescription& mesh,
                                                    const MeshOptions& options,
                                                    Warnings& warnings) {
    const std::uint32_t level = ChooseRefineLevel(options, mesh.faceVertexCounts.size());
    return Triangulate(mesh, path, warnings, static_cast<int>(level));
}

PreparedMesh PrepareMesh(const std::string& path, const MeshDescription& mesh,
                         const MeshOptions& options, Warnings& warnings) {
    PreparedMesh result;
    const auto triangles = TriangulateMesh(path, mesh, options, warnings);
    result.leftHanded = triangles->leftHanded;
    result.origin = triangles->origin;
    result.numTriangles = triangles->triangles.size();
    for (const MeshAttribute& attribute : triangles->attributes) {
        result.attributes.push_back({attribute.name, attribute.numComponents});
    }
    if (triangles->triangles.empty()) {
        return result;
    }
    const ChunkSource source(triangles);
    const std::size_t bytesPerTriangle = EstimateBytesPerTriangle(*triangles);
    const auto maxTriangles = static_cast<std::uint32_t>(std::max<std::uint64_t>(
        1, options.chunkBytes / std::max<std::size_t>(1, bytesPerTriangle)));
    const ChunkPlan plan = PlanChunks(*triangles, maxTriangles);
    result.chunks.resize(plan.begin.size() - 1);
    tbb::parallel_for(std::size_t{0}, result.chunks.size(), [&](std::size_t i) {
        result.chunks[i] = PrepareChunk(source, plan.order.data() + plan.begin[i],
                                        plan.begin[i + 1] - plan.begin[i]);
    });
    for (const PreparedChunk& chunk : result.chunks) {
        ExtendBounds(&result.bounds, chunk.bounds);
    }
    if (result.chunks.size() > 1) {
        BuildTopTree(&result);
    }
    return result;
}

} // namespace hds
