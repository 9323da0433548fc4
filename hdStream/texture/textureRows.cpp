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

CodeRows TextureRows::Codes() const {
    std::array<int, 4> places{-1, -1, -1, -1};
    for (std::size_t c = 0; c < _form.numChannels; ++c) {
        places[c] = Source(c) < 0 ? -1 : Source(c) - _begin;
    }
    return {_form, _decoder->IsSrgb(), places, static_cast<std::size_t>(_end - _begin)};
}

std::shared_ptr<const KeptImage> TextureRows::Keep(std::uint64_t maxBytes) {
    if (_form.isVerbatim) {
        const CodeRows codes = Codes();
        if (codes.RowBytes(_file->Width()) * _file->Height() <= maxBytes) {
            _kept = std::make_shared<KeptImage>(codes, _file->Width(), _file->Height());
        }
    }
    return _kept;
}

std::string TextureRows::ReadCodes(const RowCallback& onRow) {
    const CodeRows codes = Codes();
    const std::size_t width = _file->Width();
    const bool isByte = (_form.format & HDS_TEXEL_TYPE_MASK) == HDS_TEXEL_U8;
    // Row by row: what a row becomes stays in the processor's cache until it is used.
    std::vector<std::uint8_t> stored(width * TexelBytes(_form.format));
    std::vector<float> linear(width * _form.numChannels);
    return _file->ReadBands(isByte ? OIIO::TypeUInt8 : OIIO::TypeUInt16, _begin, _end,
                            [&](std::uint32_t, std::uint32_t rows, const void* band) {
                                for (std::size_t row = 0; row < rows; ++row) {
                                    const void* from = static_cast<const std::uint8_t*>(band) +
                                                       row * codes.RowBytes(width);
                                    std::uint8_t* texels =
                                        _isStoredLeftOut ? nullptr : stored.data();
                                    codes.Decode(from, width, texels, linear.data());
                                    if (_kept) {
                                        _kept->AddRow(from);
                                    }
                                    onRow(texels, linear.data());
                                }
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

std::string TextureRows::ReadFloats(const RowCallback& onRow, TexelRepairs* repairs) {
    const TexelConverter converter(_form.format);
    const std::size_t width = _file->Width();
    const auto stride = static_cast<std::size_t>(_end - _begin);
    std::vector<float> linear(width * _form.numChannels);
    std::vector<std::uint8_t> stored(width * TexelBytes(_form.format));
    return _file->ReadBands(
        OIIO::TypeFloat, _begin, _end, [&](std::uint32_t, std::uint32_t rows, const void* band) {
            for (std::size_t row = 0; row < rows; ++row) {
                DecodeRow(static_cast<const float*>(band) + row * width * stride, linear.data(),
                          repairs);
                std::uint8_t* texels = _isStoredLeftOut ? nullptr : stored.data();
                if (texels != nullptr) {
                    converter.Convert(linear.data(), width, texels);
                }
                onRow(texels, linear.data());
            }
        });
}

std::string TextureRows::FindRange(double* largestMagnitude) {
    TexelRepairs ignored;
    float largest = 0.0f;
    const std::size_t numChannels = _form.numChannels;
    const std::size_t rowValues = std::size_t{_file->Width()} * numChannels;
    std::string error = ReadFloats(
        [&](const std::uint8_t*, const float* linear) {
            for (std::size_t i = 0; i < rowValues; ++i) {
                const bool isFilledIn = Source(i % numChannels) < 0;
                largest = isFilledIn ? largest : std::max(largest, std::abs(linear[i]));
            }
        },
        &ignored);
    *largestMagnitude = largest;
    return error;
}

std::string TextureRows::Read(const RowCallback& onRow, TexelRepairs* repairs) {
    return _form.isVerbatim ? ReadCodes(onRow) : ReadFloats(onRow, repairs);
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
