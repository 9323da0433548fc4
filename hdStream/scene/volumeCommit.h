// SPDX-License-Identifier: Apache-2.0
// Volumes become the tables of kernels/shared/volume.h, and their voxels lines of the texture
// cache. Explained in docs/volumes.md.
#pragma once

#include "hdStream/base/log.h"
#include "hdStream/scene/sceneDescription.h"
#include "hdStream/scene/transforms.h"
#include "hdStream/volume/gridPreparer.h"
#include "kernels/shared/volume.h"

#include <functional>
#include <string>
#include <vector>

namespace hds {

/// Host images of the tables of volumes.
struct CommittedVolumes {
    std::vector<shared::HdsVolume> volumes;
    std::vector<shared::HdsVolumeTerms> terms; ///< of those that have some
    std::vector<shared::HdsGrid> grids;
    std::vector<shared::HdsGridTile> tiles;
    std::vector<shared::HdsGridCell> cells;
    PreparedGrids prepared;             ///< in the order of the textures whose lines they are
    std::vector<AffineRows> motionKeys; ///< of volumes whose transforms move
    bool haveMotion = false;            ///< velocities or transforms
    bool haveVelocities = false;
    std::uint32_t linesOfTerms = 0; ///< that one collision reads at most for them
};

/// \param isDrawn of a path. \param shutter closed: nothing moves. \param centre of the scene.
/// \param numTextures that come before the grids. Volumes that cannot be drawn warn and are left
/// out.
CommittedVolumes CommitVolumes(const SceneDescription& scene,
                               const std::vector<std::string>& purposes,
                               const std::function<bool(const std::string&)>& isDrawn,
                               const Shutter& shutter, glm::dvec3 centre, std::uint32_t numTextures,
                               GridPreparer* preparer, Warnings& warnings);

} // namespace hds
