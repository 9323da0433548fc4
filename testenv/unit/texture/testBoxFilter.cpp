// SPDX-License-Identifier: Apache-2.0
// Oracle: the integral over each target pixel of the piecewise constant source, by supersampling on
// the common refinement of both grids (exact), written as plain loops.
#include "hdStream/texture/boxFilter.h"

#include <gtest/gtest.h>

namespace {

std::vector<float> MakePixels(std::uint32_t width, std::uint32_t height) {
    std::vector<float> pixels;
    for (std::uint32_t i = 0; i < 3 * width * height; ++i) {
        pixels.push_back(static_cast<float>((i * 2654435761u >> 20) & 1023u));
    }
    return pixels;
}

std::vector<double> Oracle(const std::vector<float>& source, std::uint32_t w, std::uint32_t h,
                           std::uint32_t tw, std::uint32_t th) {
    std::vector<double> target(std::size_t{3} * tw * th, 0.0);
    for (std::uint32_t y = 0; y < h * th; ++y) {
        for (std::uint32_t x = 0; x < w * tw; ++x) {
            for (std::uint32_t c = 0; c < 3; ++c) {
                target[3 * ((y / h) * tw + x / w) + c] +=
                    source[3 * ((y / th) * w + x / tw) + c] / (double(w) * h);
            }
        }
    }
    return target;
}

TEST(BoxFilter, EqualsTheAreaIntegral) {
    const std::uint32_t cases[][4] = {{8, 4, 4, 2}, {7, 5, 3, 2}, {7, 5, 7, 5},  {13, 3, 12, 3},
                                      {1, 9, 1, 4}, {9, 1, 2, 1}, {33, 17, 1, 1}};
    for (const auto& [w, h, tw, th] : cases) {
        const std::vector<float> source = MakePixels(w, h);
        hds::BoxFilter filter(w, h, tw, th);
        for (std::uint32_t y = 0; y < h; ++y) {
            filter.AddRow(&source[std::size_t{3} * w * y]);
        }
        const std::vector<float> result = filter.TakePixels();
        const std::vector<double> expected = Oracle(source, w, h, tw, th);
        ASSERT_EQ(result.size(), expected.size());
        for (std::size_t i = 0; i < result.size(); ++i) {
            ASSERT_NEAR(result[i], expected[i], 1023 * 6e-8) << w << "x" << h; // float rounding
        }
    }
}

TEST(BoxFilter, ReducedSizeKeepsLimitAndAspect) {
    EXPECT_EQ(hds::ReduceSize(100, 50, 0).width, 100u);
    EXPECT_EQ(hds::ReduceSize(100, 50, 5000).height, 50u);
    const std::uint32_t sizes[][2] = {{8192, 4096}, {100000, 1}, {1, 100000}, {7, 7}, {65535, 3}};
    for (const auto& [width, height] : sizes) {
        for (const std::uint64_t limit : {1u, 2u, 100u, 4096u, 131072u}) {
            const hds::ReducedSize size = hds::ReduceSize(width, height, limit);
            EXPECT_GE(size.width, 1u);
            EXPECT_GE(size.height, 1u);
            EXPECT_LE(size.width, width);
            EXPECT_LE(size.height, height);
            EXPECT_LE(std::uint64_t{size.width} * size.height, limit);
        }
    }
    const hds::ReducedSize half = hds::ReduceSize(8192, 4096, 4096 * 2048);
    EXPECT_EQ(half.width, 4096u);
    EXPECT_EQ(half.height, 2048u);
}

} // namespace
