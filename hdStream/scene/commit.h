// SPDX-License-Identifier: Apache-2.0
// Commit: the described scene becomes the host images of all device tables. Knows no device.
// Explained in docs/architecture.md.
#pragma once

#include "hdStream/accel/geometryPages.h"
#include "hdStream/base/log.h"
#include "hdStream/scene/meshCommit.h"
#include "hdStream/scene/sceneDescription.h"
#include "hdStream/shading/lightTable.h"
#include "kernels/shared/geometry.h"
#include "kernels/shared/material.h"

#include <glm/vec3.hpp>

#include <memory>
#include <vector>

namespace hds {

/// What decides which prims are drawn and how they are cut.
struct CommitOptions {
    std::vector<std::string> purposes; ///< drawn besides "default"
    MeshOptions meshes;
};

/// Counts for the statistics and `hdstream info`.
struct SceneCounts {
    std::uint64_t meshes = 0;
    std::uint64_t instances = 0; ///< leaf instances
    std::uint64_t triangles = 0; ///< unique
    std::uint64_t chunks = 0;
    std::uint64_t pageBytes = 0;           ///< what resident mode uploads
    std::uint64_t alwaysResidentBytes = 0; ///< nodes above the chunks, records, tables
    std::uint64_t textures = 0;
    std::uint64_t textureSourceBytes = 0; ///< decoded base levels
    std::uint64_t lights = 0;
    std::uint64_t emissiveTriangles = 0;
};

/// An image that a material or light names.
struct TextureUse {
    std::string authoredPath;
    std::uint32_t width = 0;
    std::uint32_t height = 0;
    std::uint32_t channels = 0;
    std::uint64_t bytesSource = 0; ///< decoded base level, as read
    std::string error;             ///< empty: it can be read
};

/// Host images of the device tables. Immutable.
struct CommittedScene {
    glm::dvec3 centre{0.0}; ///< world position of the device's origin
    std::vector<shared::HdsBvhNode> topNodes;
    std::vector<shared::HdsInstance> instances;
    std::vector<std::uint32_t> instancesByPath;
    std::vector<shared::HdsObject> objects; ///< 0: the TLAS
    std::vector<shared::HdsMesh> meshes;
    std::vector<std::uint32_t> meshMaterials;
    std::vector<shared::HdsMaterial> materials;
    std::vector<shared::HdsChunk> chunks;
    std::unique_ptr<GeometryPages> pages;
    LightTable lights;
    std::vector<std::uint32_t> lightByEntry; ///< lights of emissive material entries
    std::vector<TextureUse> textures;        ///< by authored path
    bool hasCutouts = false;
    bool hasGroups = false; ///< instances below instances
    SceneCounts counts;
    double seconds = 0.0;
};

/// Interprets the scene. Content problems warn and fall back; nothing throws for them.
std::unique_ptr<CommittedScene> CommitScene(const SceneDescription& scene,
                                            const CommitOptions& options, Warnings& warnings);

} // namespace hds
