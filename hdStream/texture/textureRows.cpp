// SPDX-License-Identifier: Apache-2.0
#include "hdStream/texture/textureRows.h"

#include "hdStream/texture/halfFloat.h"
#include "hdStream/texture/srgb.h"
#include "hdStream/texture/textureLayout.h"

#include <algorithm>
#include <cmath>

namespace hds {

namespace {

constexpr int kAlphaOutput = 3;
/// Sums of a mip's texels stay finite, and squares of the blocks' errors too.
constexpr float kLargestFloat = 1e18f;
constexpr float kSmallestNormalFloat = 1.17549435e-38f; ///< devices may flush what is smaller

int ChannelOf(const ColorChannels& channels, int output) {
    const int order[4] = {channels.red, channels.green, channels.blue, channels.alpha};
    return output < 0 ? -1 : order[output];
}

/// Linear value of each code.
template <typename T>
std::vector<float> LinearTable(bool isSrgb) {
    constexpr std::size_t kNumCodes = std::size_t{1} << (8 * sizeof(T));
    std::vector<float> table(kNumCodes);
    for (std::size_t code = 0; code < kNumCodes; ++code) {
        const double value = static_cast<double>(code) / (kNumCodes - 1);
        table[code] = static_cast<float>(isSrgb ? LinearFromSrgb(value) : value);
    }
    return table;
}

} // namespace

TextureRows::TextureRows(ImageFile* file, const ColorDecoder* decoder, const TextureForm& form)
    : _file(file), _decoder(decoder), _form(form), _channels(FindColorChannels(file->Spec())),
      _limit((form.format & HDS_TEXEL_TYPE_MASK) == HDS_TEXEL_HALF && !form.dependsOnRange
                 ? kLargestHalf
                 : kLargestFloat) {
    _begin = file->Spec().nchannels;
    const auto include = [this](int channel) {
        if (channel >= 0) {
            _begin = std::min(_begin, channel);
            _end = std::max(_end, channel + 1);
        }
    };
    for (std::size_t c = 0; c < form.numChannels; ++c) {
        include(Source(c));
    }
    if (!decoder->IsPerChannel()) { // a named space mixes the colours
        include(_channels.red);
        include(_channels.green);
        include(_channels.blue);
    }
}

int TextureRows::Source(std::size_t stored) const {
    return ChannelOf(_channels, _form.sources[stored]);
}

template <typename T>
std::string TextureRows::ReadCodes(const OIIO::TypeDesc& type, const RowsCallback& onRows) {
    const std::vector<float> color = LinearTable<T>(_decoder->IsSrgb());
    const std::vector<float> alpha = LinearTable<T>(false);
    const std::size_t numChannels = _form.numChannels;
    const auto stride = static_cast<std::size_t>(_end - _begin);
    std::vector<T> stored;
    std::vector<float> linear;
    return _file->ReadBands(
        type, _begin, _end, [&](std::uint32_t, std::uint32_t rows, const void* band) {
            const std::size_t numTexels = std::size_t{rows} * _file->Width();
            stored.resize(numTexels * numChannels);
            linear.resize(stored.size());
            for (std::size_t c = 0; c < numChannels; ++c) {
                const int source = Source(c);
                const std::vector<float>& table = _form.sources[c] == kAlphaOutput ? alpha : color;
                const T* codes = static_cast<const T*>(band) + std::max(0, source - _begin);
                for (std::size_t i = 0; i < numTexels; ++i) {
                    const T code = source < 0 ? static_cast<T>(c == 3 ? -1 : 0) : codes[i * stride];
                    stored[i * numChannels + c] = code;
                    linear[i * numChannels + c] = source < 0 ? (c == 3 ? 1.0f : 0.0f) : table[code];
                }
            }
            onRows(rows, reinterpret_cast<const std::uint8_t*>(stored.data()), linear.data());
        });
}

void TextureRows::DecodeRow(const float* pixels, float* linear, TexelRepairs* repairs) {
    const std::size_t width = _file->Width();
    const auto stride = static_cast<std::size_t>(_end - _begin);
    const auto value = [&](std::size_t x, int channel) {
        const float v = pixels[x * stride + static_cast<std::size_t>(channel - _begin)];
        if (std::isfinite(v)) {
            return v;
        }
        ++repairs->numNonFinite;
        const bool isDropped = std::isnan(v) || (_form.isRadiance && v < 0.0f);
        return isDropped ? 0.0f : std::copysign(kLargestHalf, v);
    };
    const bool isMixed = !_decoder->IsPerChannel();
    if (isMixed) {
        _rgb.resize(3 * width);
        for (std::size_t x = 0; x < width; ++x) {
            _rgb[3 * x] = value(x, _channels.red);
            _rgb[3 * x + 1] = value(x, _channels.green);
            _rgb[3 * x + 2] = _channels.blue < 0 ? 0.0f : value(x, _channels.blue);
        }
        _decoder->DecodeRgb(_rgb.data(), width);
    }
    for (std::size_t c = 0; c < _form.numChannels; ++c) {
        const int output = _form.sources[c];
        const int source = Source(c);
        for (std::size_t x = 0; x < width; ++x) {
            float v = c == 3 ? 1.0f : 0.0f;
            if (source >= 0 && output != kAlphaOutput && isMixed) {
                v = _rgb[3 * x + static_cast<std::size_t>(output)];
            } else if (source >= 0) {
                v = value(x, source);
                if (output != kAlphaOutput && _decoder->IsSrgb()) {
                    v = static_cast<float>(LinearFromSrgb(v));
                }
            }
            if (!(std::abs(v) <= _limit)) {
                ++repairs->numClamped;
                v = std::isnan(v) ? 0.0f : std::copysign(_limit, v);
            }
            if (_form.isRadiance && v < 0.0f) {
                ++repairs->numNegative;
                v = 0.0f;
            }
            linear[x * _form.numChannels + c] = std::abs(v) < kSmallestNormalFloat ? 0.0f : v;
        }
    }
}

std::string TextureRows::ReadFloats(const RowsCallback& onRows, TexelRepairs* repairs) {
    const TexelConverter converter(_form.format);
    const std::size_t width = _file->Width();
    const auto stride = static_cast<std::size_t>(_end - _begin);
    std::vector<float> linear;
    std::vector<std::uint8_t> stored;
    return _file->ReadBands(
        OIIO::TypeFloat, _begin, _end, [&](std::uint32_t, std::uint32_t rows, const void* band) {
            linear.resize(std::size_t{rows} * width * _form.numChannels);
            stored.resize(std::size_t{rows} * width * TexelBytes(_form.format));
            for (std::size_t row = 0; row < rows; ++row) {
                DecodeRow(static_cast<const float*>(band) + row * width * stride,
                          &linear[row * width * _form.numChannels], repairs);
            }
            converter.Convert(linear.data(), std::size_t{rows} * width, stored.data());
            onRows(rows, stored.data(), linear.data());
        });
}

std::string TextureRows::FindRange(double* largestMagnitude) {
    TexelRepairs ignored;
    float largest = 0.0f;
    const std::size_t numChannels = _form.numChannels;
    const std::size_t rowValues = std::size_t{_file->Width()} * numChannels;
    std::string error = ReadFloats(
        [&](std::uint32_t rows, const std::uint8_t*, const float* linear) {
            for (std::size_t i = 0; i < rows * rowValues; ++i) {
                const bool isFilledIn = Source(i % numChannels) < 0;
                largest = isFilledIn ? largest : std::max(largest, std::abs(linear[i]));
            }
        },
        &ignored);
    *largestMagnitude = largest;
    return error;
}

std::string TextureRows::Read(const RowsCallback& onRows, TexelRepairs* repairs) {
    if (!_form.isVerbatim) {
        return ReadFloats(onRows, repairs);
    }
    return (_form.format & HDS_TEXEL_TYPE_MASK) == HDS_TEXEL_U8
               ? ReadCodes<std::uint8_t>(OIIO::TypeUInt8, onRows)
               : ReadCodes<std::uint16_t>(OIIO::TypeUInt16, onRows);
}

std::string WarningOf(const TexelRepairs& repairs) {
    if (repairs.numNonFinite + repairs.numClamped + repairs.numNegative == 0) {
        return {};
    }
    const std::string negative =
        repairs.numNegative > 0 ? ", " + std::to_string(repairs.numNegative) + " negative" : "";
    return std::to_string(repairs.numNonFinite) + " NaN or infinite" + negative + " and " +
           std::to_string(repairs.numClamped) + " too large values were replaced";
}

std::string ChooseForm(ImageFile* file, const ColorDecoder& decoder, TextureForm* form) {
    if (!form->dependsOnRange) {
        return {};
    }
    double largest = 0.0;
    std::string error = TextureRows(file, &decoder, *form).FindRange(&largest);
    if (FitsHalf(largest)) {
        form->format = (form->format & ~HDS_TEXEL_TYPE_MASK) | HDS_TEXEL_HALF;
    }
    form->dependsOnRange = false;
    return error;
}

} // namespace hds
