// SPDX-License-Identifier: Apache-2.0
// Homogeneous media (kernels/shading/medium.clh) on the device: turns follow their density, weights
// of distances are what Beer's law makes of them in the mean, albedos are the inverse of van de
// Hulst's.
#include "testenv/stat/chiSquare.h"
#include "testenv/support/deviceFixture.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <string>
#include <vector>

namespace hds::test {
namespace {

constexpr std::size_t kNumSamples = 1000000;

const char* const kSource = R"(
#include "shading/medium.clh"
kernel void turns(global const float* u, float asymmetry, global float* out, uint count) {
    uint i = (uint)get_global_id(0);
    if (i >= count) return;
    /* Light goes along z. */
    vstore3(medium_sampleDirection(asymmetry, (float3)(0.0f, 0.0f, 1.0f), vload2(i, u)), i, out);
}
kernel void phases(global const float* d, float asymmetry, global float* out, uint count) {
    uint i = (uint)get_global_id(0);
    if (i < count) out[i] = medium_phase(asymmetry, d[3 * i + 2]);
}
kernel void distances(global const float* u, float x, float y, float z, float first, float second,
                      float end,
                      global float* out, uint count) {
    uint i = (uint)get_global_id(0);
    if (i >= count) return;
    float3 chances = (float3)(first, second, 1.0f - first - second);
    HdsMedium medium = medium_none();
    medium.extinction = (float3)(x, y, z);
    medium.albedo = (float3)(1.0f, 0.5f, 0.25f);
    float t = medium_sampleDistance(medium.extinction, chances, vload2(i, u));
    bool isEvent = t < end;
    vstore3(isEvent ? medium_weightOfEvent(&medium, chances, t) : (float3)(0.0f), 2 * i, out);
    vstore3(isEvent ? (float3)(0.0f) : medium_weightAt(medium.extinction, chances, end),
            2 * i + 1, out);
}
kernel void bounds(global const float* u, float x, float y, float z, float t, global float* out,
                   uint count) {
    uint i = (uint)get_global_id(0);
    if (i >= count) return;
    float3 extinction = (float3)(x, y, z);
    bool comesSoFar = t < medium_sampleBound(extinction, u[2 * i]);
    vstore3(comesSoFar ? medium_leftOfBounded(extinction, t) : (float3)(0.0f), i, out);
}
kernel void albedos(global const float* colors, float asymmetry, global float* out, uint count) {
    uint i = (uint)get_global_id(0);
    if (i < count) out[i] = medium_albedoOf((float3)(colors[i]), asymmetry).x;
}
)";

class MediumTest : public DeviceFixture {
protected:
    void SetUp() override {
        DeviceFixture::SetUp();
        if (device) {
            _program = Build(kSource);
        }
    }

    /// Runs a kernel over floats in, `numOut` floats for each item out.
    template <class... Arguments>
    std::vector<float> Run(const char* kernel, const std::vector<float>& in, std::size_t count,
                           std::size_t numOut, const Arguments&... arguments) {
        const Buffer input = Upload(in);
        const Buffer out = Allocate(count * numOut * sizeof(float));
        _program->GetKernel(kernel).Launch(count, input, arguments..., out, std::uint32_t(count));
        return Download<float>(out, count * numOut);
    }

    std::unique_ptr<Program> _program;
};

TEST_F(MediumTest, TurnsFollowTheirDensity) {
    unsigned seed = 70;
    for (const float asymmetry : {-0.7F, 0.0F, 5e-4F, 0.3F, 0.85F}) {
        const std::vector<float> directions =
            Run("turns", RandomSquares(kNumSamples, seed++), kNumSamples, 3, asymmetry);
        std::vector<Square> squares;
        double cosines = 0.0;
        for (std::size_t i = 0; i < directions.size(); i += 3) {
            const double d[3] = {directions[i], directions[i + 1], directions[i + 2]};
            squares.push_back(SphereDomain::ToSquare(d));
            cosines += directions[i + 2];
        }
        std::vector<float> points;
        std::vector<double> densities;
        for (const Square& s : DensityPoints()) {
            float d[3];
            SphereDomain::FromSquare(s, d);
            points.insert(points.end(), d, d + 3);
            densities.push_back(SphereDomain::Jacobian(s));
        }
        const std::vector<float> phases = Run("phases", points, densities.size(), 1, asymmetry);
        for (std::size_t i = 0; i < densities.size(); ++i) {
            densities[i] *= phases[i];
        }
        const std::string name = "asymmetry " + std::to_string(asymmetry);
        ExpectChiSquare(name, squares, kNumSamples, densities);
        EXPECT_NEAR(cosines / double(kNumSamples), asymmetry, 0.003) << name;
    }
}

TEST_F(MediumTest, DistancesAreWeighedForAllChannels) {
    constexpr std::array<double, 3> kAlbedo = {1.0, 0.5, 0.25};
    unsigned seed = 80;
    for (const std::array<double, 3>& extinction :
         {std::array<double, 3>{1.0, 1.0, 1.0}, {0.5, 2.0, 8.0}, {0.0, 1.0, 3.0}}) {
        for (const std::array<float, 2>& chances :
             {std::array<float, 2>{0.3F, 0.3F}, {0.7F, 0.2F}}) {
            const float end = 0.8F;
            const std::vector<float> weights =
                Run("distances", RandomSquares(kNumSamples, seed++), kNumSamples, 6,
                    float(extinction[0]), float(extinction[1]), float(extinction[2]), chances[0],
                    chances[1], end);
            std::array<double, 6> mean{};
            for (std::size_t i = 0; i < weights.size(); ++i) {
                mean[i % 6] += weights[i] / double(kNumSamples);
            }
            for (std::size_t k = 0; k < 3; ++k) {
                const double left = std::exp(-extinction[k] * double(end));
                EXPECT_NEAR(mean[k], kAlbedo[k] * (1.0 - left), 0.008) << extinction[k];
                EXPECT_NEAR(mean[3 + k], left, 0.008) << extinction[k];
            }
        }
    }
}

TEST_F(MediumTest, BoundsOfShadowRaysKeepBeersLaw) {
    unsigned seed = 90;
    for (const std::array<float, 3>& extinction :
         {std::array<float, 3>{1.0F, 1.0F, 1.0F}, {0.5F, 2.0F, 8.0F}}) {
        for (const float t : {0.3F, 2.0F, 4.0F}) {
            const std::vector<float> left =
                Run("bounds", RandomSquares(kNumSamples, seed++), kNumSamples, 3, extinction[0],
                    extinction[1], extinction[2], t);
            std::array<double, 3> mean{};
            for (std::size_t i = 0; i < left.size(); ++i) {
                mean[i % 3] += double(left[i]) / double(kNumSamples);
            }
            const float least = *std::min_element(extinction.begin(), extinction.end());
            const auto reached =
                std::count_if(left.begin(), left.end(), [](float x) { return x > 0.0F; });
            const double chance = std::min(1.0, std::exp(1.0 - double(least * t)));
            EXPECT_NEAR(double(reached) / double(left.size()), chance, 0.003) << t;
            for (std::size_t k = 0; k < 3; ++k) {
                EXPECT_NEAR(mean[k], std::exp(-double(extinction[k]) * t), 0.002) << t;
            }
        }
    }
}

TEST_F(MediumTest, AlbedosAreTheInverseOfVanDeHulsts) {
    const std::vector<float> colors = {0.0F, 0.05F, 0.2F, 0.5F, 0.8F, 0.95F, 1.0F};
    for (const double asymmetry : {-0.5, 0.0, 0.8}) {
        const std::vector<float> albedos =
            Run("albedos", colors, colors.size(), 1, float(asymmetry));
        for (std::size_t i = 0; i < colors.size(); ++i) {
            const double a = albedos[i];
            const double s = std::sqrt((1.0 - a) / (1.0 - a * asymmetry));
            const double color = (1.0 - s) * (1.0 - 0.139 * s) / (1.0 + 1.17 * s);
            EXPECT_NEAR(color, colors[i], 0.002) << "asymmetry " << asymmetry;
        }
    }
}

} // namespace
} // namespace hds::test
