// SPDX-License-Identifier: Apache-2.0
// A whole image with all its mips, uncompressed: what textures are without a cache. 8-bit images
// keep their codes, all others become linear floats. Explained in docs/texturing.md.
#pragma once

#include "hdStream/texture/imageReader.h"
#include "kernels/shared/texture.h"

#include <array>
#include <cstdint>
#include <string>
#include <vector>

namespace hds {

/// Texels of all mips, mip after mip, rows from the top, four channels.
struct PlainTexture {
    std::string error;           ///< one line that names the file; empty when all is well
    std::string warning;         ///< one line; often empty
    shared::HdsTexture record{}; ///< firstLine and numLines are 0; numMips 0 with an error
    std::vector<std::uint8_t> texels;
};

/// Decodes an image and filters its mips in linear light, by area. Thread-safe; nothing throws for
/// bad content. Values that are not finite become 0. \param colorSpace as MeanColor
PlainTexture LoadPlainTexture(const ImageSource& source, const std::string& colorSpace);

/// One channel of mip 0 in linear light, rows from the top.
std::vector<float> BaseChannel(const PlainTexture& texture, std::uint32_t channel);

/// Linear light of the 256 codes of 8-bit sRGB.
std::array<float, 256> SrgbTable();

} // namespace hds
