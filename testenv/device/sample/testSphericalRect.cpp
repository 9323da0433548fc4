// SPDX-License-Identifier: Apache-2.0
// kernels/sample/sphericalRect.clh against double precision: solid angle and uniformity.
#include "testenv/support/deviceFixture.h"

#include <algorithm>
#include <cmath>
#include <random>

namespace hds::test {
namespace {

const char* const kSource = R"(
#include "sample/sphericalRect.clh"
kernel void sampleAll(global const float* rects, global const float* us, global float* out,
                      uint count) {
    uint i = (uint)get_global_id(0);
    if (i >= count) return;
    HdsSphericalRect r = sphericalRect_setup(rects[5 * i], rects[5 * i + 1], rects[5 * i + 2],
                                             rects[5 * i + 3], rects[5 * i + 4]);
    float3 p = sphericalRect_sample(&r, vload2(i, us));
    vstore4((float4)(p, r.solidAngle), i, out);
}
)";

/// Solid angle of [x0, x] x [y0, y] at height z from the origin, by the corner formula
/// atan(x y / (z sqrt(x^2 + y^2 + z^2))).
double SolidAngle(double x0, double x1, double y0, double y1, double z) {
    const auto corner = [z](double x, double y) {
        return std::atan2(x * y, z * std::sqrt(x * x + y * y + z * z));
    };
    return corner(x1, y1) - corner(x0, y1) - corner(x1, y0) + corner(x0, y0);
}

class SphericalRectTest : public DeviceFixture {};

TEST_F(SphericalRectTest, SamplesAreUniformInSolidAngle) {
    constexpr std::size_t kCount = 200000;
    std::mt19937 generator(21);
    std::uniform_real_distribution<double> uniform;
    std::vector<float> rects;
    std::vector<float> us;
    for (std::size_t i = 0; i < kCount; ++i) {
        const double width = std::exp(3.0 * uniform(generator) - 1.5);
        const double height = std::exp(3.0 * uniform(generator) - 1.5);
        const double x = 4.0 * uniform(generator) - 2.0 - 0.5 * width;
        const double y = 4.0 * uniform(generator) - 2.0 - 0.5 * height;
        const double z = -std::exp(4.0 * uniform(generator) - 3.0);
        rects.insert(rects.end(),
                     {float(x), float(x + width), float(y), float(y + height), float(z)});
        us.push_back(float(uniform(generator) * 0.999));
        us.push_back(float(uniform(generator) * 0.999));
    }
    auto program = Build(kSource);
    const Buffer rectBuffer = Upload(rects);
    const Buffer uBuffer = Upload(us);
    const Buffer out = Allocate(kCount * 4 * sizeof(float));
    program->GetKernel("sampleAll").Launch(kCount, rectBuffer, uBuffer, out, std::uint32_t(kCount));
    const std::vector<float> samples = Download<float>(out, kCount * 4);
    std::size_t tested = 0;
    double worstX = 0.0;
    double worstY = 0.0;
    for (std::size_t i = 0; i < kCount; ++i) {
        const float* r = &rects[5 * i];
        const double z = -double(r[4]);
        const double total = SolidAngle(r[0], r[1], r[2], r[3], z);
        const double solidAngle = samples[4 * i + 3];
        // The absolute error is a few roundings of angles up to pi / 2.
        ASSERT_NEAR(solidAngle, total, 1e-6 + 1e-6 * total) << "rect " << i;
        if (total < 0.01) { // HDS_SPHERICAL_RECT_MIN: callers sample by area
            continue;
        }
        ++tested;
        // u.x is the share of the solid angle left of x; u.y the share of the sines below y.
        const double x = samples[4 * i];
        const double y = samples[4 * i + 1];
        ASSERT_GE(x, r[0]);
        ASSERT_LE(x, r[1]);
        ASSERT_GE(y, r[2]);
        ASSERT_LE(y, r[3]);
        const double shareX = SolidAngle(r[0], x, r[2], r[3], z) / total;
        const double d = std::sqrt(x * x + z * z);
        const double h0 = r[2] / std::hypot(d, double(r[2]));
        const double h1 = r[3] / std::hypot(d, double(r[3]));
        const double shareY = (y / std::hypot(d, y) - h0) / (h1 - h0);
        worstX = std::max(worstX, std::abs(shareX - us[2 * i]));
        worstY = std::max(worstY, std::abs(shareY - us[2 * i + 1]));
    }
    EXPECT_GT(tested, kCount / 2);
    // Where a sample lands, as a share of the rectangle: 4 digits at the smallest solid angle.
    EXPECT_LT(worstX, 1e-3);
    EXPECT_LT(worstY, 1e-3);
}

TEST_F(SphericalRectTest, SmallRectsAreNeverTakenForLargeOnes) {
    constexpr std::size_t kCount = 1000000;
    std::mt19937 generator(22);
    std::uniform_real_distribution<double> uniform;
    std::vector<float> rects;
    for (std::size_t i = 0; i < kCount; ++i) {
        // Seen from 10^-3 to 10^8 of their larger side, from above to all but along them.
        const double ratio = std::pow(10.0, 11.0 * uniform(generator) - 3.0);
        const double height = std::pow(10.0, -4.0 * uniform(generator));
        const double turn = 6.2831853 * uniform(generator);
        const double rise = std::pow(10.0, -6.0 * uniform(generator));
        const double x = ratio * std::cos(turn) * std::sqrt(1.0 - rise * rise);
        const double y = ratio * std::sin(turn) * std::sqrt(1.0 - rise * rise);
        rects.insert(rects.end(), {float(x - 0.5), float(x + 0.5), float(y - 0.5 * height),
                                   float(y + 0.5 * height), float(-ratio * rise)});
    }
    auto program = Build(kSource);
    const Buffer rectBuffer = Upload(rects);
    const Buffer uBuffer = Upload(std::vector<float>(2 * kCount, 0.5F));
    const Buffer out = Allocate(kCount * 4 * sizeof(float));
    program->GetKernel("sampleAll").Launch(kCount, rectBuffer, uBuffer, out, std::uint32_t(kCount));
    const std::vector<float> samples = Download<float>(out, kCount * 4);
    std::size_t numLarge = 0;
    for (std::size_t i = 0; i < kCount; ++i) {
        const float* r = &rects[5 * i];
        const double total = SolidAngle(r[0], r[1], r[2], r[3], -double(r[4]));
        const double solidAngle = samples[4 * i + 3];
        ASSERT_GE(solidAngle, 0.0);
        if (total < 0.01) { // HDS_SPHERICAL_RECT_MIN: callers sample by area
            ASSERT_LT(solidAngle, 0.0101) << total << " at " << r[0] << " " << r[2] << " " << r[4];
        } else {
            ASSERT_NEAR(solidAngle, total, 0.01 * total) << r[0] << " " << r[2] << " " << r[4];
            ++numLarge;
        }
    }
    EXPECT_GT(numLarge, kCount / 20);
    EXPECT_LT(numLarge, kCount / 2);
}

} // namespace
} // namespace hds::test
