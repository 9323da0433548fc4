// SPDX-License-Identifier: Apache-2.0
// What a progressive JPEG file is, without decoding it: libjpeg reads all scans of such a file
// before it tells the size, which takes half as long as all its texels do.
#pragma once

#include <cstdint>
#include <istream>
#include <optional>
#include <vector>

namespace hds {

/// The header of a progressive file.
struct JpegHeader {
    std::uint32_t width = 0; ///< pixels
    std::uint32_t height = 0;
    /// A whole JPEG file: all segments before the first scan, of an image of 8 x 8 pixels without
    /// data. Readers find in it whatever else the file says of itself there.
    std::vector<char> bytes;
};

/// Reads the segments (ITU-T T.81, annex B) of the `size` bytes from `begin`. \return nothing where
/// the file is not progressive, or has anything but segments before its first scan
std::optional<JpegHeader> ReadProgressiveHeader(std::istream& file, std::uint64_t begin,
                                                std::uint64_t size);

/// Whether an ICC profile can be anywhere in these bytes, between scans too: its name is.
bool NamesProfile(std::istream& file, std::uint64_t begin, std::uint64_t size);

} // namespace hds
