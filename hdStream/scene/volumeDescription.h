// SPDX-License-Identifier: Apache-2.0
// Volumes as front ends hand them over. Explained in docs/volumes.md.
#pragma once

#include "hdStream/shading/materialNetwork.h"
#include "hdStream/shading/volumeShader.h"
#include "hdStream/volume/voxelGrid.h"

#include <glm/mat4x4.hpp>

#include <map>
#include <memory>
#include <optional>
#include <string>

namespace hds {

/// A field of a volume: a grid of a file, or one in memory.
struct VolumeField {
    AssetReference asset; ///< an OpenVDB file
    std::string gridName;
    int gridIndex = 0;                       ///< of those of that name
    std::shared_ptr<const VoxelGrid> voxels; ///< in place of a file
};

/// A volume in the scene.
struct VolumePrim {
    glm::dmat4 worldFromObject{1.0};
    bool visible = true;
    std::string purpose = "default";
    std::string materialPath;                  ///< whose terminal "volume" counts; empty: none
    std::optional<VolumeShading> shading;      ///< in place of a material
    std::map<std::string, VolumeField> fields; ///< by the names that materials know them by
};

} // namespace hds
