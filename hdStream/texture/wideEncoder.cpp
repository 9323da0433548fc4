// SPDX-License-Identifier: Apache-2.0
// Channels of 16 and 32 bits. See blockEncoder.h.
#include "hdStream/texture/blockEncoder.h"
#include "kernels/shared/textureCodec.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>

namespace hds {

namespace {

/// One channel of a block: bits as stored, values, and bits in the order of the values.
struct Channel {
    std::array<std::uint32_t, 16> bits;
    std::array<std::uint32_t, 16> order;
    std::array<float, 16> values;
};

/// An interval and the indices into it.
struct Coded {
    std::uint32_t first = 0;
    std::uint32_t second = 0;
    std::array<std::uint32_t, 16> q{};
};

Channel LoadChannel(const void* texels, std::uint32_t type, std::size_t channel,
                    std::size_t numChannels) {
    Channel out;
    for (std::size_t i = 0; i < 16; ++i) {
        const std::size_t at = i * numChannels + channel;
        if (type == HDS_TEXEL_FLOAT) {
            std::memcpy(&out.bits[i], static_cast<const float*>(texels) + at, 4);
            out.order[i] = shared::codec_orderOfFloat(out.bits[i]);
            out.values[i] = shared::FloatOfBits(out.bits[i]);
            continue;
        }
        out.bits[i] = static_cast<const std::uint16_t*>(texels)[at];
        const bool isHalf = type == HDS_TEXEL_HALF;
        out.order[i] = isHalf ? shared::codec_orderOfHalf(out.bits[i]) : out.bits[i];
        out.values[i] =
            isHalf ? shared::codec_floatOfHalf(out.bits[i]) : static_cast<float>(out.bits[i]);
    }
    return out;
}

/// Interpolates the values.
Coded CodeLinear(const Channel& channel, std::uint32_t numBits) {
    const auto [low, high] = std::minmax_element(channel.order.begin(), channel.order.end());
    const auto first = static_cast<std::size_t>(low - channel.order.begin());
    const auto second = static_cast<std::size_t>(high - channel.order.begin());
    Coded coded;
    coded.first = channel.bits[first];
    coded.second = channel.bits[second];
    const double last = (1u << numBits) - 1u;
    const double begin = channel.values[first];
    const double range = static_cast<double>(channel.values[second]) - begin;
    const double scale = range > 0.0 ? last / range : 0.0;
    for (std::size_t i = 0; i < 16; ++i) {
        coded.q[i] = static_cast<std::uint32_t>((channel.values[i] - begin) * scale + 0.5);
    }
    return coded;
}

/// Interpolates the ordered bits. The ends differ.
Coded CodeOrdered(const Channel& channel, std::uint32_t numBits) {
    const auto [low, high] = std::minmax_element(channel.order.begin(), channel.order.end());
    Coded coded;
    coded.first = channel.bits[static_cast<std::size_t>(high - channel.order.begin())];
    coded.second = channel.bits[static_cast<std::size_t>(low - channel.order.begin())];
    const double scale = ((1u << numBits) - 1u) / static_cast<double>(*high - *low);
    for (std::size_t i = 0; i < 16; ++i) {
        coded.q[i] = static_cast<std::uint32_t>((channel.order[i] - *low) * scale + 0.5);
    }
    return coded;
}

/// Sum of square errors, each relative to its value, but not below a hundredth of the largest.
double RelativeError(const Channel& channel, const Coded& coded, std::uint32_t type,
                     std::uint32_t numBits) {
    float largest = 0.0f;
    for (const float value : channel.values) {
        largest = std::max(largest, std::abs(value));
    }
    const std::uint32_t ends = coded.first | (coded.second << 16);
    double sum = 0.0;
    for (std::size_t i = 0; i < 16; ++i) {
        const float value = type == HDS_TEXEL_FLOAT
                                ? shared::codec_value32(coded.first, coded.second, coded.q[i])
                                : shared::codec_value16(ends, coded.q[i], numBits, type);
        const double error = (static_cast<double>(value) - channel.values[i]) /
                             (std::abs(channel.values[i]) + 0.01 * largest);
        sum += error * error;
    }
    return sum;
}

/// Colours of a high range keep their dark values where the interval spans many octaves; data (one
/// or two channels) keeps its absolute precision.
Coded CodeColor(const Channel& channel, std::uint32_t type, std::uint32_t numBits) {
    const Coded linear = CodeLinear(channel, numBits);
    if (type == HDS_TEXEL_U16) {
        return linear;
    }
    const auto [low, high] = std::minmax_element(channel.order.begin(), channel.order.end());
    if (*low == *high) {
        return linear; // one value, or the two zeros
    }
    const Coded ordered = CodeOrdered(channel, numBits);
    return RelativeError(channel, ordered, type, numBits) <
                   RelativeError(channel, linear, type, numBits)
               ? ordered
               : linear;
}

void WriteScalar16(const Coded& coded, std::uint32_t* block) {
    block[0] = coded.first | (coded.second << 16);
    std::fill_n(block + 1, 3, 0u);
    for (std::size_t i = 0; i < 16; ++i) {
        block[1 + i / 8] |= (coded.q[i] & 15u) << (4 * (i % 8));
        block[3] |= (coded.q[i] >> 4) << (2 * i);
    }
}

void WriteScalar32(const Coded& coded, std::uint32_t* block) {
    block[0] = coded.first;
    block[1] = coded.second;
    std::fill_n(block + 2, 6, 0u);
    for (std::size_t i = 0; i < 16; ++i) {
        block[2 + i / 4] |= (coded.q[i] & 255u) << (8 * (i % 4));
        block[6 + i / 8] |= (coded.q[i] >> 8) << (4 * (i % 8));
    }
}

void EncodeColor16(const void* texels, std::uint32_t type, std::uint32_t* block) {
    const Channel alpha = LoadChannel(texels, type, 3, 4);
    const auto [low, high] = std::minmax_element(alpha.order.begin(), alpha.order.end());
    const bool isAlphaConstant = *low == *high;
    const std::uint32_t numBits = isAlphaConstant ? 8 : 6;
    std::array<std::uint32_t, 16> index{};
    for (std::uint32_t c = 0; c < 4; ++c) {
        Coded coded = c < 3 ? CodeColor(LoadChannel(texels, type, c, 4), type, numBits)
                            : CodeLinear(alpha, numBits);
        if (c == 3 && isAlphaConstant) { // equal bits are the mark: the two zeros are not
            coded.second = coded.first;
        }
        block[c] = coded.first | (coded.second << 16);
        for (std::size_t i = 0; i < 16 && (c < 3 || !isAlphaConstant); ++i) {
            index[i] |= coded.q[i] << (numBits * c);
        }
    }
    std::fill_n(block + 4, 12, 0u);
    for (std::size_t i = 0; i < 16; ++i) {
        for (std::size_t plane = 0; plane < 3; ++plane) {
            block[4 + 4 * plane + i / 4] |= ((index[i] >> (8 * plane)) & 255u) << (8 * (i % 4));
        }
    }
}

} // namespace

void EncodeWide(std::uint32_t format, const void* texels, std::uint32_t* block) {
    const std::uint32_t type = format & HDS_TEXEL_TYPE_MASK;
    const std::size_t numChannels = std::size_t{1} << (format & HDS_TEXEL_CHANNELS_LOG2_MASK);
    if (type != HDS_TEXEL_FLOAT && numChannels == 4) {
        EncodeColor16(texels, type, block);
        return;
    }
    for (std::size_t c = 0; c < numChannels; ++c) {
        const Channel channel = LoadChannel(texels, type, c, numChannels);
        if (type == HDS_TEXEL_FLOAT) {
            const bool isColor = numChannels == 4 && c < 3;
            WriteScalar32(isColor ? CodeColor(channel, type, 12) : CodeLinear(channel, 12),
                          block + 8 * c);
        } else {
            WriteScalar16(CodeLinear(channel, 6), block + 4 * c);
        }
    }
}

} // namespace hds
