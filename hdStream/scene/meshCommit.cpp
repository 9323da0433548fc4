// SPDX-License-Identifier: Apache-2.0
#include "hdStream/scene/meshCommit.h"

#include "hdStream/accel/bvh.h"
#include "hdStream/geometry/polygonSource.h"
#include "hdStream/geometry/subdivSource.h"
#include "hdStream/scene/meshDisplacement.h"
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

std::shared_ptr<const ChunkSource> MakeSource(const std::string& path, const MeshInputs& inputs,
                                              Warnings& warnings) {
    const Displacement displacement = MakeDisplacement(inputs.displacements);
    if (inputs.dicing) {
        auto source = MakeSubdivSource(inputs.mesh, path, *inputs.dicing, displacement, warnings);
        if (source) {
            return source;
        }
    }
    return MakePolygonSource(inputs.mesh, path, displacement, warnings);
}

} // namespace

PreparedMesh PrepareMesh(const std::string& path, const MeshInputs& inputs,
                         std::shared_ptr<PageStore> store, Warnings& warnings) {
    PreparedMesh result;
    const auto source = MakeSource(path, inputs, warnings);
    result.leftHanded = source->IsLeftHanded();
    result.origin = source->Origin();
    result.numTriangles = source->NumTriangles();
    for (const AttributeFormat& attribute : source->Attributes()) {
        result.attributes.push_back({attribute.name, attribute.numComponents});
    }
    if (result.numTriangles == 0) {
        return result;
    }
    const std::uint64_t maxTriangles =
        std::clamp<std::uint64_t>(inputs.chunkBytes / source->MeanBytes().Both(), 1,
                                  std::numeric_limits<std::uint32_t>::max());
    ChunkPlan plan = PlanChunks(*source, static_cast<std::uint32_t>(maxTriangles));
    for (const Bounds& bounds : plan.bounds) {
        ExtendBounds(&result.bounds, bounds);
    }
    const PageKey key = store ? MakeMeshKey(inputs) : PageKey();
    result.mesh = std::make_shared<const ChunkedMesh>(
        ChunkedMesh{source, std::move(plan), std::move(store), key});
    BuildTopTree(&result);
    return result;
}

ChunkGeometry GatherAll(const PreparedMesh& mesh) {
    std::vector<std::uint32_t> units = mesh.mesh->plan.units;
    std::sort(units.begin(), units.end());
    return mesh.mesh->source->Gather(units.data(), units.size());
}

} // namespace hds
