// SPDX-License-Identifier: Apache-2.0
// All stored texture formats, and texels of them: random, but like an image within a block.
#pragma once

#include "hdStream/texture/halfFloat.h"
#include "hdStream/texture/textureLayout.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <random>
#include <vector>

namespace hds::test {

inline std::vector<std::uint32_t> AllTexelFormats() {
    std::vector<std::uint32_t> formats;
    for (const std::uint32_t type :
         {HDS_TEXEL_U8, HDS_TEXEL_U16, HDS_TEXEL_HALF, HDS_TEXEL_FLOAT}) {
        for (std::uint32_t channelsLog2 = 0; channelsLog2 < 3; ++channelsLog2) {
            formats.push_back(type | channelsLog2);
        }
    }
    for (std::uint32_t channelsLog2 = 0; channelsLog2 < 3; ++channelsLog2) {
        formats.push_back(HDS_TEXEL_U8 | channelsLog2 | HDS_TEXEL_SRGB);
    }
    formats.push_back(HDS_TEXEL_U8 | 1u | HDS_TEXEL_SRGB | HDS_TEXEL_SECOND_IS_ALPHA);
    return formats;
}

/// A block's stored texels: per channel a base, a slope in x and y, and noise, each of random size,
/// and now and then one value only, or (the last channel) one.
inline std::vector<std::uint8_t> RandomBlock(std::uint32_t format, std::mt19937& generator) {
    const std::size_t numChannels = std::size_t{1} << (format & HDS_TEXEL_CHANNELS_LOG2_MASK);
    std::uniform_real_distribution<double> uniform(-1.0, 1.0);
    const auto size = [&] { return std::pow(uniform(generator), 4) * (uniform(generator) > 0); };
    std::vector<std::uint8_t> texels(std::size_t{16} * TexelBytes(format));
    for (std::size_t c = 0; c < numChannels; ++c) {
        const double base = 0.5 + 0.5 * uniform(generator);
        const double slope[2] = {0.1 * uniform(generator) * size(), 0.1 * size()};
        const double noise = size();
        const bool isOne = c == 3 && generator() % 2 == 0;
        const double exponent = generator() % 4 == 0 ? 10.0 * uniform(generator) : 0.0;
        for (std::size_t i = 0; i < 16; ++i) {
            const double value = isOne ? 1.0
                                       : base + slope[0] * double(i % 4) +
                                             slope[1] * double(i / 4) + noise * uniform(generator);
            const std::size_t at = i * numChannels + c;
            const double unit = std::min(1.0, std::max(0.0, value));
            const float wide =
                isOne ? 1.0f : static_cast<float>((value - 0.3) * std::exp2(exponent));
            const auto byte = static_cast<std::uint8_t>(std::lround(unit * 255));
            const std::uint16_t half = (format & HDS_TEXEL_TYPE_MASK) == HDS_TEXEL_U16
                                           ? static_cast<std::uint16_t>(std::lround(unit * 65535))
                                           : HalfOfFloat(wide);
            switch (TexelBytes(format) / numChannels) {
            case 1:
                texels[at] = byte;
                break;
            case 2:
                std::memcpy(&texels[2 * at], &half, 2);
                break;
            default:
                std::memcpy(&texels[4 * at], &wide, 4);
            }
        }
    }
    return texels;
}

} // namespace hds::test
