// SPDX-License-Identifier: Apache-2.0
// Instancers -> groups and the TLAS. The hierarchy is kept: a group is built once however often it
// is placed. Flattened are only leaves that must have a record of their own in the TLAS (emissive
// meshes) and chains deeper than HDS_MAX_GROUP_DEPTH.
// Explained in docs/architecture.md, "Instances".
#pragma once

#include "hdStream/base/hugePages.h"
#include "hdStream/base/log.h"
#include "hdStream/scene/groupRecords.h"
#include "hdStream/scene/instanceChunks.h"
#include "hdStream/scene/lightLinks.h"
#include "hdStream/scene/sceneDescription.h"
#include "hdStream/scene/transforms.h"
#include "kernels/shared/geometry.h"

#include <functional>
#include <memory>
#include <string>
#include <utility>
#include <vector>

namespace hds {

/// A drawn prim of the scene, with its path.
struct DrawnLeaf {
    const std::pair<const std::string, GeometryPrim>* entry = nullptr;
    LeafObject object;
    SharedSpan<std::int32_t> instances; ///< of the prim's those that are meant; empty: all

    const SharedSpan<std::int32_t>& Instances() const {
        return instances.empty() ? Prim().placement.instances : instances;
    }
    const std::string& Path() const { return entry->first; }
    const GeometryPrim& Prim() const { return entry->second; }
};

/// One placement in the TLAS of a leaf that asked for its world instance.
struct WorldInstance {
    std::string path;
    std::uint32_t prim = 0;
    glm::dmat4 worldFromObject{1.0}; ///< relative to the scene centre, from device positions
    std::vector<glm::dmat4> keys;    ///< the same while the shutter is open (KeysFromDevice)
    std::uint64_t pathIndex = 0;
    std::uint32_t instance = HDS_NONE; ///< the record in Hierarchy::instances
};

/// Device tables of the hierarchy. Object 0 is the TLAS.
struct Hierarchy {
    HugeVector<shared::HdsBvhNode> nodes;      ///< those that were there, then those of all groups
    std::vector<shared::HdsObject> groups;     ///< nodeBase into nodes, itemBase into instances
    HugeVector<shared::HdsInstance> instances; ///< group by group, leaf order of its BVH
    /// Per group, records in the order of pathOffset.
    HugeVector<std::uint32_t> instancesByPath;
    /// Records that lie in chunks, of a group each; on no path are two of these groups. A chunk's
    /// object, among the groups, is HDS_OBJECT_INSTANCES, with its number among all these chunks as
    /// itemBase.
    std::vector<std::shared_ptr<const InstanceChunks>> instanceChunks;
    std::vector<AffineRows> motionKeys; ///< of the records with HDS_INSTANCE_MOVES
    std::vector<WorldInstance> worldInstances;
    std::uint64_t numLeaves = 0; ///< leaf instances in the scene
    std::uint32_t depth = 0;     ///< groups below the TLAS on the longest path
    /// About so much of what is placed a flat hierarchy may take: it takes nothing that instancers
    /// place in a group or a TLAS whose instances lie in chunks.
    float flatPart = 1.0F;
    Bounds bounds; ///< of the TLAS
};

/// When records of a group, or of the TLAS, lie in chunks.
struct InstanceChunkOptions {
    std::uint32_t leastInstances = 0;      ///< of instancers, in the group; 0: never
    std::uint64_t chunkBytes = 1U << 17U;  ///< about what a chunk takes at most
    std::shared_ptr<PageStore> store = {}; ///< as of InstanceChunks
};

/// Builds the hierarchy of all drawn prims.
/// \param leaves the drawn prims, in the order of paths.
/// \param centre scene centre, subtracted from world positions in double.
/// \param firstGroup index of the first group after the TLAS in the object table (the TLAS is
/// object
///        0, the leaves' objects come between).
/// \param links of the scene
/// \param shutter closed: everything is at rest where the frame has it
/// \param chunking of the instances of groups of which none moves
/// \param nodes to begin with: the groups' come behind them
/// Prims with transforms that are singular, not finite or beyond 1e30 are dropped with a warning.
Hierarchy BuildHierarchy(const SceneDescription& scene, const std::vector<DrawnLeaf>& leaves,
                         const glm::dvec3& centre, std::uint32_t firstGroup, LightLinks* links,
                         const Shutter& shutter, Warnings& warnings,
                         const InstanceChunkOptions& chunking = {},
                         HugeVector<shared::HdsBvhNode> nodes = {});

} // namespace hds
