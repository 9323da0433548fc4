// SPDX-License-Identifier: Apache-2.0
// kernels/math/trig.clh against double precision.
#include "testenv/support/deviceFixture.h"

#include <algorithm>
#include <cmath>
#include <random>

namespace hds::test {
namespace {

const char* const kSource = R"(
#include "math/trig.clh"
kernel void turnAll(global const float* in, global float* out, uint count) {
    uint i = (uint)get_global_id(0);
    if (i < count) vstore2(trig_turns(in[i]), i, out);
}
kernel void radiansAll(global const float* in, global float* out, uint count) {
    uint i = (uint)get_global_id(0);
    if (i < count) vstore2(trig_radians(in[i]), i, out);
}
kernel void atan2All(global const float* in, global float* out, uint count) {
    uint i = (uint)get_global_id(0);
    if (i < count) out[i] = trig_atan2(in[2 * i], in[2 * i + 1]);
}
)";

constexpr double kPi = 3.14159265358979323846;

/// One unit in the last place of a float near x, not below that of 2^-24 (sines near zero).
double Ulp(double x) {
    return std::ldexp(1.0, std::max(std::ilogb(x), -24) - 23);
}

class TrigTest : public DeviceFixture {
protected:
    std::vector<float> Run(const char* kernel, const std::vector<float>& in, std::size_t numItems,
                           std::size_t numOut) {
        auto program = Build(kSource);
        const Buffer input = Upload(in);
        const Buffer out = Allocate(numOut * sizeof(float));
        program->GetKernel(kernel).Launch(numItems, input, out, std::uint32_t(numItems));
        return Download<float>(out, numOut);
    }

    /// Sines and cosines of `kernel` at the inputs, which times `unit` are angles in radians.
    void ExpectSinesAndCosines(const char* kernel, const std::vector<float>& in, double unit) {
        const std::vector<float> out = Run(kernel, in, in.size(), 2 * in.size());
        for (std::size_t i = 0; i < in.size(); ++i) {
            const double angle = unit * std::remainder(double(in[i]), 2.0 * kPi / unit);
            ASSERT_NEAR(out[2 * i], std::cos(angle), 2.0 * Ulp(std::cos(angle))) << in[i];
            ASSERT_NEAR(out[2 * i + 1], std::sin(angle), 2.0 * Ulp(std::sin(angle))) << in[i];
        }
    }
};

std::vector<float> Uniform(std::size_t count, float size, unsigned seed) {
    std::mt19937 generator(seed);
    std::uniform_real_distribution<float> uniform(-size, size);
    std::vector<float> values(count);
    for (float& value : values) {
        value = uniform(generator);
    }
    return values;
}

TEST_F(TrigTest, TurnsEqualDoublePrecision) {
    for (const float size : {1.0F, 1e-6F, 5000.0F}) {
        ExpectSinesAndCosines("turnAll", Uniform(100000, size, 1), 2.0 * kPi);
    }
}

TEST_F(TrigTest, QuartersOfTurnsAreExact) {
    std::vector<float> quarters;
    for (int i = -8; i <= 8; ++i) {
        quarters.push_back(0.25F * float(i));
    }
    const std::vector<float> out = Run("turnAll", quarters, quarters.size(), 2 * quarters.size());
    for (std::size_t i = 0; i < quarters.size(); ++i) {
        const int quarter = (int(i) - 8) & 3;
        EXPECT_EQ(out[2 * i], float((quarter == 0) - (quarter == 2)));
        EXPECT_EQ(out[2 * i + 1], float((quarter == 1) - (quarter == 3)));
    }
}

TEST_F(TrigTest, RadiansEqualDoublePrecision) {
    for (const float size : {7.0F, 1e-6F, 1000.0F}) {
        ExpectSinesAndCosines("radiansAll", Uniform(100000, size, 2), 1.0);
    }
}

TEST_F(TrigTest, Atan2EqualsDoublePrecision) {
    constexpr std::size_t kCount = 200000;
    std::vector<float> in = Uniform(2 * kCount, 1.0F, 3);
    for (std::size_t i = 0; i < kCount; ++i) { // of all ratios
        in[2 * i] *= std::exp2(float(i % 61) - 30.0F);
    }
    const float special[] = {0.0F,  1.0F, 0.0F, -1.0F, 1.0F, 0.0F,
                             -1.0F, 0.0F, 0.0F, 0.0F,  2.0F, 2.0F};
    in.insert(in.end(), std::begin(special), std::end(special));
    const std::size_t numItems = in.size() / 2;
    const std::vector<float> out = Run("atan2All", in, numItems, numItems);
    for (std::size_t i = 0; i < numItems; ++i) {
        const double exact = std::atan2(double(in[2 * i]), double(in[2 * i + 1]));
        const double ulp = std::ldexp(1.0, std::ilogb(exact == 0.0 ? 1e-30 : exact) - 23);
        ASSERT_NEAR(out[i], exact, 2.5 * ulp) << in[2 * i] << " " << in[2 * i + 1];
    }
}

} // namespace
} // namespace hds::test
