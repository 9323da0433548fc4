// SPDX-License-Identifier: Apache-2.0
// Grids of OpenVDB files. Explained in docs/volumes.md.
#pragma once

#include "hdStream/volume/voxelGrid.h"

#include <cstdint>
#include <string>
#include <vector>

namespace hds {

/// A grid of a file.
struct VdbRequest {
    std::string file;
    std::uint64_t offset = 0; ///< bytes: where it begins in a package
    std::string gridName;
    int gridIndex = 0;      ///< of those of that name
    bool isNegated = false; ///< values count with the other sign: what is below 0
};

/// The active voxels of a fog volume: one grid of numbers, or three of vectors. Thread-safe.
/// \return nothing when it cannot be read; `error` says why then.
std::vector<VoxelGrid> ReadVdb(const VdbRequest& request, std::string* error);

} // namespace hds
