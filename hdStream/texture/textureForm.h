// SPDX-License-Identifier: Apache-2.0
// In which format a texture is stored: no channel that nobody reads or the file lacks, no precision
// that the file lacks or the renderer cannot use. Explained in docs/texturing.md, section
// "Formats".
#pragma once

#include "hdStream/base/fields.h"
#include "hdStream/texture/colorDecoder.h"
#include "hdStream/texture/imageFile.h"
#include "kernels/shared/texture.h"

#include <array>
#include <cstdint>
#include <string>

namespace hds {

/// What is wanted of an image. Equal files and requests are one texture.
struct TextureRequest {
    static constexpr std::uint32_t kRed = 1;
    static constexpr std::uint32_t kGreen = 2;
    static constexpr std::uint32_t kBlue = 4;
    static constexpr std::uint32_t kAlpha = 8;

    /// "raw", "sRGB", "auto", or the name of a space of the OpenColorIO configuration.
    std::string colorSpace = "auto";
    /// The outputs that anybody reads; what the others are is then undefined.
    std::uint32_t channels = kRed | kGreen | kBlue | kAlpha;
    /// What a light emits: values below 0 become 0.
    bool isRadiance = false;

    static constexpr auto Fields() {
        return FieldList(HDS_FIELD(TextureRequest, colorSpace), HDS_FIELD(TextureRequest, channels),
                         HDS_FIELD(TextureRequest, isRadiance));
    }
};

/// A stored format, and where its channels come from.
struct TextureForm {
    std::uint32_t format = HDS_TEXEL_U8; ///< HDS_TEXEL_*
    std::uint32_t swizzle = HDS_SWIZZLE_RGBA;
    std::uint32_t numChannels = 0;              ///< 1, 2 or 4
    std::array<int, 4> sources{-1, -1, -1, -1}; ///< output (0 R, 1 G, 2 B, 3 A) of each; -1: 0 or 1
    /// The values are the file's own codes; else they are decoded and converted.
    bool isVerbatim = false;
    /// Half or float is to be decided by TextureRows::FindRange.
    bool dependsOnRange = false;
    bool isRadiance = false; ///< as TextureRequest::isRadiance
};

/// \param decoder of the image, for the request's colour space
TextureForm ChooseTextureForm(const ImageFile& file, const ColorDecoder& decoder,
                              const TextureRequest& request);

/// Whether halves keep images whose magnitudes go up to this one: none is too large, and none that
/// matters so small that a half has less than its 11 bits.
bool FitsHalf(double largestMagnitude);

} // namespace hds
