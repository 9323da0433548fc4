// SPDX-License-Identifier: Apache-2.0
// Hair (kernels/shading/hair.clh): samples follow their density, and a fibre that absorbs nothing
// scatters all light.
#include "testenv/device/shading/hairReference.h"
#include "testenv/stat/chiSquare.h"
#include "testenv/support/deviceFixture.h"

#include <numeric>

namespace hds::test {
namespace {

constexpr std::size_t kNumSamples = 1000000;

const char* const kKernels = R"(
kernel void sampleAll(global const float* parameters, global const float* us,
                      global const float* vs, global float* out, uint count) {
    uint i = (uint)get_global_id(0);
    if (i >= count) return;
    HdsHair s = unpackHair(parameters);
    float3 wi;
    float pdf;
    float3 weight = hair_sample(&s, vload2(i, us), vload2(i, vs), &wi, &pdf);
    vstore3(pdf > 0.0f ? wi : (float3)(NAN), 2 * i, out);
    vstore3(weight, 2 * i + 1, out);
}
kernel void valuesOf(global const float* parameters, global const float* directions,
                     global float* out, uint count) {
    uint i = (uint)get_global_id(0);
    if (i >= count) return;
    HdsHair s = unpackHair(parameters);
    float pdf;
    float3 value = hair_evaluate(&s, vload3(i, directions), &pdf);
    vstore4((float4)(value, pdf), i, out);
}
)";

class HairStatTest : public DeviceFixture {
protected:
    void SetUp() override {
        DeviceFixture::SetUp();
        if (device) {
            _program = Build(std::string(kUnpackHair) + kKernels);
        }
    }

    /// Value and density at the midpoints of the square.
    std::vector<float> ValuesAt(const HairParameters& p, const std::vector<Square>& points) {
        std::vector<float> directions(points.size() * 3);
        for (std::size_t i = 0; i < points.size(); ++i) {
            SphereDomain::FromSquare(points[i], &directions[3 * i]);
        }
        const Buffer packed = Upload(p.Pack());
        const Buffer in = Upload(directions);
        const Buffer out = Allocate(points.size() * 4 * sizeof(float));
        _program->GetKernel("valuesOf")
            .Launch(points.size(), packed, in, out, std::uint32_t(points.size()));
        return Download<float>(out, points.size() * 4);
    }

    std::unique_ptr<Program> _program;
};

TEST_F(HairStatTest, SamplesFollowTheirDensity) {
    const std::vector<Square> points = DensityPoints(kChiSquareFineSubdivisions);
    unsigned seed = 900;
    for (const double roughness : {0.3, 0.6, 1.0}) {
        for (const double theta : {0.0, 0.6, -1.3}) {
            HairParameters p;
            p.SetRoughness(roughness, roughness);
            p.SetView(theta, 0.4);
            p.cuticleAngle = 0.53;
            p.absorption = {0.1, 0.3, 0.8};
            p.tints[1] = {0.9, 0.5, 1.0};
            const Buffer packed = Upload(p.Pack());
            const Buffer us = Upload(RandomSquares(kNumSamples, seed++));
            const Buffer vs = Upload(RandomSquares(kNumSamples, seed++));
            const Buffer out = Allocate(kNumSamples * 6 * sizeof(float));
            _program->GetKernel("sampleAll")
                .Launch(kNumSamples, packed, us, vs, out, std::uint32_t(kNumSamples));
            const std::vector<float> samples = Download<float>(out, kNumSamples * 6);
            std::vector<Square> squares;
            glm::dvec3 mean(0.0);
            for (std::size_t i = 0; i < kNumSamples; ++i) {
                const float* one = &samples[6 * i];
                if (!std::isnan(one[0])) {
                    const double d[3] = {one[0], one[1], one[2]};
                    squares.push_back(SphereDomain::ToSquare(d));
                }
                mean += glm::dvec3(one[3], one[4], one[5]) / double(kNumSamples);
            }
            const std::vector<float> values = ValuesAt(p, points);
            std::vector<double> densities;
            for (std::size_t i = 0; i < points.size(); ++i) {
                densities.push_back(values[4 * i + 3] * SphereDomain::Jacobian(points[i]));
            }
            const std::string name =
                "roughness " + std::to_string(roughness) + " theta " + std::to_string(theta);
            ExpectChiSquare(name, squares, kNumSamples, densities);
            // What samples weigh is what the lobes scatter in all directions.
            const HairReference reference(p);
            for (int k = 0; k < 3; ++k) {
                double whole = 0.0;
                for (int lobe = 0; lobe < 4; ++lobe) {
                    whole += reference.Attenuation(lobe)[k];
                }
                EXPECT_NEAR(mean[k], whole, 2e-3 * whole) << name << " channel " << k;
            }
        }
    }
}

TEST_F(HairStatTest, WithoutAbsorptionAllLightIsScattered) {
    const std::vector<Square> points = DensityPoints(kChiSquareFineSubdivisions);
    for (const double roughness : {0.1, 0.3, 0.6, 1.0}) {
        for (const double theta : {0.0, 0.5, -1.0, 1.4}) {
            const double h = theta < 0.0 ? -0.8 : 0.35;
            HairParameters p;
            p.SetRoughness(roughness, roughness);
            p.SetView(theta, h);
            p.cuticleAngle = 0.5 + (h > 0.0 ? 0.02 : 0.0);
            const std::vector<float> values = ValuesAt(p, points);
            double sum = 0.0;
            double mass = 0.0;
            for (std::size_t i = 0; i < points.size(); ++i) {
                const double solidAngle = SphereDomain::Jacobian(points[i]) / double(points.size());
                sum += values[4 * i] * solidAngle;
                mass += values[4 * i + 3] * solidAngle;
            }
            EXPECT_NEAR(sum, 1.0, 0.002) << "roughness " << roughness << " theta " << theta;
            EXPECT_NEAR(mass, 1.0, 0.002) << "roughness " << roughness << " theta " << theta;
        }
    }
}

} // namespace
} // namespace hds::test
