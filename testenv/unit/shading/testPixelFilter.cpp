// SPDX-License-Identifier: Apache-2.0
// Tables of pixel filters.
#include "hdStream/shading/pixelFilter.h"

#include "hdStream/base/error.h"
#include "hdStream/device/program.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

namespace hds {
namespace {

TEST(PixelFilterTest, TableHasTheSizeThatTheKernelsRead) {
    const std::string source = ExpandKernelSource("sample/filter.clh");
    const std::size_t size = BuildPixelFilterTable("box", 1.0).size() - 1;
    EXPECT_NE(source.find("HDS_FILTER_TABLE_SIZE " + std::to_string(size) + "u"),
              std::string::npos);
}

TEST(PixelFilterTest, BoxIsLinearInTheShare) {
    const std::vector<float> table = BuildPixelFilterTable("box", 2.0);
    for (std::size_t i = 0; i < table.size(); ++i) {
        const double root = double(i) / double(table.size() - 1);
        EXPECT_NEAR(table[i], root * root - 1.0, 1e-6);
    }
}

TEST(PixelFilterTest, BlackmanHarrisInvertsItsIntegral) {
    const double width = 3.0;
    const std::vector<float> table = BuildPixelFilterTable("blackmanHarris", width);
    EXPECT_TRUE(std::is_sorted(table.begin(), table.end()));
    EXPECT_EQ(table.front(), -1.5F);
    EXPECT_EQ(table.back(), 0.0F);
    // Running integral by the trapezoid rule, normalised by the window's mean.
    constexpr int kSteps = 30000;
    double integral = 0.0;
    std::size_t entry = 1;
    for (int i = 1; i <= kSteps / 2 && entry + 1 < table.size(); ++i) {
        const double a = (double(i - 1) / kSteps - 0.5) * width;
        const double b = (double(i) / kSteps - 0.5) * width;
        const double step = 0.5 *
                            (EvaluatePixelFilter("blackmanHarris", width, a) +
                             EvaluatePixelFilter("blackmanHarris", width, b)) /
                            (0.35875 * kSteps);
        for (; entry + 1 < table.size(); ++entry) {
            const double root = double(entry) / double(table.size() - 1);
            const double share = 0.5 * root * root;
            if (share > integral + step) {
                break;
            }
            EXPECT_NEAR(table[entry], b, 2e-4) << entry;
        }
        integral += step;
    }
    EXPECT_GT(entry, table.size() - 3);
}

TEST(PixelFilterTest, ShapeIsOneAtTheCentreAndZeroOutside) {
    for (const char* name : {"box", "blackmanHarris"}) {
        EXPECT_NEAR(EvaluatePixelFilter(name, 3.0, 0.0), 1.0, 1e-9);
        EXPECT_EQ(EvaluatePixelFilter(name, 3.0, 1.6), 0.0);
    }
}

TEST(PixelFilterTest, WrongSettingsAreUsageErrors) {
    EXPECT_THROW(BuildPixelFilterTable("gauss", 1.0), Error);
    EXPECT_THROW(BuildPixelFilterTable("box", 0.0), Error);
    EXPECT_THROW(BuildPixelFilterTable("box", NAN), Error);
}

} // namespace
} // namespace hds
