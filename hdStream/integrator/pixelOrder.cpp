// SPDX-License-Identifier: Apache-2.0
#include "hdStream/integrator/pixelOrder.h"

namespace hds {

namespace {

constexpr std::uint32_t kTileBits = 5;
constexpr std::uint32_t kTileSize = 1U << kTileBits;

constexpr std::uint32_t kLeastFirstStride = 8;
constexpr std::uint32_t kMostFirstStride = 64;
/// Pixels of the coarsest image, at least. Fewer take no less time: their launches take it. The
/// next finer image follows as soon as it is there.
constexpr std::uint64_t kLeastPreviewPixels = 64;

std::uint64_t CountOf(std::uint32_t width, std::uint32_t height, std::uint32_t stride) {
    return std::uint64_t{(width + stride - 1) / stride} * ((height + stride - 1) / stride);
}

/// Every second bit of a Z-curve index.
std::uint32_t CompactBits(std::uint32_t index) {
    std::uint32_t value = 0;
    for (std::uint32_t bit = 0; bit < kTileBits; ++bit) {
        value |= ((index >> (2 * bit)) & 1U) << bit;
    }
    return value;
}

} // namespace

std::vector<std::uint32_t> MakePixelOrder(std::uint32_t width, std::uint32_t height) {
    std::vector<std::uint32_t> pixels;
    pixels.reserve(std::size_t{width} * height);
    const std::uint32_t tilesX = (width + kTileSize - 1) / kTileSize;
    const std::uint32_t tilesY = (height + kTileSize - 1) / kTileSize;
    for (std::uint32_t tileY = 0; tileY < tilesY; ++tileY) {
        for (std::uint32_t i = 0; i < tilesX; ++i) {
            const std::uint32_t tileX = tileY % 2 == 0 ? i : tilesX - 1 - i;
            for (std::uint32_t z = 0; z < kTileSize * kTileSize; ++z) {
                const std::uint32_t x = tileX * kTileSize + CompactBits(z);
                const std::uint32_t y = tileY * kTileSize + CompactBits(z >> 1U);
                if (x < width && y < height) {
                    pixels.push_back(y * width + x);
                }
            }
        }
    }
    return pixels;
}

std::vector<std::uint32_t> PreviewStrides(std::uint32_t width, std::uint32_t height) {
    std::uint32_t stride = kLeastFirstStride;
    while (stride < kMostFirstStride && CountOf(width, height, 2 * stride) >= kLeastPreviewPixels) {
        stride *= 2;
    }
    std::vector<std::uint32_t> strides;
    for (; stride > 0; stride /= 2) {
        strides.push_back(stride);
    }
    return strides;
}

PreviewOrder MakePreviewOrder(const std::vector<std::uint32_t>& order, std::uint32_t width,
                              std::uint32_t height) {
    PreviewOrder result;
    result.strides = PreviewStrides(width, height);
    result.pixels.reserve(order.size());
    std::uint32_t coarser = 0;
    for (const std::uint32_t stride : result.strides) {
        for (const std::uint32_t pixel : order) {
            const std::uint32_t bits = (pixel % width) | (pixel / width);
            if (bits % stride == 0 && (coarser == 0 || bits % coarser != 0)) {
                result.pixels.push_back(pixel);
            }
        }
        result.ends.push_back(static_cast<std::uint32_t>(result.pixels.size()));
        coarser = stride;
    }
    return result;
}

} // namespace hds
