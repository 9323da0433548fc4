// SPDX-License-Identifier: Apache-2.0
// A whole image with all its mips, in the format that it would be prepared in but not compressed:
// what textures are without a cache. Explained in docs/texturing.md.
#pragma once

#include "hdStream/texture/imageReader.h"
#include "hdStream/texture/textureForm.h"
#include "kernels/shared/texture.h"

#include <cstdint>
#include <string>
#include <vector>

namespace hds {

/// Texels of all mips, rows from the top; each mip begins at a multiple of 16 bytes.
struct PlainTexture {
    std::string error;   ///< one line that names the file; empty when all is well
    std::string warning; ///< one line; often empty
    /// HDS_TEXTURE_MISSING with an error. mipBlock[m]: where mip m begins, in units of 16 bytes.
    shared::HdsTexture record{};
    std::vector<std::uint8_t> texels;
};

/// Decodes an image and filters its mips. Thread-safe; nothing throws for bad content.
PlainTexture LoadPlainTexture(const ImageSource& source, const TextureRequest& request);

/// One channel of an image in linear light.
struct PlainChannel {
    std::string error;   ///< as PlainTexture
    std::string warning; ///< as PlainTexture
    std::uint32_t width = 0;
    std::uint32_t height = 0;
    std::vector<float> values; ///< rows from the top, finite
};

/// \param channel 0 to 3: R, G, B, A; gray is R, G and B, what the file lacks is 0, alpha 1
PlainChannel LoadPlainChannel(const ImageSource& source, const std::string& colorSpace,
                              std::uint32_t channel);

} // namespace hds
