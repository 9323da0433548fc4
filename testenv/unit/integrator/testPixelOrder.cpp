// SPDX-License-Identifier: Apache-2.0
// Every pixel comes exactly once, whatever the size, and neighbours in the list are near in the
// image.
#include "hdStream/integrator/pixelOrder.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <numeric>

namespace hds {
namespace {

TEST(PixelOrder, IsAPermutation) {
    const std::pair<std::uint32_t, std::uint32_t> sizes[] = {{1, 1},   {1, 77},  {77, 1},
                                                             {33, 65}, {64, 32}, {160, 120}};
    for (const auto& [width, height] : sizes) {
        std::vector<std::uint32_t> pixels = MakePixelOrder(width, height);
        std::sort(pixels.begin(), pixels.end());
        std::vector<std::uint32_t> all(std::size_t{width} * height);
        std::iota(all.begin(), all.end(), 0U);
        EXPECT_EQ(pixels, all) << width << "x" << height;
    }
}

TEST(PixelOrder, ARunOf1024IsATile) {
    const std::uint32_t width = 96;
    const std::vector<std::uint32_t> pixels = MakePixelOrder(width, 64);
    for (std::size_t first = 0; first < pixels.size(); first += 1024) {
        std::uint32_t low[2] = {~0U, ~0U};
        std::uint32_t high[2] = {0, 0};
        for (std::size_t i = first; i < first + 1024; ++i) {
            const std::uint32_t at[2] = {pixels[i] % width, pixels[i] / width};
            for (int axis = 0; axis < 2; ++axis) {
                low[axis] = std::min(low[axis], at[axis]);
                high[axis] = std::max(high[axis], at[axis]);
            }
        }
        EXPECT_EQ(high[0] - low[0], 31U);
        EXPECT_EQ(high[1] - low[1], 31U);
    }
}

TEST(PixelOrder, PreviewsGoFromCoarseToFine) {
    for (const auto& [width, height] :
         {std::pair<std::uint32_t, std::uint32_t>{1, 1}, {5, 3}, {33, 65}, {96, 64}, {333, 250}}) {
        const std::vector<std::uint32_t> order = MakePixelOrder(width, height);
        const PreviewOrder preview = MakePreviewOrder(order, width, height);
        EXPECT_EQ(preview.strides, PreviewStrides(width, height));
        ASSERT_EQ(preview.ends.size(), preview.strides.size());
        EXPECT_EQ(preview.ends.back(), order.size());
        EXPECT_TRUE(std::is_permutation(order.begin(), order.end(), preview.pixels.begin(),
                                        preview.pixels.end()));
        for (std::size_t level = 0; level < preview.ends.size(); ++level) {
            const std::uint32_t stride = preview.strides[level];
            EXPECT_EQ(preview.ends[level],
                      ((width + stride - 1) / stride) * ((height + stride - 1) / stride));
            for (std::uint32_t i = 0; i < preview.ends[level]; ++i) {
                EXPECT_EQ(preview.pixels[i] % width % stride, 0U);
                EXPECT_EQ(preview.pixels[i] / width % stride, 0U);
            }
        }
    }
}

TEST(PixelOrder, TheFirstPreviewHas64PixelsAtLeast) {
    using Strides = std::vector<std::uint32_t>;
    EXPECT_EQ(PreviewStrides(1, 1), (Strides{8, 4, 2, 1}));
    EXPECT_EQ(PreviewStrides(127, 128), (Strides{16, 8, 4, 2, 1})); // 8 x 8, edges included
    EXPECT_EQ(PreviewStrides(112, 128), (Strides{8, 4, 2, 1}));     // 7 x 8 are too few
    EXPECT_EQ(PreviewStrides(320, 240), (Strides{32, 16, 8, 4, 2, 1}));
    EXPECT_EQ(PreviewStrides(1920, 1080), (Strides{64, 32, 16, 8, 4, 2, 1}));
    EXPECT_EQ(PreviewStrides(20000, 10000), (Strides{64, 32, 16, 8, 4, 2, 1})) << "no coarser";
}

} // namespace
} // namespace hds
