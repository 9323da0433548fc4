// SPDX-License-Identifier: Apache-2.0
// How the mips of a texture are laid out in lines: a pure function of its size and format.
// Explained in docs/texturing.md, section "Lines".
#pragma once

#include "kernels/shared/texture.h"

#include <cstdint>

namespace hds {

/// The record of a texture whose firstLine is 0, without flags, RGBA as stored.
/// \param width, height 1 to HDS_TEXTURE_MAX_SIZE
shared::HdsTexture MakeTextureLayout(std::uint32_t width, std::uint32_t height,
                                     std::uint32_t format);

/// Makes it a texture of one line that holds for every texel.
void MakeConstant(shared::HdsTexture* texture);

/// Bytes of a texel as it is stored before compression.
std::uint32_t TexelBytes(std::uint32_t format);

/// The place of a texel of a texture.
shared::HdsTexelPlace PlaceOf(const shared::HdsTexture& texture, std::uint32_t mip, std::uint32_t x,
                              std::uint32_t y);

/// The first line of a mip. \pre not constant
std::uint32_t FirstLineOf(const shared::HdsTexture& texture, std::uint32_t mip);

/// The mip that a line is of; of the line that several share, the finest. \pre not constant
std::uint32_t MipOfLine(const shared::HdsTexture& texture, std::uint32_t line);

} // namespace hds
