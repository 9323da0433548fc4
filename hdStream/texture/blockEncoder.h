// SPDX-License-Identifier: Apache-2.0
// Compresses blocks of 4x4 texels at exactly 1:2 of what they take in their stored format. The
// layout, and its decoder, is kernels/shared/textureCodec.h; the modes are explained in
// docs/texturing.md, section "Codec". Deterministic; no state; thread-safe.
#pragma once

#include "kernels/shared/texture.h"

#include <cstdint>

namespace hds {

/// Encodes one block.
/// \param format HDS_TEXEL_*
/// \param texels [16][channels] row-major, of the format's type (halves as their bits); finite
/// \param block texel_blockBytesLog2(format) says how many bytes
void EncodeBlock(std::uint32_t format, const void* texels, std::uint32_t* block);

/// The parts of it: four channels of 8 bits, one channel of 8 bits.
void EncodeColor8(const std::uint8_t* rgba, std::uint32_t* block);
/// \param stride texels[i * stride] is texel i
void EncodeScalar8(const std::uint8_t* texels, std::uint32_t stride, std::uint32_t* block);
/// Channels of 16 or 32 bits.
void EncodeWide(std::uint32_t format, const void* texels, std::uint32_t* block);

} // namespace hds
