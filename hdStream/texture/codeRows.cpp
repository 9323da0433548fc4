// SPDX-License-Identifier: Apache-2.0
#include "hdStream/texture/codeRows.h"

#include "hdStream/texture/srgb.h"

#include <cstring>
#include <limits>

namespace hds {

namespace {

constexpr std::size_t kAlphaOutput = 3;

std::vector<float> LinearTable(std::size_t numCodes, bool isSrgb) {
    std::vector<float> table(numCodes);
    for (std::size_t code = 0; code < numCodes; ++code) {
        const double value = static_cast<double>(code) / static_cast<double>(numCodes - 1);
        table[code] = static_cast<float>(isSrgb ? LinearFromSrgb(value) : value);
    }
    return table;
}

/// The code of a channel that the file lacks.
template <typename T>
T FilledIn(std::size_t channel) {
    return channel == kAlphaOutput ? std::numeric_limits<T>::max() : T{0};
}

} // namespace

CodeRows::CodeRows(const TextureForm& form, bool isSrgb, const std::array<int, 4>& places,
                   std::size_t numPixelChannels)
    : _isWide((form.format & HDS_TEXEL_TYPE_MASK) == HDS_TEXEL_U16), _numChannels(form.numChannels),
      _places(places), _stride(numPixelChannels) {
    const std::size_t numCodes = std::size_t{1} << (_isWide ? 16 : 8);
    _color = LinearTable(numCodes, isSrgb);
    _alpha = LinearTable(numCodes, false);
    for (std::size_t c = 0; c < _numChannels; ++c) {
        _isAlpha[c] = form.sources[c] == static_cast<int>(kAlphaOutput);
    }
}

std::size_t CodeRows::RowBytes(std::size_t width) const {
    return width * _stride * (_isWide ? 2 : 1);
}

template <typename T>
void CodeRows::DecodeAs(const T* codes, std::size_t width, std::uint8_t* stored,
                        float* linear) const {
    if (_numChannels == 4 && _places[0] >= 0 && _places[1] >= 0 && _places[2] >= 0) {
        DecodeColors(codes, width, stored, linear);
        return;
    }
    for (std::size_t c = 0; c < _numChannels; ++c) {
        const float* table = (_isAlpha[c] ? _alpha : _color).data();
        const bool isFilledIn = _places[c] < 0;
        const T filledIn = FilledIn<T>(c);
        const T* source = codes + (isFilledIn ? 0 : _places[c]);
        for (std::size_t x = 0; x < width; ++x) {
            const T code = isFilledIn ? filledIn : source[x * _stride];
            if (stored != nullptr) {
                std::memcpy(stored + (x * _numChannels + c) * sizeof(T), &code, sizeof(T));
            }
            if (linear != nullptr) {
                linear[x * _numChannels + c] = table[code];
            }
        }
    }
}

/// Colours of three channels, with or without alpha: most images, texel by texel.
template <typename T>
void CodeRows::DecodeColors(const T* codes, std::size_t width, std::uint8_t* stored,
                            float* linear) const {
    const T* red = codes + _places[0];
    const T* green = codes + _places[1];
    const T* blue = codes + _places[2];
    const T opaque = FilledIn<T>(3);
    const T* alpha = _places[3] < 0 ? &opaque : codes + _places[3];
    const std::size_t alphaStride = _places[3] < 0 ? 0 : _stride;
    const float* color = _color.data();
    for (std::size_t x = 0; x < width && stored != nullptr; ++x) {
        const std::size_t at = x * _stride;
        const T texel[4] = {red[at], green[at], blue[at], alpha[x * alphaStride]};
        std::memcpy(stored + x * sizeof(texel), texel, sizeof(texel));
    }
    for (std::size_t x = 0; x < width && linear != nullptr; ++x) {
        const std::size_t at = x * _stride;
        linear[4 * x] = color[red[at]];
        linear[4 * x + 1] = color[green[at]];
        linear[4 * x + 2] = color[blue[at]];
        linear[4 * x + 3] = _alpha[alpha[x * alphaStride]];
    }
}

void CodeRows::Decode(const void* codes, std::size_t width, std::uint8_t* stored,
                      float* linear) const {
    if (_isWide) {
        DecodeAs(static_cast<const std::uint16_t*>(codes), width, stored, linear);
    } else {
        DecodeAs(static_cast<const std::uint8_t*>(codes), width, stored, linear);
    }
}

} // namespace hds
