// SPDX-License-Identifier: Apache-2.0
#include "hdStream/integrator/pixelOrder.h"

namespace hds {

namespace {

constexpr std::uint32_t kTileBits = 5;
constexpr std::uint32_t kTileSize = 1U << kTileBits;

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

PreviewOrder MakePreviewOrder(const std::vector<std::uint32_t>& order, std::uint32_t width) {
    PreviewOrder result;
    result.pixels.reserve(order.size());
    std::uint32_t coarser = 0;
    for (const std::uint32_t stride : kPreviewStrides) {
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
