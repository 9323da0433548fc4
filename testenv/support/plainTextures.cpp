// SPDX-License-Identifier: Apache-2.0
#include "testenv/support/plainTextures.h"

#include "kernels/shared/program.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <random>

namespace hds::test {

namespace {

double FromSrgb(double encoded) {
    return encoded <= 0.04045 ? encoded / 12.92 : std::pow((encoded + 0.055) / 1.055, 2.4);
}

/// Appends a stored channel and returns its value.
double AppendChannel(std::uint32_t format, std::mt19937& generator,
                     std::vector<std::uint8_t>* bytes) {
    const auto append = [&](const auto& value) {
        const auto* data = reinterpret_cast<const std::uint8_t*>(&value);
        bytes->insert(bytes->end(), data, data + sizeof(value));
    };
    const std::uint32_t type = format & HDS_TEXEL_TYPE_MASK;
    if (type == HDS_TEXEL_U8) {
        const auto code = static_cast<std::uint8_t>(generator() & 0xffU);
        append(code);
        return code / 255.0;
    }
    if (type == HDS_TEXEL_U16) {
        const auto code = static_cast<std::uint16_t>(generator() & 0xffffU);
        append(code);
        return code / 65535.0;
    }
    if (type == HDS_TEXEL_HALF) {
        // 1 + k / 1024 for any k: exponent 15, no rounding.
        const auto mantissa = static_cast<std::uint16_t>(generator() & 0x3ffU);
        append(static_cast<std::uint16_t>(0x3c00U | mantissa));
        return 1.0 + mantissa / 1024.0;
    }
    const float value = std::uniform_real_distribution<float>(-1.0F, 4.0F)(generator);
    append(value);
    return value;
}

/// The mip as a real number, from the singular values of the footprint in texels.
double LevelOf(const shared::HdsTexture& record, glm::dvec4 axes, double bias) {
    const glm::dvec2 a(axes.x * record.width, axes.y * record.height);
    const glm::dvec2 b(axes.z * record.width, axes.w * record.height);
    const double squares = a.x * a.x + a.y * a.y + b.x * b.x + b.y * b.y;
    const double area = a.x * b.y - a.y * b.x;
    const double root = std::sqrt(std::max(0.0, squares * squares - 4.0 * area * area));
    const double major = std::sqrt(0.5 * (squares + root));
    const double minor = major > 0.0 ? std::max(std::abs(area) / major, major / 8.0) : 0.0;
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

glm::dvec4 Bilinear(const PlainTextures& textures, std::uint32_t texture, std::uint32_t mip,
                    std::uint32_t wrapS, std::uint32_t wrapT, glm::dvec2 st) {
    const glm::ivec2 size = PlainTextures::MipSize(textures.Records()[texture], mip);
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

std::uint32_t PlainTextures::Add(std::uint32_t width, std::uint32_t height, std::uint32_t format,
                                 std::uint32_t swizzle, std::uint32_t seed) {
    std::mt19937 generator(seed);
    const auto align = [&] {
        _bytes.resize((_bytes.size() + HDS_POOL_UNIT_BYTES - 1) / HDS_POOL_UNIT_BYTES *
                      HDS_POOL_UNIT_BYTES);
        return static_cast<std::uint32_t>(_bytes.size() / HDS_POOL_UNIT_BYTES);
    };
    shared::HdsTexture record{};
    record.width = width;
    record.height = height;
    record.format = format;
    record.swizzle = swizzle;
    record.firstLine = align();
    const int channels = 1 << (format & HDS_TEXEL_CHANNELS_LOG2_MASK);
    auto& mips = _values.emplace_back();
    for (glm::ivec2 size(width, height);;
         size = glm::ivec2(std::max(1, size.x / 2), std::max(1, size.y / 2))) {
        auto& values = mips.emplace_back();
        record.mipBlock[record.numMips++] = align() - record.firstLine;
        for (int i = 0; i < size.x * size.y; ++i) {
            glm::dvec4 stored(0.0, 0.0, 0.0, 1.0);
            for (int c = 0; c < channels; ++c) {
                const double value = AppendChannel(format, generator, &_bytes);
                const bool isAlpha =
                    c == 3 || (c == 1 && (format & HDS_TEXEL_SECOND_IS_ALPHA) != 0);
                const bool isEncoded = (format & HDS_TEXEL_SRGB) != 0 && !isAlpha;
                stored[c] = isEncoded ? FromSrgb(value) : value;
            }
            glm::dvec4 shown;
            for (int c = 0; c < 4; ++c) {
                shown[c] = stored[static_cast<int>(swizzle >> (2 * c) & 3U)];
            }
            values.push_back(shown);
        }
        if (size == glm::ivec2(1, 1)) {
            break;
        }
    }
    _records.push_back(record);
    return static_cast<std::uint32_t>(_records.size() - 1);
}

glm::ivec2 PlainTextures::MipSize(const shared::HdsTexture& record, std::uint32_t mip) {
    return {std::max(1U, record.width >> mip), std::max(1U, record.height >> mip)};
}

glm::dvec4 PlainTextures::Texel(std::uint32_t texture, std::uint32_t mip, int x, int y) const {
    return _values[texture][mip][static_cast<std::size_t>(y) * MipSize(_records[texture], mip).x +
                                 static_cast<std::size_t>(x)];
}

glm::dvec4 LookUp(const PlainTextures& textures, std::uint32_t texture, std::uint32_t wrapS,
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
