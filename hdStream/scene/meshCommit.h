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
    std::vector<PreparedChunk> chunks;        ///< in the leaf order of the top tree
    std::vector<shared::HdsBvhNode> topNodes; ///< empty for a single chunk
    Bounds bounds;                            ///< relative to triangles->origin
};

/// How subdivision surfaces are drawn (DESIGN.md section 4.8).
enum class Subdivision {
    Adaptive, ///< close to the limit surface: the level of a mesh follows from its size, see below
    Complexity, ///< one level for all meshes
    Cage,       ///< as authored, not subdivided
};

/// How meshes are prepared.
struct MeshOptions {
    std::uint64_t chunkBytes = 1U << 20U; ///< upper bound of a chunk's pages
    Subdivision subdivision = Subdivision::Adaptive;
    std::uint32_t refineLevel = 0; ///< for Subdivision::Complexity
};

/// Refine level of a subdivision mesh. Adaptive: the finest up to 3 that keeps the mesh below 2^17
/// faces, so that small cages become round and large ones, which are fine already, stay in bounds.
std::uint32_t ChooseRefineLevel(const MeshOptions& options, std::size_t numFaces);

/// Prepares the meshes on all cores. An unusable mesh has no chunks.
std::vector<PreparedMesh>
PrepareMeshes(const std::vector<const std::pair<const std::string, MeshPrim>*>& prims,
              const MeshOptions& options, Warnings& warnings);

} // namespace hds
