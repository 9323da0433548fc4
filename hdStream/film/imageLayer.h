// SPDX-License-Identifier: Apache-2.0
// A finished AOV in host memory: what the film hands to the image writer and to front ends.
// Explained in docs/film.md.
#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <vector>

namespace hds {

/// One finished AOV: rows from top to bottom, channels interleaved.
struct ImageLayer {
    std::string name;                  ///< AOV name as in --aovs
    std::vector<std::string> channels; ///< "R","G","B","A" | "Z" | "X","Y","Z" | "id" ...
    bool isInteger = false;            ///< ids are integers
    bool isHalf = false;               ///< floats of 16 bits are enough in an EXR
    std::uint32_t width = 0;
    std::uint32_t height = 0;
    std::vector<float> values;     ///< [height][width][channels]; empty for integer layers
    std::vector<std::int32_t> ids; ///< [height][width] for integer layers
    /// Texts by name that belong into the header of an EXR with the layer.
    std::map<std::string, std::string> header;
};

} // namespace hds
