// SPDX-License-Identifier: Apache-2.0
// UDIM sets: the files of a path with "<UDIM>" in the place of a tile's number.
#pragma once

#include "hdStream/persist/packageFile.h"

#include <cstdint>
#include <string>
#include <vector>

namespace hds {

/// Number of the tile that holds [0, 1] x [0, 1]; tiles go ten to a row.
constexpr std::uint32_t kFirstUdim = 1001;
/// Number of the last tile that UsdUVTexture allows.
constexpr std::uint32_t kLastUdim = 1100;

/// A path with a tile's number in the place of "<UDIM>".
std::string TileName(const std::string& pattern, std::uint32_t index);

/// A file of a set.
struct UdimFile {
    std::uint32_t index = 0; ///< number - 1001
    ByteRange place;         ///< size 0: the whole file
};

/// The files that exist and have a number of [kFirstUdim, kLastUdim], by index. Reads the folder,
/// or the directory of the package; nothing when there is none. \param pattern file path with
/// "<UDIM>" once in its name, or a path into a package (persist/packageFile.h)
std::vector<UdimFile> FindUdimFiles(const std::string& pattern);

} // namespace hds
