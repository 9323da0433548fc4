// SPDX-License-Identifier: Apache-2.0
// A mesh -> chunks and pages.
#pragma once

#include "hdStream/accel/chunkPages.h"
#include "hdStream/base/log.h"
#include "hdStream/scene/sceneDescription.h"
#include "hdStream/shading/materialCompiler.h"

#include <memory>
#include <string>
#include <vector>

namespace hds {

/// A mesh, checked and cut into chunks that are not made yet, with its top tree.
struct PreparedMesh {
    std::vector<AttributeName> attributes; ///< user primvars, in the order of their slots
    bool leftHanded = false;
    glm::dvec3 origin{0.0};         ///< object-space point that all positions are relative to
    std::uint64_t numTriangles = 0; ///< upper bound; exact for polygons
    std::shared_ptr<const ChunkedMesh> mesh; ///< null: nothing can be drawn
    std::vector<std::shared_ptr<ChunkPages>> chunks; ///< in the leaf order of the top tree
    std::vector<shared::HdsBvhNode> topNodes;        ///< empty for a single chunk
    Bounds bounds;                                   ///< relative to origin
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

    bool operator==(const MeshOptions& other) const {
        return chunkBytes == other.chunkBytes && subdivision == other.subdivision &&
               (subdivision != Subdivision::Complexity || refineLevel == other.refineLevel);
    }
};

/// Refine level of a subdivision mesh. Adaptive: the finest up to 3 that keeps the mesh below 2^17
/// faces, so that small cages become round and large ones, which are fine already, stay in bounds.
std::uint32_t ChooseRefineLevel(const MeshOptions& options, std::size_t numFaces);

/// Checks a mesh, cuts it into chunks and builds its top tree, on all cores if it is large; makes no
/// triangles. An unusable mesh has no chunks. \param path subject of the warnings, which must
/// outlive the result. \param store of finished pages; may be null.
PreparedMesh PrepareMesh(const std::string& path, std::shared_ptr<const MeshDescription> mesh,
                         const MeshOptions& options, std::shared_ptr<PageStore> store,
                         Warnings& warnings);

/// All triangles of a prepared mesh.
ChunkGeometry GatherAll(const PreparedMesh& mesh);

} // namespace hds
