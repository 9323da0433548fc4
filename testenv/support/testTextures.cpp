// SPDX-License-Identifier: Apache-2.0
#include "testenv/support/testTextures.h"

#include "hdStream/texture/blockEncoder.h"
#include "hdStream/texture/textureLayout.h"
#include "kernels/shared/program.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <random>

namespace hds::test {

namespace {

constexpr std::size_t kLineWords = HDS_LINE_BYTES / sizeof(std::uint32_t);

double FromSrgb(double encoded) {
    return encoded <= 0.04045 ? encoded / 12.92 : std::pow((encoded + 0.055) / 1.055, 2.4);
}

/// A value of a channel, as it is stored and in double precision.
struct StoredValue {
    std::vector<std::uint8_t> bytes;
    double value = 0.0;
};

template <typename T>
StoredValue Stored(T bits, double value) {
    const auto* data = reinterpret_cast<const std::uint8_t*>(&bits);
    return {{data, data + sizeof(bits)}, value};
}

/// Two values of a channel between which its blocks lie; the codec keeps both ends exactly.
std::array<StoredValue, 2> RandomEnds(std::uint32_t format, std::mt19937& generator) {
    std::array<StoredValue, 2> ends;
    // Of 8 bits wide intervals of one channel are coded in steps (HDS_CODEC_EXACT_RANGE). Of four
    // channels a narrow one may go without an index: what that loses is too little to be measured.
    const bool isWide = (format & HDS_TEXEL_CHANNELS_LOG2_MASK) == 2;
    const std::uint32_t low = generator() % (isWide ? 64 : 160);
    std::uint32_t gap = 0;
    for (StoredValue& end : ends) {
        switch (format & HDS_TEXEL_TYPE_MASK) {
        case HDS_TEXEL_U8: {
            const auto code =
                static_cast<std::uint8_t>(low + gap + generator() % (isWide ? 32 : 96));
            gap = isWide ? 150 : 0;
            end = Stored(code, code / 255.0);
            break;
        }
        case HDS_TEXEL_U16: {
            const auto code = static_cast<std::uint16_t>(generator() & 0xffffU);
            end = Stored(code, code / 65535.0);
            break;
        }
        case HDS_TEXEL_HALF: {
            // 1 + k / 1024 for any k: exponent 15, no rounding.
            const auto mantissa = static_cast<std::uint16_t>(generator() & 0x3ffU);
            end = Stored(static_cast<std::uint16_t>(0x3c00U | mantissa), 1.0 + mantissa / 1024.0);
            break;
        }
        default: {
            const float value = std::uniform_real_distribution<float>(-1.0F, 4.0F)(generator);
            end = Stored(value, value);
        }
        }
    }
    return ends;
}

/// The texels of a block as they are stored, and in linear light before the swizzle.
struct RandomTexels {
    std::vector<std::uint8_t> stored; ///< [16][channels]
    std::array<glm::dvec4, 16> linear;
};

RandomTexels MakeTexels(std::uint32_t format, std::mt19937& generator) {
    const int channels = 1 << (format & HDS_TEXEL_CHANNELS_LOG2_MASK);
    std::vector<std::array<StoredValue, 2>> ends;
    for (int c = 0; c < channels; ++c) {
        ends.push_back(RandomEnds(format, generator));
    }
    RandomTexels texels;
    for (glm::dvec4& linear : texels.linear) {
        linear = {0.0, 0.0, 0.0, 1.0};
        for (int c = 0; c < channels; ++c) {
            const StoredValue& value = ends[c][generator() >> 16 & 1U];
            texels.stored.insert(texels.stored.end(), value.bytes.begin(), value.bytes.end());
            const bool isAlpha = c == 3 || (c == 1 && (format & HDS_TEXEL_SECOND_IS_ALPHA) != 0);
            const bool isEncoded = (format & HDS_TEXEL_SRGB) != 0 && !isAlpha;
            linear[c] = isEncoded ? FromSrgb(value.value) : value.value;
        }
    }
    return texels;
}

/// The mip as a real number, from the singular values of the footprint in texels.
double LevelOf(const shared::HdsTexture& record, glm::dvec4 axes, double bias) {
    const glm::dvec2 a(axes.x * record.width, axes.y * record.height);
    const glm::dvec2 b(axes.z * record.width, axes.w * record.height);
    const double squares = a.x * a.x + a.y * a.y + b.x * b.x + b.y * b.y;
    const double area = a.x * b.y - a.y * b.x;
    const double root = std::sqrt(std::max(0.0, squares * squares - 4.0 * area * area));
    const double major = std::sqrt(0.5 * (squares + root));
    // Of images beyond 4 : 1 the limit grows with what is beyond.
    const double longSide = std::max(record.width, record.height);
    const double shortSide = std::min(record.width, record.height);
    const double limit = longSide > 4.0 * shortSide ? 2.0 * longSide / shortSide : 8.0;
    const double minor = major > 0.0 ? std::max(std::abs(area) / major, major / limit) : 0.0;
    const double level = minor > 0.0 ? std::log2(minor) + bias : 0.0;
    return std::clamp(level, 0.0, record.numMips - 1.0);
}

/// Index of a texel, or -1 for the black border. Follows the definition of the modes, texel by
/// texel, without first wrapping the coordinate.
int WrapTexel(double index, int size, std::uint32_t wrap) {
    const auto period = [&](double length) { return index - std::floor(index / length) * length; };
    switch (wrap) {
    case HDS_WRAP_REPEAT:
        return static_cast<int>(period(size));
    case HDS_WRAP_MIRROR: {
        const int folded = static_cast<int>(period(2.0 * size));
        return folded < size ? folded : 2 * size - 1 - folded;
    }
    case HDS_WRAP_CLAMP:
        return static_cast<int>(std::clamp(index, 0.0, size - 1.0));
    default:
        return index >= 0.0 && index < size ? static_cast<int>(index) : -1;
    }
}

glm::dvec4 Bilinear(const TestTextures& textures, std::uint32_t texture, std::uint32_t mip,
                    std::uint32_t wrapS, std::uint32_t wrapT, glm::dvec2 st) {
    const glm::ivec2 size = TestTextures::MipSize(textures.Records()[texture], mip);
    const double x = st.x * size.x - 0.5;
    const double y = (1.0 - st.y) * size.y - 0.5;
    const double x0 = std::floor(x);
    const double y0 = std::floor(y);
    glm::dvec4 sum(0.0);
    for (int k = 0; k < 4; ++k) {
        const double weightX = (k & 1) != 0 ? x - x0 : 1.0 - (x - x0);
        const double weightY = (k & 2) != 0 ? y - y0 : 1.0 - (y - y0);
        const int column = WrapTexel(x0 + (k & 1), size.x, wrapS);
        const int row = WrapTexel(y0 + (k >> 1), size.y, wrapT);
        if (column >= 0 && row >= 0) {
            sum += weightX * weightY * textures.Texel(texture, mip, column, row);
        }
    }
    return sum;
}

} // namespace

std::uint32_t TestTextures::Add(std::uint32_t width, std::uint32_t height, std::uint32_t format,
                                std::uint32_t swizzle, std::uint32_t seed) {
    std::mt19937 generator(seed);
    shared::HdsTexture record = MakeTextureLayout(width, height, format);
    record.swizzle = swizzle;
    const std::uint32_t index = AddRecord(record);
    for (std::uint32_t mip = 0; mip < record.numMips; ++mip) {
        const glm::ivec2 size = MipSize(record, mip);
        auto& values = _values[index].emplace_back(std::size_t(size.x) * std::size_t(size.y));
        for (int top = 0; top < size.y; top += 4) {
            for (int left = 0; left < size.x; left += 4) {
                const RandomTexels texels = MakeTexels(format, generator);
                WriteBlock(_records[index], mip, {left, top}, texels.stored.data());
                for (int i = 0; i < 16; ++i) {
                    const glm::ivec2 at(left + i % 4, top + i / 4);
                    if (at.x >= size.x || at.y >= size.y) {
                        continue;
                    }
                    glm::dvec4& shown = values[std::size_t(at.y) * std::size_t(size.x) + at.x];
                    for (int c = 0; c < 4; ++c) {
                        shown[c] = texels.linear[i][static_cast<int>(swizzle >> (2 * c) & 3U)];
                    }
                }
            }
        }
    }
    return index;
}

std::uint32_t TestTextures::AddImage(std::uint32_t width, std::uint32_t height,
                                     const std::vector<float>& rgb) {
    shared::HdsTexture record = MakeTextureLayout(width, height, HDS_TEXEL_FLOAT | 2U);
    record.numMips = 1;
    const std::uint32_t index = AddRecord(record);
    for (std::uint32_t top = 0; top < height; top += 4) {
        for (std::uint32_t left = 0; left < width; left += 4) {
            std::array<float, 64> texels{};
            for (std::uint32_t i = 0; i < 16; ++i) {
                // Blocks that reach over the edge repeat it.
                const std::uint32_t x = std::min(left + i % 4, width - 1);
                const std::uint32_t y = std::min(top + i / 4, height - 1);
                std::copy_n(&rgb[3 * (std::size_t{y} * width + x)], 3, &texels[4 * i]);
                texels[4 * i + 3] = 1.0F;
            }
            WriteBlock(_records[index], 0, {left, top}, texels.data());
        }
    }
    return index;
}

/// Its lines come after those that are there.
std::uint32_t TestTextures::AddRecord(shared::HdsTexture record) {
    record.firstLine = static_cast<std::uint32_t>(_words.size() / kLineWords);
    _words.resize(_words.size() + std::size_t{record.numLines} * kLineWords);
    _records.push_back(record);
    _values.emplace_back();
    return static_cast<std::uint32_t>(_records.size() - 1);
}

/// \param corner its first texel
void TestTextures::WriteBlock(const shared::HdsTexture& record, std::uint32_t mip,
                              glm::uvec2 corner, const void* texels) {
    const shared::HdsTexelPlace place = PlaceOf(record, mip, corner.x, corner.y);
    const std::size_t block =
        ((place.y / 4) << shared::texel_lineWidthLog2(record.format)) + place.x / 4;
    const std::size_t line = std::size_t{record.firstLine} + place.line;
    const std::size_t blockWords = std::size_t{1}
                                   << (shared::texel_blockBytesLog2(record.format) - 2);
    EncodeBlock(record.format, texels, &_words[line * kLineWords + block * blockWords]);
}

glm::ivec2 TestTextures::MipSize(const shared::HdsTexture& record, std::uint32_t mip) {
    return {std::max(1U, record.width >> mip), std::max(1U, record.height >> mip)};
}

glm::dvec4 TestTextures::Texel(std::uint32_t texture, std::uint32_t mip, int x, int y) const {
    return _values[texture][mip][static_cast<std::size_t>(y) * MipSize(_records[texture], mip).x +
                                 static_cast<std::size_t>(x)];
}

glm::dvec4 LookUp(const TestTextures& textures, std::uint32_t texture, std::uint32_t wrapS,
                  std::uint32_t wrapT, glm::dvec2 st, glm::dvec4 axes, double bias) {
    for (int i = 0; i < 2; ++i) {
        st[i] = std::isfinite(st[i]) ? st[i] : 0.0;
    }
    const double level = LevelOf(textures.Records()[texture], axes, bias);
    const auto mip = static_cast<std::uint32_t>(level);
    const glm::dvec4 fine = Bilinear(textures, texture, mip, wrapS, wrapT, st);
    if (level == mip) {
        return fine;
    }
    const glm::dvec4 coarse = Bilinear(textures, texture, mip + 1, wrapS, wrapT, st);
    return fine + (level - mip) * (coarse - fine);
}

} // namespace hds::test
