// SPDX-License-Identifier: Apache-2.0
#include "hdStream/scene/meshCommit.h"

#include "hdStream/accel/bvh.h"
#include "hdStream/geometry/polygonSource.h"
#include "hdStream/geometry/triangleMeshSource.h"
#include "hdStream/scene/meshKey.h"
#include "hdStream/scene/transforms.h"

#include <algorithm>
#include <limits>

namespace hds {

namespace {

/// Makes the chunks, ordered by the leaves of a BVH over their boxes.
void BuildTopTree(PreparedMesh* mesh) {
    const std::vector<Bounds>& boxes = mesh->mesh->plan.bounds;
    const auto addChunk = [&](std::uint32_t chunk) {
        mesh->chunks.push_back(std::make_shared<ChunkPages>(mesh->mesh, chunk));
    };
    if (boxes.size() == 1) {
        addChunk(0);
        return;
    }
    BvhOptions options;
    options.maxLeafItems = 1;
    Bvh tree = BuildBvh(boxes, options);
    std::for_each(tree.order.begin(), tree.order.end(), addChunk);
    mesh->topNodes = std::move(tree.nodes);
}

/// Bounds of Subdivision::Adaptive.
constexpr std::uint32_t kMaxAdaptiveLevel = 3;
constexpr std::size_t kMaxAdaptiveFaces = std::size_t{1} << 17U;

std::shared_ptr<const ChunkSource> MakeSource(const std::string& path,
                                              std::shared_ptr<const MeshDescription> mesh,
                                              const MeshOptions& options, Warnings& warnings) {
    const std::uint32_t level = ChooseRefineLevel(options, mesh->faceVertexCounts.size());
    const std::string& scheme = mesh->subdivisionScheme;
    if (level > 0 && (scheme == "catmullClark" || scheme == "loop" || scheme == "bilinear")) {
        return std::make_shared<const TriangleMeshSource>(
            Triangulate(*mesh, path, warnings, static_cast<int>(level)));
    }
    return MakePolygonSource(std::move(mesh), path, warnings);
}

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

PreparedMesh PrepareMesh(const std::string& path, std::shared_ptr<const MeshDescription> mesh,
                         const MeshOptions& options, std::shared_ptr<PageStore> store,
                         Warnings& warnings) {
    PreparedMesh result;
    const auto source = MakeSource(path, mesh, options, warnings);
    result.leftHanded = source->IsLeftHanded();
    result.origin = source->Origin();
    result.numTriangles = source->NumTriangles();
    for (const AttributeFormat& attribute : source->Attributes()) {
        result.attributes.push_back({attribute.name, attribute.numComponents});
    }
    if (result.numTriangles == 0) {
        return result;
    }
    const std::uint64_t maxTriangles = std::clamp<std::uint64_t>(
        options.chunkBytes / source->MeanBytes().Both(), 1, std::numeric_limits<std::uint32_t>::max());
    ChunkPlan plan = PlanChunks(*source, static_cast<std::uint32_t>(maxTriangles));
    for (const Bounds& bounds : plan.bounds) {
        ExtendBounds(&result.bounds, bounds);
    }
    const PageKey key = store ? MakeMeshKey(*mesh, options) : PageKey();
    result.mesh = std::make_shared<const ChunkedMesh>(
        ChunkedMesh{source, std::move(plan), std::move(store), key});
    BuildTopTree(&result);
    return result;
}

ChunkGeometry GatherAll(const PreparedMesh& mesh) {
    const std::vector<std::uint32_t>& units = mesh.mesh->plan.units;
    return mesh.mesh->source->Gather(units.data(), units.size());
}

} // namespace hds
