// SPDX-License-Identifier: Apache-2.0
// Light samples of the image of a dome.
#include "testenv/device/light/lightFixture.h"

#include <algorithm>
#include <cmath>
#include <random>

namespace hds::test {
namespace {

class DomeSamples : public LightFixture {};

/// Light samples of a sky with a sun of few texels: what a sample brings, radiance over density, is
/// the same wherever it goes, also where the lookup goes from the sun's texels to those beside it.
/// What is left are the floor of the density and the rounding of luminances.
TEST_F(DomeSamples, OfASunInASkyAllBringTheSame) {
    LightImage image{64, 32, std::vector<float>(std::size_t{64} * 32 * 3, 1.0F), 0};
    for (const std::size_t texel : {5U * 64 + 63, 5U * 64 + 0, 6U * 64 + 63}) { // at the seam
        std::fill_n(&image.rgb[3 * texel], 3, 20000.0F);
    }
    std::fill_n(&image.rgb[std::size_t{3} * 64 * 20], 3 * 64, 0.0F);
    PlacedLight light = MakeLight(LightType::Dome);
    light.light.textureFile.authoredPath = "dome.exr";
    light.light.shadow.color = {0.5F, 0.5F, 0.5F}; // found by light samples alone: in proportion
    SetLights({light}, image);
    std::mt19937 generator(49);
    constexpr std::size_t kCount = 40000;
    const std::vector<float> points(3 * kCount, 0.0F);
    const std::vector<float> us = RandomUnits(generator, 4 * kCount);
    double sum = 0.0;
    double second = 0.0;
    std::size_t numOff = 0; // rounded into the next cell, whose floor is another one
    for (const LightSampleResult& sample : Sample(points, points, us)) {
        ASSERT_TRUE(sample.isValid);
        numOff += std::abs(sample.pdf - sample.hitPdf) < 2e-3 * sample.pdf ? 0 : 1;
        const double value = sample.radiance.x / sample.pdf;
        sum += value;
        second += value * value;
    }
    const double mean = sum / kCount;
    EXPECT_LT(second / kCount / (mean * mean) - 1.0, 0.003);
    EXPECT_LT(numOff, kCount / 2000);
}

} // namespace
} // namespace hds::test
