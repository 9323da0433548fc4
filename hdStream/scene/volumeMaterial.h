// SPDX-License-Identifier: Apache-2.0
// The materials of the volumes of a scene, before anything of their grids is known. Explained in
// docs/volumes.md.
#pragma once

#include "hdStream/scene/materialCommit.h"
#include "hdStream/shading/volumeShader.h"

#include <functional>
#include <map>
#include <string>
#include <vector>

namespace hds {

/// What a volume is to light, and the patterns that its terms name.
struct VolumeMaterial {
    VolumeShading shading;
    std::vector<ShaderValue> patterns; ///< by their numbers; three components
    std::vector<MaterialTexture> textures;
    std::vector<std::uint32_t> textureIndices; ///< of these in the scene
};

/// By the path of the volume.
using VolumeMaterials = std::map<std::string, VolumeMaterial>;

/// Of the volumes that are drawn: of other purposes, or hidden, there are none. Adds the images of
/// patterns to those of materials. \param isDrawn of a path.
VolumeMaterials ReadVolumeMaterials(const SceneDescription& scene,
                                    const std::vector<std::string>& purposes,
                                    const std::function<bool(const std::string&)>& isDrawn,
                                    MaterialCommit* materials, Warnings& warnings);

} // namespace hds
