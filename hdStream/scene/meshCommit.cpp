// SPDX-License-Identifier: Apache-2.0
#include "hdStream/scene/meshCommit.h"

#include "hdStream/accel/bvh.h"
#include "hdStream/geometry/curveSource.h"
#include "hdStream/geometry/pointSource.h"
#include "hdStream/geometry/polygonSource.h"
#include "hdStream/geometry/subdivSource.h"
#include "hdStream/scene/meshDisplacement.h"
#include "hdStream/scene/meshKey.h"
#include "hdStream/scene/transforms.h"

#include <algorithm>

namespace hds {

namespace {

/// A mesh of fewer triangles is looked at as fast as its outline is read.
constexpr std::uint64_t kMinKeptOutline = 256;

/// Makes the chunks, ordered by the leaves of a BVH over their boxes.
void BuildTopTree(PreparedMesh* mesh) {
    const std::vector<Bounds>& boxes = mesh->mesh->Outline().chunkBounds;
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
    if (inputs.mesh->primitives == PrimitiveKind::Curves) {
        return MakeCurveSource(inputs.mesh, path, warnings);
    }
    if (inputs.mesh->primitives == PrimitiveKind::Points) {
        return MakePointSource(inputs.mesh, path, warnings);
    }
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
    const PageKey key = store ? MakeMeshKey(inputs) : PageKey();
    const auto mesh = std::make_shared<const ChunkedMesh>(
        [path, inputs, &warnings] { return MakeSource(path, inputs, warnings); }, inputs.chunkBytes,
        std::move(store), key);
    const MeshOutline& outline = mesh->Outline();
    if (outline.numTriangles >= kMinKeptOutline && !warnings.Has(path)) {
        mesh->SaveOutline();
    }
    PreparedMesh result;
    result.leftHanded = outline.isLeftHanded;
    result.origin = outline.origin;
    result.numTriangles = outline.numTriangles;
    for (const AttributeFormat& attribute : outline.attributes) {
        result.attributes.push_back({attribute.name, attribute.numComponents});
    }
    if (result.numTriangles > 0) {
        for (const Bounds& bounds : outline.chunkBounds) {
            ExtendBounds(&result.bounds, bounds);
        }
        result.mesh = mesh;
        BuildTopTree(&result);
    }
    return result;
}

ChunkGeometry GatherAll(const PreparedMesh& mesh) {
    std::vector<std::uint32_t> units = mesh.mesh->Plan().units;
    std::sort(units.begin(), units.end());
    return mesh.mesh->Source().Gather(units.data(), units.size());
}

} // namespace hds
