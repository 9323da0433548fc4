// SPDX-License-Identifier: Apache-2.0
// Mesh prims -> objects, chunks and pages.
#pragma once

#include "hdStream/accel/bvh.h"
#include "hdStream/base/log.h"
#include "hdStream/scene/sceneDescription.h"

#include <memory>
#include <string>
#include <vector>

namespace hds {

/// A chunk as prepared for a pool.
struct PreparedChunk {
    GeometryPage geometry;
    std::vector<std::uint8_t> attributes;
    std::uint32_t numTriangles = 0;
};

/// A mesh prim, prepared: triangulated, cut into chunks, with its top tree.
struct PreparedMesh {
    std::string path;
    std::shared_ptr<const TriangleMesh> triangles;
    std::vector<PreparedChunk> chunks; ///< in the leaf order of the top tree
    std::vector<shared::HdsBvhNode> topNodes; ///< empty for a single chunk
    Bounds bounds; ///< relative to triangles->origin
};

/// Prepares the meshes on all cores. An unusable mesh has no chunks.
std::vector<PreparedMesh> PrepareMeshes(const std::vector<const std::pair<const std::string, MeshPrim>*>& prims,
                                        std::uint64_t chunkBytes, Warnings& warnings);

} // namespace hds
