// SPDX-License-Identifier: Apache-2.0
#include "hdStream/texture/textureForm.h"

#include "hdStream/texture/halfFloat.h"

#include <algorithm>
#include <vector>

namespace hds {

namespace {

constexpr int kAlphaOutput = 3;

/// The outputs that are both wanted and in the file. Gray is the red output alone.
std::vector<int> StoredOutputs(const ColorChannels& file, std::uint32_t wanted) {
    const bool isGray = file.red == file.green;
    const bool wantsColor = (wanted & ~TextureRequest::kAlpha) != 0;
    std::vector<int> outputs;
    for (int output = 0; output < kAlphaOutput; ++output) {
        const bool isThere = output < 2 || file.blue >= 0;
        const bool isWanted = isGray ? wantsColor && output == 0
                                     : ((wanted >> static_cast<unsigned>(output)) & 1u) != 0;
        if (isThere && isWanted) {
            outputs.push_back(output);
        }
    }
    if (file.alpha >= 0 && (wanted & TextureRequest::kAlpha) != 0) {
        outputs.push_back(kAlphaOutput);
    }
    if (outputs.empty()) { // nothing of the file is read: the least there is
        outputs.push_back(0);
    }
    return outputs;
}

/// Output channel for output channel the component of the decoded texel. Outputs that the file
/// lacks are 0 and alpha 1, which is what channels that are not stored decode to.
std::uint32_t SwizzleOf(const std::vector<int>& outputs, bool isGray) {
    std::uint32_t swizzle = 0;
    for (int output = 0; output < 4; ++output) {
        std::uint32_t component = output == kAlphaOutput ? 3 : 2;
        for (std::size_t i = 0; i < outputs.size(); ++i) {
            const bool isIt =
                isGray && output < kAlphaOutput ? outputs[i] == 0 : outputs[i] == output;
            if (isIt) {
                component = static_cast<std::uint32_t>(i);
            }
        }
        swizzle |= component << (2 * output);
    }
    return swizzle;
}

/// Chooses the type of a channel.
void ChooseType(const OIIO::TypeDesc& fileType, const ColorDecoder& decoder, TextureForm* form) {
    const bool isByte = fileType == OIIO::TypeUInt8;
    const bool isShort = fileType == OIIO::TypeUInt16;
    if (decoder.IsPerChannel() && (isByte || (isShort && !decoder.IsSrgb()))) {
        form->isVerbatim = true;
        form->format |= isByte ? HDS_TEXEL_U8 : HDS_TEXEL_U16;
    } else if (isByte || isShort || fileType.size() < 2 || fileType == OIIO::TypeHalf) {
        form->format |= HDS_TEXEL_HALF;
    } else {
        // One channel of floats is heights or other data: the precision stays.
        form->format |= HDS_TEXEL_FLOAT;
        form->dependsOnRange = form->numChannels > 1;
    }
}

} // namespace

bool FitsHalf(double largestMagnitude) {
    // Below 2^-14 halves are multiples of 2^-24: beside 2^-6 that is an error of 2^-19.
    constexpr double kLeast = 0.015625;
    return largestMagnitude <= kLargestHalf &&
           (largestMagnitude >= kLeast || largestMagnitude == 0.0);
}

TextureForm ChooseTextureForm(const ImageFile& file, const ColorDecoder& decoder,
                              const TextureRequest& request) {
    const ColorChannels channels = FindColorChannels(file.Spec());
    const bool isGray = channels.red == channels.green;
    std::vector<int> outputs = StoredOutputs(channels, request.channels);
    if (outputs.size() == 3) { // at the rate of four; without alpha, its bits go to the others
        const bool hasAlpha = outputs.back() == kAlphaOutput;
        outputs =
            hasAlpha ? std::vector<int>{0, 1, 2, kAlphaOutput} : std::vector<int>{0, 1, 2, -1};
    }
    TextureForm form;
    form.isRadiance = request.isRadiance;
    form.numChannels = static_cast<std::uint32_t>(outputs.size());
    std::copy(outputs.begin(), outputs.end(), form.sources.begin());
    form.swizzle = form.numChannels == 4 ? HDS_SWIZZLE_RGBA : SwizzleOf(outputs, isGray);
    form.format = form.numChannels == 4 ? 2 : form.numChannels - 1;
    ChooseType(file.Spec().format, decoder, &form);
    const bool hasColor = outputs.front() != kAlphaOutput;
    if (form.isVerbatim && decoder.IsSrgb() && hasColor) {
        form.format |= HDS_TEXEL_SRGB;
        if (form.numChannels == 2 && outputs[1] == kAlphaOutput) {
            form.format |= HDS_TEXEL_SECOND_IS_ALPHA;
        }
    }
    return form;
}

} // namespace hds
