// SPDX-License-Identifier: Apache-2.0
// Bounds of the voxels of a brick. Explained in docs/volumes.md, section "Grids".
#pragma once

#include "hdStream/volume/voxelGrid.h"

namespace hds {

/// As tight as half a byte can say, from the least to the greatest voxel of the brick.
shared::HdsBrickBounds BoundBrick(const VoxelBrick& values);

} // namespace hds
