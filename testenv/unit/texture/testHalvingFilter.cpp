// SPDX-License-Identifier: Apache-2.0
// Oracle: the mean over each target texel's area, by supersampling on the common refinement of both
// grids in double precision (exact), written as plain loops.
#include "hdStream/texture/halvingFilter.h"

#include <gtest/gtest.h>

#include <algorithm>

namespace {

TEST(HalvingFilter, EqualsTheAreaIntegral) {
    const std::uint32_t cases[][3] = {{8, 4, 1}, {7, 5, 3}, {1, 1, 4},   {1, 9, 2},    {9, 1, 1},
                                      {3, 3, 4}, {2, 3, 3}, {33, 18, 4}, {101, 77, 1}, {12, 31, 2}};
    for (const auto& [w, h, channels] : cases) {
        std::vector<float> source;
        for (std::uint32_t i = 0; i < channels * w * h; ++i) {
            source.push_back(static_cast<float>((i * 2654435761u >> 20) & 1023u));
        }
        const std::uint32_t tw = std::max(1u, w / 2);
        const std::uint32_t th = std::max(1u, h / 2);
        std::vector<double> expected(std::size_t{channels} * tw * th, 0.0);
        for (std::uint32_t y = 0; y < h * th; ++y) {
            for (std::uint32_t x = 0; x < w * tw; ++x) {
                for (std::uint32_t c = 0; c < channels; ++c) {
                    expected[channels * ((y / h) * tw + x / w) + c] +=
                        source[channels * ((y / th) * w + x / tw) + c] / (double(w) * h);
                }
            }
        }
        hds::HalvingFilter filter(w, h, channels);
        std::vector<float> result;
        for (std::uint32_t y = 0; y < h; ++y) {
            if (const float* row = filter.AddRow(&source[std::size_t{channels} * w * y])) {
                result.insert(result.end(), row, row + std::size_t{channels} * tw);
            }
        }
        ASSERT_EQ(result.size(), expected.size()) << w << "x" << h;
        for (std::size_t i = 0; i < result.size(); ++i) {
            ASSERT_NEAR(result[i], expected[i], 1023 * 4e-7) << w << "x" << h; // float rounding
        }
    }
}

} // namespace
