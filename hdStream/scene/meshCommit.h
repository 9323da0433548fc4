// SPDX-License-Identifier: Apache-2.0
// A mesh -> chunks and pages.
#pragma once

#include "hdStream/accel/bvh.h"
#include "hdStream/accel/geometryPages.h"
#include "hdStream/base/log.h"
#include "hdStream/scene/sceneDescription.h"
#include "hdStream/shading/materialCompiler.h"

#include <memory>
#include <string>
#include <vector>

namespace hds {

/// A chunk as prepared for a pool.
struct PreparedChunk {
    std::shared_ptr<PreparedPage> geometry;
    std::shared_ptr<PreparedPage> attributes;
    Bounds bounds; ///< relative to the mesh's origin
};

/// A mesh, prepared: triangulated, cut into chunks, with its top tree. The triangles themselves are
/// not kept: what is drawn lies in the pages.
struct PreparedMesh {
    std::vector<AttributeName> attributes; ///< user primvars, in the order of their slots
    bool leftHanded = false;
    glm::dvec3 origin{0.0}; ///< object-space point that all positions are relative to
    std::uint64_t numTriangles = 0;
    std::vector<PreparedChunk> chunks;        ///< in the leaf order of the top tree
    std::vector<shared::HdsBvhNode> topNodes; ///< empty for a single chunk
    Bounds bounds;                            ///< relative to origin
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

/// Triangles of a mesh at its refine level. \param path subject of the warnings.
std::shared_ptr<const TriangleMesh> TriangulateMesh(const std::string& path,
                                                    const MeshDescription& mesh,
                                                    const MeshOptions& options, Warnings& warnings);

/// Prepares a mesh, on all cores if it is large. An unusable mesh has no chunks.
PreparedMesh PrepareMesh(const std::string& path, const MeshDescription& mesh,
                         const MeshOptions& options, Warnings& warnings);

} // namespace hds
