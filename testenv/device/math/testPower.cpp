// SPDX-License-Identifier: Apache-2.0
// kernels/math/power.clh against double precision, and its special cases against C's.
#include "testenv/support/deviceFixture.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <functional>
#include <limits>
#include <random>

namespace hds::test {
namespace {

const char* const kSource = R"(
#include "math/power.clh"
#include "math/trig.clh"
kernel void powerAll(global const float* in, global float* out, uint count) {
    uint i = (uint)get_global_id(0);
    if (i >= count) return;
    const float x = in[2 * i];
    const float y = in[2 * i + 1];
    out[8 * i] = power_exp(x);
    out[8 * i + 1] = power_expm1(x);
    out[8 * i + 2] = power_tanh(x);
    out[8 * i + 3] = power_log(x);
    out[8 * i + 4] = power_pow(x, y);
    const float sine = fmin(fmax(x, -1.0f), 1.0f);
    out[8 * i + 5] = trig_asin(sine);
    out[8 * i + 6] = trig_acos(sine);
    out[8 * i + 7] = 0.0f;
}
)";

enum Function { Exp, Expm1, Tanh, Log, Pow, Asin, Acos };

constexpr float kInfinity = std::numeric_limits<float>::infinity();

class PowerTest : public DeviceFixture {
protected:
    /// Results of all functions: [x.size()][8].
    std::vector<float> Run(const std::vector<float>& x, const std::vector<float>& y) {
        std::vector<float> in;
        for (std::size_t i = 0; i < x.size(); ++i) {
            in.insert(in.end(), {x[i], y[i]});
        }
        auto program = Build(kSource);
        const Buffer input = Upload(in);
        const Buffer out = Allocate(8 * x.size() * sizeof(float));
        program->GetKernel("powerAll").Launch(x.size(), input, out, std::uint32_t(x.size()));
        return Download<float>(out, 8 * x.size());
    }

    /// Errors in units in the last place, those below 2^-126 as there.
    void ExpectWithin(double ulps, Function function, const std::vector<float>& x,
                      const std::vector<float>& y,
                      const std::function<double(double, double)>& exact) {
        const std::vector<float> found = Run(x, y);
        for (std::size_t i = 0; i < x.size(); ++i) {
            const double wanted = exact(double(x[i]), double(y[i]));
            const float nearest = float(wanted);
            const float value = found[8 * i + function];
            if (std::isfinite(nearest) && nearest != 0.0F) {
                const double ulp = std::ldexp(1.0, std::max(std::ilogb(wanted), -126) - 23);
                ASSERT_NEAR(value, wanted, ulps * ulp) << x[i] << ", " << y[i];
            } else {
                ASSERT_EQ(value, nearest) << x[i] << ", " << y[i];
            }
        }
    }
};

std::vector<float> Uniform(std::size_t count, double low, double high, unsigned seed) {
    std::mt19937 generator(seed);
    std::uniform_real_distribution<double> uniform(low, high);
    std::vector<float> values(count);
    std::generate(values.begin(), values.end(), [&] { return float(uniform(generator)); });
    return values;
}

/// Numbers of all sizes.
std::vector<float> Sizes(std::size_t count, double low, double high, unsigned seed) {
    std::vector<float> values = Uniform(count, low, high, seed);
    std::transform(values.begin(), values.end(), values.begin(),
                   [](float v) { return float(std::exp2(double(v))); });
    return values;
}

constexpr std::size_t kCount = 300'000;

TEST_F(PowerTest, ExponentialsAreWithinAUlp) {
    const auto exact = [](double x, double) { return std::exp(x); };
    const std::vector<float> any(kCount, 0.0F);
    ExpectWithin(1.0, Exp, Uniform(kCount, -87.0, 88.7, 1), any, exact);
    ExpectWithin(1.0, Exp, Uniform(kCount, -1.0, 1.0, 2), any, exact);
    ExpectWithin(1.0, Exp, Uniform(kCount, -103.0, -87.0, 3), any, exact);
}

TEST_F(PowerTest, SmallExponentialsLoseNothing) {
    const std::vector<float> any(kCount, 0.0F);
    const auto exact = [](double x, double) { return std::expm1(x); };
    ExpectWithin(4.0, Expm1, Uniform(kCount, -2.0, 2.0, 4), any, exact);
    ExpectWithin(4.0, Expm1, Sizes(kCount, -100.0, 2.0, 5), any, exact);
    const auto tangent = [](double x, double) { return std::tanh(x); };
    ExpectWithin(5.0, Tanh, Uniform(kCount, -12.0, 12.0, 6), any, tangent);
    ExpectWithin(5.0, Tanh, Sizes(kCount, -100.0, 2.0, 7), any, tangent);
}

TEST_F(PowerTest, LogarithmsAreWithinAUlp) {
    const std::vector<float> any(kCount, 0.0F);
    const auto exact = [](double x, double) { return std::log(x); };
    ExpectWithin(1.0, Log, Sizes(kCount, -148.0, 127.9, 8), any, exact);
    ExpectWithin(1.0, Log, Uniform(kCount, 0.5, 2.0, 9), any, exact);
}

TEST_F(PowerTest, PowersAreWithinFourUlp) {
    const auto exact = [](double x, double y) { return std::pow(x, y); };
    ExpectWithin(4.0, Pow, Uniform(kCount, 0.0, 1.0, 10), Uniform(kCount, 0.0, 90.0, 11), exact);
    ExpectWithin(4.0, Pow, Sizes(kCount, -148.0, 127.9, 12), Uniform(kCount, -3.0, 3.0, 13), exact);
    ExpectWithin(4.0, Pow, Uniform(kCount, 0.9, 1.1, 14), Uniform(kCount, -900.0, 900.0, 15),
                 exact);
}

TEST_F(PowerTest, ArcsAreWithinFourUlp) {
    // An arc cosine near 0 has the error of 1 - x, which is none.
    const std::vector<float> any(kCount, 0.0F);
    ExpectWithin(4.0, Asin, Uniform(kCount, -1.0, 1.0, 16), any,
                 [](double x, double) { return std::asin(x); });
    ExpectWithin(4.0, Acos, Uniform(kCount, -1.0, 1.0, 17), any,
                 [](double x, double) { return std::acos(x); });
}

TEST_F(PowerTest, SpecialCasesAreThoseOfC) {
    const float nan = std::numeric_limits<float>::quiet_NaN();
    const std::vector<float> specials = {0.0F,   -0.0F, 1.0F,  -1.0F,     2.0F,       -2.0F,
                                         0.5F,   -0.5F, 3.0F,  kInfinity, -kInfinity, nan,
                                         1e-45F, 1e38F, -7.0F, 1e30F,     16777217.0F};
    std::vector<float> x;
    std::vector<float> y;
    for (const float a : specials) {
        for (const float b : specials) {
            x.push_back(a);
            y.push_back(b);
        }
    }
    const std::vector<float> found = Run(x, y);
    const auto expectSame = [&](std::size_t i, Function function, float wanted) {
        const float value = found[8 * i + function];
        if (std::isnan(wanted)) {
            EXPECT_TRUE(std::isnan(value)) << function << ": " << x[i] << ", " << y[i];
        } else if (wanted == 0.0F || std::isinf(wanted)) {
            EXPECT_EQ(std::memcmp(&value, &wanted, sizeof(float)), 0)
                << function << ": " << x[i] << ", " << y[i] << ": " << value << ", not " << wanted;
        } else {
            EXPECT_NEAR(value, wanted, 4e-7F * std::fabs(wanted)) << x[i] << ", " << y[i];
        }
    };
    for (std::size_t i = 0; i < x.size(); ++i) {
        expectSame(i, Exp, std::exp(x[i]));
        expectSame(i, Log, std::log(x[i]));
        expectSame(i, Pow, std::pow(x[i], y[i]));
        expectSame(i, Expm1, std::expm1(x[i]) + 0.0F); // of -0 it is 0
    }
}

} // namespace
} // namespace hds::test
