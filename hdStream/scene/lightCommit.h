// SPDX-License-Identifier: Apache-2.0
// Lights of the scene and emissive meshes -> the light table.
#pragma once

#include "hdStream/scene/commit.h"
#include "hdStream/scene/hierarchy.h"
#include "hdStream/scene/materialCommit.h"

namespace hds {

/// Emissive triangles beyond this number are seen but not sampled, with a warning. All take 64 MiB
/// of the device's memory, and 200 bytes for each cluster of them.
constexpr std::size_t kMaxEmissiveTriangles = 1U << 20U;

/// The images of the scene's lights that can be read, each once: the first of the scene's textures.
/// Prepares what is new.
std::vector<MaterialTexture> LoadLightTextures(const SceneDescription& scene, CommitCache* cache);

/// What the light table is made of, besides the described lights.
struct LightCommitInput {
    const SceneDescription* scene = nullptr;
    glm::dvec3 centre{0.0};
    bool domeVisible = true;
    bool lightsVisible = true;
    const std::vector<PrimMaterialInfo>* primInfos = nullptr; ///< by the prim of WorldInstance
    const MaterialCommit* materials = nullptr;
    const std::vector<WorldInstance>* worldInstances = nullptr;
    const LightLinks* links = nullptr;
    Shutter shutter; ///< while it is open lights may move
};

/// Which lights of the table the material entries of each world instance are.
struct CommittedLights {
    std::vector<std::uint32_t> firstEntryByRecord; ///< into lightByEntry
    std::vector<std::uint32_t> lightByEntry;    ///< LightTable::tableByMesh; HDS_NONE: not sampled
    std::vector<bool> texturedEmissionByRecord; ///< light samples of some entry end at its surface
    std::uint64_t emissiveTriangles = 0;
};

/// Leaves the light table in the cache, and of images of lights those that LoadLightTextures has
/// loaded before; it is made anew only when what it is made of has changed.
/// A stage without any light gets a uniform dome of radiance 1, with a warning.
CommittedLights CommitLights(const LightCommitInput& input, CommitCache* cache, Warnings& warnings);

} // namespace hds
