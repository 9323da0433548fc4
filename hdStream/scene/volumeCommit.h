// SPDX-License-Identifier: Apache-2.0
// Volumes become the tables of kernels/shared/volume.h, and their voxels lines of the texture
// cache. Explained in docs/volumes.md.
#pragma once

#include "hdStream/base/log.h"
#include "hdStream/scene/lightLinks.h"
#include "hdStream/scene/sceneDescription.h"
#include "hdStream/scene/transforms.h"
#include "hdStream/scene/volumeMaterial.h"
#include "hdStream/volume/gridPreparer.h"
#include "kernels/shared/volume.h"

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
    PreparedGrids prepared;      ///< in the order of the textures whose lines they are
    PreparedGrids bounded;       ///< of these, whose bricks' bounds kernels look at, in their order
    std::uint64_t numBricks = 0; ///< of all that are prepared
    std::uint64_t numBoundedBricks = 0; ///< of those that are bounded
    std::vector<AffineRows> motionKeys; ///< of volumes whose transforms move
    bool haveMotion = false;            ///< velocities or transforms
    bool haveVelocities = false;
    std::uint32_t linesOfTerms = 0;      ///< that one collision reads at most for them
    std::vector<std::uint32_t> programs; ///< of patterns, behind those of materials
    std::uint32_t maxLookups = 0;        ///< of textures at one collision
    bool havePatterns = false;           ///< or phase functions that vary
};

/// What comes before the tables of volumes.
struct VolumeTableStarts {
    std::uint32_t textures = 0; ///< that come before the grids
    std::uint32_t words = 0;    ///< of programs
};

/// Where grids and the images of patterns are read; not null.
struct VolumeSources {
    GridPreparer* grids = nullptr;
    ImageLibrary* images = nullptr;
};

/// \param materials of the volumes that are drawn. \param shutter closed: nothing moves.
/// \param centre of the scene. \param links that know the volumes. Volumes that cannot be drawn
/// warn and are left out.
CommittedVolumes CommitVolumes(const SceneDescription& scene, VolumeMaterials materials,
                               const Shutter& shutter, glm::dvec3 centre,
                               const VolumeTableStarts& starts, const VolumeSources& sources,
                               LightLinks* links, Warnings& warnings);

} // namespace hds
