// SPDX-License-Identifier: Apache-2.0
#include "hdStream/volume/brickBounds.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <iterator>
#include <limits>

namespace hds {

namespace {

/// Devices may take numbers that are not normal for 0: below this no bound is said to be.
constexpr float kLeastStep = 1e-30F;

/// What a code stands for, in the arithmetic of kernels/volume/voxels.clh.
float ValueOf(const shared::HdsBrickBounds& bounds, int code) {
    return bounds.least + bounds.step * static_cast<float>(code);
}

/// The greatest code that stands for no more than `value`.
int CodeBelow(const shared::HdsBrickBounds& bounds, float value) {
    int code =
        std::clamp(static_cast<int>((value - bounds.least) / bounds.step), 0, HDS_BLOCK_CODES);
    while (code > 0 && ValueOf(bounds, code) > value) {
        --code;
    }
    return code;
}

/// The least code that stands for no less than `value`.
int CodeAbove(const shared::HdsBrickBounds& bounds, float value) {
    int code = CodeBelow(bounds, value);
    while (code < HDS_BLOCK_CODES && ValueOf(bounds, code) < value) {
        ++code;
    }
    return code;
}

} // namespace

shared::HdsBrickBounds BoundBrick(const VoxelBrick& values) {
    const auto [least, greatest] = std::minmax_element(values.begin(), values.end());
    shared::HdsBrickBounds bounds{};
    bounds.least = *least < kLeastStep ? 0.0F : *least;
    bounds.step = std::max((*greatest - bounds.least) / HDS_BLOCK_CODES, kLeastStep);
    while (ValueOf(bounds, HDS_BLOCK_CODES) < *greatest) {
        bounds.step = std::nextafter(bounds.step, std::numeric_limits<float>::max());
    }
    float lower[std::size(bounds.blocks)];
    float upper[std::size(bounds.blocks)];
    std::fill(std::begin(lower), std::end(lower), *greatest);
    std::fill(std::begin(upper), std::end(upper), *least);
    for (int i = 0; i < static_cast<int>(values.size()); ++i) {
        const int x = i % HDS_BRICK_VOXELS / HDS_BLOCK_VOXELS;
        const int y = i / HDS_BRICK_VOXELS % HDS_BRICK_VOXELS / HDS_BLOCK_VOXELS;
        const int z = i / HDS_BRICK_VOXELS / HDS_BRICK_VOXELS / HDS_BLOCK_VOXELS;
        const int block = (z * HDS_BRICK_BLOCKS + y) * HDS_BRICK_BLOCKS + x;
        lower[block] = std::min(lower[block], values[i]);
        upper[block] = std::max(upper[block], values[i]);
    }
    for (std::size_t block = 0; block < std::size(bounds.blocks); ++block) {
        bounds.blocks[block] = static_cast<std::uint8_t>(CodeBelow(bounds, lower[block]) |
                                                         CodeAbove(bounds, upper[block]) << 4);
    }
    return bounds;
}

} // namespace hds
