// SPDX-License-Identifier: Apache-2.0
#include "hdStream/texture/halfFloat.h"
#include "hdStream/texture/srgb.h"
#include "hdStream/texture/textureRows.h"

#include <algorithm>
#include <cstring>

namespace hds {

namespace {

constexpr std::size_t kNumGuesses = 4096;

} // namespace

TexelConverter::TexelConverter(std::uint32_t format)
    : _format(format), _numChannels(1u << (format & HDS_TEXEL_CHANNELS_LOG2_MASK)) {
    if ((format & HDS_TEXEL_SRGB) == 0) {
        return;
    }
    // Halfway between two codes as numbers: the encoded values are what is to be kept.
    for (int code = 0; code < 255; ++code) {
        _thresholds.push_back(static_cast<float>(LinearFromSrgb((code + 0.5) / 255.0)));
    }
    for (std::size_t part = 0; part < kNumGuesses; ++part) {
        const float begin = static_cast<float>(part) / kNumGuesses;
        const auto code = std::upper_bound(_thresholds.begin(), _thresholds.end(), begin);
        _guess.push_back(static_cast<std::uint8_t>(code - _thresholds.begin()));
    }
}

std::uint8_t TexelConverter::ByteOf(float linear, bool isEncoded) const {
    if (!isEncoded) {
        return static_cast<std::uint8_t>(std::clamp(linear, 0.0f, 1.0f) * 255.0f + 0.5f);
    }
    if (linear >= 1.0f) {
        return 255;
    }
    std::size_t code =
        linear > 0.0f ? _guess[static_cast<std::size_t>(linear * float{kNumGuesses})] : 0;
    while (code < _thresholds.size() && linear >= _thresholds[code]) {
        ++code;
    }
    return static_cast<std::uint8_t>(code);
}

void TexelConverter::Convert(const float* linear, std::size_t numTexels,
                             std::uint8_t* stored) const {
    const std::size_t numValues = numTexels * _numChannels;
    switch (_format & HDS_TEXEL_TYPE_MASK) {
    case HDS_TEXEL_U8: {
        const bool isSrgb = (_format & HDS_TEXEL_SRGB) != 0;
        const bool hasAlpha = _numChannels == 4 || (_format & HDS_TEXEL_SECOND_IS_ALPHA) != 0;
        for (std::size_t i = 0; i < numValues; i += _numChannels) {
            for (std::size_t c = 0; c < _numChannels; ++c) {
                const bool isAlpha = hasAlpha && c + 1 == _numChannels;
                stored[i + c] = ByteOf(linear[i + c], isSrgb && !isAlpha);
            }
        }
        return;
    }
    case HDS_TEXEL_U16:
        for (std::size_t i = 0; i < numValues; ++i) {
            const auto code =
                static_cast<std::uint16_t>(std::clamp(linear[i], 0.0f, 1.0f) * 65535.0f + 0.5f);
            std::memcpy(stored + 2 * i, &code, sizeof(code));
        }
        return;
    case HDS_TEXEL_HALF:
        for (std::size_t i = 0; i < numValues; ++i) {
            const std::uint16_t half =
                HalfOfFloat(std::clamp(linear[i], -kLargestHalf, kLargestHalf));
            std::memcpy(stored + 2 * i, &half, sizeof(half));
        }
        return;
    default:
        std::memcpy(stored, linear, numValues * sizeof(float));
    }
}

} // namespace hds
