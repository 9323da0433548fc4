// SPDX-License-Identifier: Apache-2.0
// Hair (kernels/shading/hair.clh) against double precision, and where its lobes point.
#include "testenv/device/shading/hairReference.h"
#include "testenv/support/deviceFixture.h"

#include <random>

namespace hds::test {
namespace {

const char* const kKernels = R"(
kernel void evaluate(global const float* parameters, global const float* directions, uint stride,
                     global float* out, uint count) {
    uint i = (uint)get_global_id(0);
    if (i >= count) return;
    HdsHair s = unpackHair(parameters + stride * i);
    float pdf;
    float3 value = hair_evaluate(&s, vload3(i, directions), &pdf);
    vstore4((float4)(value, pdf), i, out);
}
kernel void offsets(global const float* across, global float* out, uint count) {
    uint i = (uint)get_global_id(0);
    if (i >= count) return;
    HdsHair s;
    s.tangent = (float3)(1.0f, 0.0f, 0.0f);
    s.ahead = (float3)(0.0f, 0.0f, 1.0f);
    s.aside = vec_cross(s.tangent, s.ahead);
    float a = across[i];
    /* A ribbon in the plane of x and y, and the round fibre whose hit lies at the same place. */
    float3 normal = (float3)(0.0f, a, sqrt(1.0f - a * a));
    out[3 * i] = hair_offset(&s, (float3)(0.0f, 0.0f, 1.0f), a, (float3)(0.0f, 2.0f, 0.0f));
    out[3 * i + 1] = hair_offset(&s, (float3)(0.0f, 0.0f, 1.0f), -a, (float3)(0.0f, -2.0f, 0.0f));
    out[3 * i + 2] = hair_offset(&s, normal, HDS_HAIR_ROUND, (float3)(0.0f));
}
)";

glm::dvec3 RandomDirection(std::mt19937& random) {
    std::normal_distribution<double> normal;
    return glm::normalize(glm::dvec3(normal(random), normal(random), normal(random)));
}

class HairTest : public DeviceFixture {
protected:
    void SetUp() override {
        DeviceFixture::SetUp();
        if (device) {
            _program = Build(std::string(kUnpackHair) + kKernels);
        }
    }

    /// Value and density of each fibre for its direction.
    std::vector<float> Evaluate(const std::vector<HairParameters>& fibres,
                                const std::vector<glm::dvec3>& directions) {
        std::vector<float> packed;
        std::vector<float> wis;
        for (std::size_t i = 0; i < fibres.size(); ++i) {
            const std::vector<float> one = fibres[i].Pack();
            packed.insert(packed.end(), one.begin(), one.end());
            wis.insert(wis.end(),
                       {float(directions[i].x), float(directions[i].y), float(directions[i].z)});
        }
        const Buffer parameters = Upload(packed);
        const Buffer wi = Upload(wis);
        const Buffer out = Allocate(fibres.size() * 4 * sizeof(float));
        _program->GetKernel("evaluate")
            .Launch(fibres.size(), parameters, wi, std::uint32_t(packed.size() / fibres.size()),
                    out, std::uint32_t(fibres.size()));
        return Download<float>(out, fibres.size() * 4);
    }

    std::unique_ptr<Program> _program;
};

TEST_F(HairTest, IsThePapersFormula) {
    std::mt19937 random(3);
    std::uniform_real_distribution<double> uniform;
    std::vector<HairParameters> fibres;
    std::vector<glm::dvec3> directions;
    for (int i = 0; i < 20000; ++i) {
        HairParameters p;
        for (std::size_t k = 0; k < 3; ++k) {
            p.variance[k] = std::exp(std::log(0.003) * uniform(random));
            p.scale[k] = std::exp(std::log(0.02) * uniform(random));
            p.tints[k] = {uniform(random), uniform(random), 1.5 * uniform(random)};
        }
        p.cuticleAngle = i % 2 == 0 ? 0.5 + 0.1 * (uniform(random) - 0.5) : uniform(random);
        p.ior = 1.05 + uniform(random);
        p.absorption = glm::dvec3(uniform(random), 3.0 * uniform(random), 0.0);
        p.tangent = RandomDirection(random);
        p.wo = RandomDirection(random);
        const glm::dvec3 ahead = glm::normalize(p.wo - glm::dot(p.wo, p.tangent) * p.tangent);
        const double h = 1.98 * uniform(random) - 0.99;
        p.normal = std::sqrt(1.0 - h * h) * ahead + h * glm::cross(p.tangent, ahead);
        fibres.push_back(p);
        directions.push_back(RandomDirection(random));
    }
    const std::vector<float> values = Evaluate(fibres, directions);
    for (std::size_t i = 0; i < fibres.size(); ++i) {
        const glm::dvec3 expected = HairReference(fibres[i]).Evaluate(directions[i]);
        for (int k = 0; k < 3; ++k) {
            ASSERT_NEAR(values[4 * i + std::size_t(k)], expected[k], 2e-6 + 2e-3 * expected[k])
                << "fibre " << i << " channel " << k;
        }
    }
}

TEST_F(HairTest, WhatIsReflectedAndWhatGoesStraightOnIsWhereMirrorsAndGlassHaveIt) {
    std::mt19937 random(5);
    for (int i = 0; i < 50; ++i) {
        HairParameters p;
        p.SetView(0.9 * (i % 5 - 2) / 2.0, 0.95 * (i / 5 - 4.5) / 4.5);
        const bool isGlass = i % 2 == 0;
        p.tints = {glm::dvec3(isGlass ? 0.0 : 1.0), glm::dvec3(isGlass ? 1.0 : 0.0),
                   glm::dvec3(0.0)};
        p.variance = {0.002, 0.002, 0.002};
        p.scale = {0.02, 0.02, 0.02};
        p.ior = isGlass ? 1.0 : 1.55; // glass that does not bend light
        const glm::dvec3 peak = isGlass ? -p.wo : 2.0 * glm::dot(p.wo, p.normal) * p.normal - p.wo;
        std::vector<glm::dvec3> directions{peak};
        for (int k = 0; k < 500; ++k) {
            const glm::dvec3 other = RandomDirection(random);
            if (glm::dot(other, peak) < 0.97) {
                directions.push_back(other);
            }
        }
        const std::vector<float> values =
            Evaluate(std::vector<HairParameters>(directions.size(), p), directions);
        for (std::size_t k = 1; k < directions.size(); ++k) {
            ASSERT_GT(values[0], values[4 * k]) << "view " << i;
        }
    }
}

TEST_F(HairTest, RibbonsHaveTheOffsetOfTheRoundFibreAtTheSamePlace) {
    const std::vector<float> across = {-1.0F, -0.7F, -0.1F, 0.0F, 0.3F, 0.99F};
    const Buffer in = Upload(across);
    const Buffer out = Allocate(across.size() * 3 * sizeof(float));
    _program->GetKernel("offsets").Launch(across.size(), in, out, std::uint32_t(across.size()));
    const std::vector<float> h = Download<float>(out, across.size() * 3);
    for (std::size_t i = 0; i < across.size(); ++i) {
        EXPECT_NEAR(h[3 * i], h[3 * i + 2], 1e-6) << across[i];
        EXPECT_EQ(h[3 * i], h[3 * i + 1]) << across[i];
        EXPECT_NEAR(std::abs(h[3 * i]), std::abs(across[i]), 1e-6);
    }
}

TEST_F(HairTest, AtTheEdgeOfItsInputsItIsFinite) {
    std::vector<HairParameters> fibres;
    std::vector<glm::dvec3> directions;
    for (const double h : {-1.0, 0.0, 1.0}) {
        for (const double theta : {-1.5707963, 0.0, 1.5707963}) {
            for (const double roughness : {-1.0, 0.0, 1e-9, 1e9}) {
                for (const double ior : {0.0, 0.5, 1.0, 1e9}) {
                    HairParameters p;
                    p.SetView(theta, h);
                    p.variance = {roughness, roughness, roughness};
                    p.scale = p.variance;
                    p.ior = ior;
                    p.cuticleAngle = 10.0 * roughness;
                    p.absorption = glm::dvec3(-1.0, 0.0, 1e9);
                    for (const glm::dvec3& wi :
                         {p.tangent, -p.tangent, p.wo, -p.wo, glm::dvec3(0.0, 1.0, 0.0)}) {
                        fibres.push_back(p);
                        directions.push_back(wi);
                    }
                }
            }
        }
    }
    for (const float value : Evaluate(fibres, directions)) {
        ASSERT_TRUE(std::isfinite(value) && value >= 0.0F);
    }
}

} // namespace
} // namespace hds::test
