// SPDX-License-Identifier: Apache-2.0
// UDIM sets: the files of a path with "<UDIM>" in the place of a tile's number.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace hds {

/// Number of the tile that holds [0, 1] x [0, 1]; tiles go ten to a row.
constexpr std::uint32_t kFirstUdim = 1001;
/// Number of the last tile that UsdUVTexture allows.
constexpr std::uint32_t kLastUdim = 1100;

/// A file of a set.
struct UdimFile {
    std::uint32_t index = 0; ///< number - 1001
    std::string path;
};

/// The files that exist and have a number of [kFirstUdim, kLastUdim], by index. Reads the folder;
/// nothing when there is none. \param pattern file path with "<UDIM>" once in its name
std::vector<UdimFile> FindUdimFiles(const std::string& pattern);

} // namespace hds
