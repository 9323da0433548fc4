// SPDX-License-Identifier: Apache-2.0
// Images of any format OpenImageIO knows, in a file or in a byte range of one (a texture inside a
// usdz package): what they are. Nothing here throws for bad content: results carry one line that
// names the file. Thread-safe. Explained in docs/texturing.md.
#pragma once

#include <cstdint>
#include <string>

namespace hds {

/// Where an image is.
struct ImageSource {
    std::string file;         ///< resolved path
    std::uint64_t offset = 0; ///< bytes
    std::uint64_t size = 0;   ///< bytes; 0: the whole file
    std::string name;         ///< for messages and the extension (authored path); empty: file
};

/// What an image is, without its texels.
struct ImageInfo {
    std::string error; ///< one line that names the file; empty when all is well
    std::uint32_t width = 0;
    std::uint32_t height = 0;
    std::uint32_t channels = 0;
    std::string fileFormat;     ///< OpenImageIO's name: "png", "jpeg", "openexr" ...
    std::string channelType;    ///< "uint8", "uint16", "half", "float" ...
    std::string autoColorSpace; ///< what "auto" means for it: "sRGB" or "raw"
    bool hasAlpha = false;
    std::string
        wrapS; ///< "periodic" or "repeat", "black", "clamp", "mirror"; empty: the file does not say
    std::string wrapT;
    std::uint64_t bytesDecoded = 0; ///< of the base level in memory, as read

    bool Ok() const { return error.empty(); }
};

/// Reads the header only.
ImageInfo ProbeImage(const ImageSource& source);

class PageStore;
/// The same, kept in the persistent store. Errors are not kept. \param store may be null
ImageInfo ProbeImage(const ImageSource& source, PageStore* store);

} // namespace hds
