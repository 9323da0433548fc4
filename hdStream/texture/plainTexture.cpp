// SPDX-License-Identifier: Apache-2.0
#include "hdStream/texture/plainTexture.h"

#include "hdStream/texture/colorDecoder.h"
#include "hdStream/texture/imageFile.h"
#include "hdStream/texture/srgb.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <memory>
#include <new>

namespace hds {

namespace {

constexpr std::size_t kChannels = 4;

/// RGBA in linear light.
struct Level {
    std::uint32_t width = 0;
    std::uint32_t height = 0;
    std::vector<float> texels;
};

/// Halves one axis by area: target i of n covers sources [i * size / n, (i + 1) * size / n).
/// \param stride floats from a texel to the next on the axis. \param add adds weight * source.
template <typename Add>
void CoverAxis(std::uint32_t size, std::uint32_t target, const Add& add) {
    for (std::uint64_t i = 0; i < target; ++i) {
        const std::uint64_t begin = i * size;
        const std::uint64_t end = begin + size;
        for (std::uint64_t j = begin / target; j * target < end; ++j) {
            const std::uint64_t overlap =
                std::min(end, (j + 1) * target) - std::max(begin, j * target);
            add(i, j, static_cast<float>(static_cast<double>(overlap) / size));
        }
    }
}

Level Halve(const Level& source) {
    Level wide{std::max(1U, source.width / 2), source.height, {}};
    wide.texels.resize(kChannels * wide.width * wide.height);
    CoverAxis(source.width, wide.width, [&](std::uint64_t i, std::uint64_t j, float weight) {
        for (std::size_t row = 0; row < source.height; ++row) {
            const float* from = &source.texels[kChannels * (row * source.width + j)];
            float* to = &wide.texels[kChannels * (row * wide.width + i)];
            for (std::size_t c = 0; c < kChannels; ++c) {
                to[c] += weight * from[c];
            }
        }
    });
    Level result{wide.width, std::max(1U, source.height / 2), {}};
    result.texels.resize(kChannels * result.width * result.height);
    const std::size_t rowFloats = kChannels * wide.width;
    CoverAxis(wide.height, result.height, [&](std::uint64_t i, std::uint64_t j, float weight) {
        const float* from = &wide.texels[j * rowFloats];
        float* to = &result.texels[i * rowFloats];
        for (std::size_t k = 0; k < rowFloats; ++k) {
            to[k] += weight * from[k];
        }
    });
    return result;
}

class Loader {
public:
    Loader(ImageFile& file, const ColorDecoder& decoder, PlainTexture* texture)
        : _file(file), _decoder(decoder), _texture(*texture),
          _channels(FindColorChannels(file.Spec())) {
        _isEightBit = decoder.IsPerChannel() && file.Spec().format == OIIO::TypeUInt8;
        const bool isSrgb = _isEightBit && decoder.DecodeChannel(0.5) != 0.5;
        _texture.record.width = file.Width();
        _texture.record.height = file.Height();
        _texture.record.format = _isEightBit ? HDS_TEXEL_RGBA8 : HDS_TEXEL_RGBAFLOAT;
        _texture.record.flags = isSrgb ? HDS_TEXTURE_SRGB : 0U;
    }

    void Run() {
        Level level = ReadBase();
        if (!_texture.error.empty()) {
            return;
        }
        while (true) {
            Append(level);
            ++_texture.record.numMips;
            if (level.width == 1 && level.height == 1) {
                return;
            }
            level = Halve(level);
        }
    }

private:
    Level ReadBase() {
        Level level{_file.Width(), _file.Height(), {}};
        level.texels.resize(kChannels * level.width * level.height);
        const int begin = _channels.Begin();
        const auto stride = static_cast<std::size_t>(_channels.End() - begin);
        std::vector<float> rgb(std::size_t{3} * level.width);
        _texture.error = _file.ReadBands(
            OIIO::TypeFloat, begin, _channels.End(),
            [&](std::uint32_t y, std::uint32_t rows, const void* data) {
                const auto* pixel = static_cast<const float*>(data);
                for (std::uint32_t row = 0; row < rows; ++row) {
                    float* to = &level.texels[kChannels * level.width * (y + row)];
                    for (std::uint32_t x = 0; x < level.width; ++x, pixel += stride) {
                        rgb[3 * x] = Finite(pixel[_channels.red - begin]);
                        rgb[3 * x + 1] = Finite(pixel[_channels.green - begin]);
                        rgb[3 * x + 2] =
                            _channels.blue < 0 ? 0.0F : Finite(pixel[_channels.blue - begin]);
                        to[kChannels * x + 3] =
                            _channels.alpha < 0 ? 1.0F : Finite(pixel[_channels.alpha - begin]);
                    }
                    _decoder.DecodeRgb(rgb.data(), level.width);
                    for (std::uint32_t x = 0; x < level.width; ++x) {
                        std::copy_n(&rgb[3 * x], 3, &to[kChannels * x]);
                    }
                }
            });
        return level;
    }

    static float Finite(float value) { return std::isfinite(value) ? value : 0.0F; }

    void Append(const Level& level) {
        if (!_isEightBit) {
            const auto* bytes = reinterpret_cast<const std::uint8_t*>(level.texels.data());
            _texture.texels.insert(_texture.texels.end(), bytes,
                                   bytes + level.texels.size() * sizeof(float));
            return;
        }
        const bool isSrgb = (_texture.record.flags & HDS_TEXTURE_SRGB) != 0;
        for (std::size_t i = 0; i < level.texels.size(); ++i) {
            const double value = level.texels[i];
            const double encoded = isSrgb && i % kChannels != 3 ? SrgbFromLinear(value) : value;
            _texture.texels.push_back(
                static_cast<std::uint8_t>(std::clamp(encoded * 255.0 + 0.5, 0.0, 255.0)));
        }
    }

    ImageFile& _file;
    const ColorDecoder& _decoder;
    PlainTexture& _texture;
    ColorChannels _channels;
    bool _isEightBit = false;
};

} // namespace

PlainTexture LoadPlainTexture(const ImageSource& source, const std::string& colorSpace) {
    PlainTexture texture;
    const std::unique_ptr<ImageFile> file = ImageFile::Open(source, &texture.error);
    if (!file) {
        return texture;
    }
    const ColorDecoder decoder(colorSpace, file->Spec(), &texture.warning);
    if (!texture.warning.empty()) {
        texture.warning = file->Name() + ": " + texture.warning;
    }
    try {
        Loader(*file, decoder, &texture).Run();
    } catch (const std::bad_alloc&) {
        texture.error = file->Name() + ": there is not enough memory to load it";
    }
    if (!texture.error.empty()) {
        texture.record.numMips = 0;
        texture.texels.clear();
    }
    return texture;
}

std::vector<float> BaseChannel(const PlainTexture& texture, std::uint32_t channel) {
    const std::size_t count = std::size_t{texture.record.width} * texture.record.height;
    std::vector<float> values(count);
    if (texture.record.format != HDS_TEXEL_RGBA8) {
        const auto* texels = reinterpret_cast<const float*>(texture.texels.data());
        for (std::size_t i = 0; i < count; ++i) {
            values[i] = texels[kChannels * i + channel];
        }
        return values;
    }
    const bool isSrgb = (texture.record.flags & HDS_TEXTURE_SRGB) != 0 && channel < 3;
    for (std::size_t i = 0; i < count; ++i) {
        const double encoded = texture.texels[kChannels * i + channel] / 255.0;
        values[i] = static_cast<float>(isSrgb ? LinearFromSrgb(encoded) : encoded);
    }
    return values;
}

std::array<float, 256> SrgbTable() {
    std::array<float, 256> table{};
    for (std::size_t i = 0; i < table.size(); ++i) {
        table[i] = static_cast<float>(LinearFromSrgb(static_cast<double>(i) / 255.0));
    }
    return table;
}

} // namespace hds
