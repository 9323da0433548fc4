// SPDX-License-Identifier: Apache-2.0
// Volumes as front ends hand them over. Explained in docs/volumes.md.
#pragma once

#include "hdStream/base/fields.h"
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

    static constexpr auto Fields() {
        return FieldList(HDS_FIELD(VolumeField, asset), HDS_FIELD(VolumeField, gridName),
                         HDS_FIELD(VolumeField, gridIndex),
                         HDS_FIELD(VolumeField, voxels).NotInDump("of the Python interface"));
    }
};

/// A volume in the scene.
struct VolumePrim {
    glm::dmat4 worldFromObject{1.0};
    bool visible = true;
    std::string purpose = "default";
    std::string materialPath;                  ///< whose terminal "volume" counts; empty: none
    std::optional<VolumeShading> shading;      ///< in place of a material
    std::map<std::string, VolumeField> fields; ///< by the names that materials know them by

    static constexpr auto Fields() {
        return FieldList(HDS_FIELD(VolumePrim, worldFromObject), HDS_FIELD(VolumePrim, visible),
                         HDS_FIELD(VolumePrim, purpose), HDS_FIELD(VolumePrim, materialPath),
                         HDS_FIELD(VolumePrim, shading).NotInDump("of the Python interface"),
                         HDS_FIELD(VolumePrim, fields));
    }
};

} // namespace hds
