// SPDX-License-Identifier: Apache-2.0
// Reading images of any format OpenImageIO knows, from a file or from a byte range of one (a
// texture inside a usdz package): what they are, their mean colour, and whole images for dome
// lights. Nothing here throws for bad content: results carry one line that names the file. All
// functions are thread-safe and may be called for different images at once. Explained in
// docs/texturing.md.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

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

/// The mean of an image's texels.
struct MeanColorResult {
    std::string error;   ///< one line that names the file; empty when all is well
    std::string warning; ///< one line, e.g. a colour space nobody knows; often empty
    std::array<double, 4> rgba{0, 0, 0, 1}; ///< linear working space; alpha 1 when there is none
    std::uint64_t numNonFinite = 0; ///< channel values that were NaN or infinite, counted as 0
    ImageInfo info;

    bool Ok() const { return error.empty(); }
};

/// Mean colour in linear light, summed in double precision. Gray is expanded to RGB; a missing blue
/// is 0. Channels are averaged each for itself (colour is not weighted by alpha).
/// \param colorSpace "raw", "sRGB", "auto" (or empty), as UsdUVTexture's sourceColorSpace, or the
///        name of a space of the OpenColorIO configuration (colorConfig.h)
MeanColorResult MeanColor(const ImageSource& source, const std::string& colorSpace);

/// An image as linear floats.
struct LinearImage {
    std::string error;   ///< one line that names the file; empty when all is well
    std::string warning; ///< one line; often empty
    std::uint32_t width = 0;
    std::uint32_t height = 0;
    std::vector<float> pixels; ///< RGB [height][width][3], rows from top to bottom, finite and >= 0
    std::uint64_t numNonFinite = 0; ///< channel values replaced: NaN and -Inf by 0, +Inf by 65504
    std::uint64_t numNegative = 0;  ///< channel values below 0 that were replaced by 0
    ImageInfo info;                 ///< of the file, before any downscale

    bool Ok() const { return error.empty(); }
};

/// Loads radiance (dome and rect lights). Above `maxPixels` (0: no limit) the image is reduced by a
/// box filter in linear light, which keeps its mean. Memory: the result plus one band of rows.
LinearImage LoadLinearImage(const ImageSource& source, const std::string& colorSpace,
                            std::uint64_t maxPixels);

} // namespace hds
