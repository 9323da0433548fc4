// SPDX-License-Identifier: Apache-2.0
#include "hdStream/scene/textureImages.h"

#include "hdStream/base/hash.h"
#include "hdStream/texture/textureLayout.h"

#include <algorithm>
#include <optional>
#include <utility>

namespace hds {

namespace {

/// A format that takes no less than the one the image will have (ChooseTextureForm): a conversion
/// to another space may need more than 8 bits.
std::uint32_t LargestFormat(const TextureUse& use, const std::string& colorSpace) {
    const bool isKept = colorSpace == "raw" || colorSpace == "sRGB" || colorSpace == "auto";
    const std::string& file = use.channelType;
    const bool fitsHalf = file == "uint8" || file == "int8" || file == "uint16" || file == "half";
    const std::uint32_t type = file == "uint8" && isKept ? HDS_TEXEL_U8
                               : fitsHalf                ? HDS_TEXEL_HALF
                                                         : HDS_TEXEL_FLOAT;
    return type | (use.channels > 2 ? 2U : use.channels - 1U);
}

std::uint64_t MaxLinesOf(const TextureUse& use, const std::string& colorSpace) {
    if (!use.error.empty() || use.width == 0 || use.height == 0 || use.channels == 0 ||
        std::max(use.width, use.height) > HDS_TEXTURE_MAX_SIZE) {
        return 1; // the fallback
    }
    return MakeTextureLayout(use.width, use.height, LargestFormat(use, colorSpace)).numLines;
}

} // namespace

std::vector<TextureImage> MakeTextureImages(const std::vector<MaterialTexture>& textures,
                                            const ImageLibrary& library) {
    std::vector<TextureImage> images;
    for (const MaterialTexture& texture : textures) {
        TextureImage image;
        image.source = SourceOf(texture.file);
        image.request = RequestOf(texture);
        Hasher hasher;
        hasher.Append(MaterialTextureKey(texture));
        hasher.Append(std::uint64_t{texture.channels});
        hasher.Append(library.Epoch());
        image.id = hasher.Words()[0];
        if (const std::optional<TextureUse> use = library.FindUse(texture.file)) {
            image.maxLines = MaxLinesOf(*use, texture.colorSpace);
        }
        images.push_back(std::move(image));
    }
    return images;
}

} // namespace hds
