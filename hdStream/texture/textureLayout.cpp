// SPDX-License-Identifier: Apache-2.0
#include "hdStream/texture/textureLayout.h"

#include "hdStream/base/error.h"

#include <algorithm>

namespace hds {

namespace {

std::uint32_t BlocksAcross(std::uint32_t texels) {
    return (texels + 3) / 4;
}

std::uint32_t RoundedUp(std::uint32_t value, std::uint32_t log2) {
    return (value + (1u << log2) - 1) >> log2;
}

} // namespace

shared::HdsTexture MakeTextureLayout(std::uint32_t width, std::uint32_t height,
                                     std::uint32_t format) {
    HDS_VERIFY(width >= 1 && height >= 1 && std::max(width, height) <= HDS_TEXTURE_MAX_SIZE,
               "a texture of that size has no layout");
    shared::HdsTexture texture{};
    texture.width = width;
    texture.height = height;
    texture.format = format;
    texture.swizzle = HDS_SWIZZLE_RGBA;
    while ((std::max(width, height) >> texture.numMips) > 0) {
        ++texture.numMips;
    }
    const std::uint32_t acrossLog2 = shared::texel_lineWidthLog2(format);
    const std::uint32_t downLog2 = shared::texel_lineHeightLog2(format);
    const auto blocksOf = [&](std::uint32_t mip) {
        return std::uint64_t{BlocksAcross(shared::texture_mipSize(width, mip))} *
               BlocksAcross(shared::texture_mipSize(height, mip));
    };
    // The last line takes as many of the coarsest mips as it can hold together.
    std::uint32_t firstShared = texture.numMips;
    for (std::uint64_t blocks = 0; firstShared > 0; --firstShared) {
        blocks += blocksOf(firstShared - 1);
        if (blocks > (std::uint64_t{1} << (acrossLog2 + downLog2))) {
            break;
        }
    }
    for (std::uint32_t mip = 0; mip < firstShared; ++mip) {
        texture.mipBlock[mip] = texture.numLines << (acrossLog2 + downLog2);
        texture.numLines +=
            RoundedUp(BlocksAcross(shared::texture_mipSize(width, mip)), acrossLog2) *
            RoundedUp(BlocksAcross(shared::texture_mipSize(height, mip)), downLog2);
    }
    std::uint32_t block = texture.numLines << (acrossLog2 + downLog2);
    for (std::uint32_t mip = firstShared; mip < texture.numMips; ++mip) {
        texture.mipBlock[mip] = block;
        block += static_cast<std::uint32_t>(blocksOf(mip));
    }
    ++texture.numLines;
    return texture;
}

void MakeConstant(shared::HdsTexture* texture) {
    texture->flags |= HDS_TEXTURE_CONSTANT;
    texture->numLines = 1;
    std::fill(std::begin(texture->mipBlock), std::end(texture->mipBlock), 0u);
}

std::uint32_t TexelBytes(std::uint32_t format) {
    return (1u << shared::texel_blockBytesLog2(format)) / 8 /* 16 texels, half of their bytes */;
}

shared::HdsTexelPlace PlaceOf(const shared::HdsTexture& texture, std::uint32_t mip, std::uint32_t x,
                              std::uint32_t y) {
    return shared::texture_place(texture.width, texture.format, texture.flags, texture.numLines,
                                 texture.mipBlock[mip], mip, x, y);
}

std::uint32_t FirstLineOf(const shared::HdsTexture& texture, std::uint32_t mip) {
    const std::uint32_t blocksLog2 =
        shared::texel_lineWidthLog2(texture.format) + shared::texel_lineHeightLog2(texture.format);
    return texture.mipBlock[mip] >> blocksLog2;
}

std::uint32_t MipOfLine(const shared::HdsTexture& texture, std::uint32_t line) {
    std::uint32_t mip = 0;
    while (mip + 1 < texture.numMips && FirstLineOf(texture, mip) < line &&
           FirstLineOf(texture, mip + 1) <= line) {
        ++mip;
    }
    return mip;
}

} // namespace hds
