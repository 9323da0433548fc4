// SPDX-License-Identifier: Apache-2.0
// kernels/shading/previewSurface.clh against its formulas in double precision.
#include "testenv/device/shading/previewReference.h"
#include "testenv/support/deviceFixture.h"

#include <algorithm>
#include <cmath>
#include <random>

namespace hds::test {
namespace {

const char* const kKernels = R"(
kernel void evaluateAll(global const float* parameters, global const float* directions,
                        global const float* geomNormals, global float* out, uint count) {
    uint i = (uint)get_global_id(0);
    if (i >= count) return;
    HdsSurface s = unpackSurface(parameters + 16 * i, vload3(i, geomNormals));
    float pdf;
    float3 value =
        surface_evaluate(&s, surface_lobeProbabilities(&s, directions[6 * i + 2]),
                         vload3(2 * i, directions), vload3(2 * i + 1, directions), &pdf);
    vstore4((float4)(value, pdf), i, out);
}
kernel void sampleAll(global const float* parameters, global const float* directions,
                      global const float* geomNormals, global const float* us, global float* out,
                      uint count) {
    uint i = (uint)get_global_id(0);
    if (i >= count) return;
    HdsSurface s = unpackSurface(parameters + 16 * i, vload3(i, geomNormals));
    float3 wo = vload3(2 * i, directions);
    float3 wi;
    float pdf;
    float3 weight = surface_sample(&s, surface_lobeProbabilities(&s, wo.z), wo,
                                   vload2(i, us), &wi, &pdf);
    float pdfEvaluated;
    float3 value = surface_evaluate(&s, surface_lobeProbabilities(&s, wo.z), wo, wi,
                                    &pdfEvaluated);
    vstore4((float4)(weight * pdf, pdf), 3 * i, out);
    vstore4((float4)(value, pdfEvaluated), 3 * i + 1, out);
    vstore4((float4)(wi, 0.0f), 3 * i + 2, out);
}
kernel void passAll(global const float* parameters, global const float* cosines, global float* out,
                    uint count) {
    uint i = (uint)get_global_id(0);
    if (i >= count) return;
    HdsSurface s = unpackSurface(parameters + 16 * i, (float3)(0.0f, 0.0f, 1.0f));
    vstore3(surface_passThrough(&s, cosines[i]), 2 * i, out);
    vstore3(surface_albedo(&s, cosines[i]), 2 * i + 1, out);
}
)";

struct Cases {
    std::vector<PreviewParameters> parameters;
    std::vector<float> packed;
    std::vector<float> directions; ///< wo, wi
    std::vector<float> geomNormals;
};

glm::dvec3 RandomDirection(std::mt19937& generator) {
    std::uniform_real_distribution<double> uniform;
    const double z = 0.02 + 0.98 * uniform(generator);
    const double phi = 2.0 * kReferencePi * uniform(generator);
    const double r = std::sqrt(1.0 - z * z);
    return {r * std::cos(phi), r * std::sin(phi), z};
}

PreviewParameters RandomParameters(std::mt19937& generator, double minRoughness) {
    std::uniform_real_distribution<double> uniform;
    PreviewParameters p;
    p.diffuseColor = {uniform(generator), uniform(generator), uniform(generator)};
    p.specularColor = {uniform(generator), uniform(generator), uniform(generator)};
    p.metallic = uniform(generator);
    p.roughness = minRoughness + (1.0 - minRoughness) * uniform(generator);
    p.clearcoat = generator() & 1U ? uniform(generator) : 0.0;
    p.clearcoatRoughness = minRoughness + (1.0 - minRoughness) * uniform(generator);
    p.opacity = generator() & 1U ? uniform(generator) : 1.0;
    p.ior = 1.0 + 1.5 * uniform(generator);
    p.isSpecularWorkflow = generator() & 1U;
    p.isLambert = generator() % 8U == 0U;
    return p;
}

Cases RandomCases(std::size_t count, double minRoughness, unsigned seed) {
    std::mt19937 generator(seed);
    Cases cases;
    for (std::size_t i = 0; i < count; ++i) {
        cases.parameters.push_back(RandomParameters(generator, minRoughness));
        const std::vector<float> packed = cases.parameters.back().Pack();
        cases.packed.insert(cases.packed.end(), packed.begin(), packed.end());
        for (int k = 0; k < 2; ++k) {
            const glm::dvec3 d = RandomDirection(generator);
            cases.directions.insert(cases.directions.end(), {float(d.x), float(d.y), float(d.z)});
        }
        cases.geomNormals.insert(cases.geomNormals.end(), {0.0F, 0.0F, 1.0F});
    }
    return cases;
}

glm::dvec3 Load(const std::vector<float>& values, std::size_t index) {
    return glm::normalize(
        glm::dvec3(values[3 * index], values[3 * index + 1], values[3 * index + 2]));
}

class PreviewSurfaceTest : public DeviceFixture {
protected:
    void SetUp() override {
        DeviceFixture::SetUp();
        if (device) {
            _program = Build(std::string(kUnpackSurface) + kKernels);
        }
    }
    std::vector<float> Evaluate(const Cases& cases) {
        const std::size_t count = cases.parameters.size();
        const Buffer packed = Upload(cases.packed);
        const Buffer directions = Upload(cases.directions);
        const Buffer normals = Upload(cases.geomNormals);
        const Buffer out = Allocate(count * 4 * sizeof(float));
        _program->GetKernel("evaluateAll")
            .Launch(count, packed, directions, normals, out, std::uint32_t(count));
        return Download<float>(out, count * 4);
    }
    std::vector<float> Sample(const Cases& cases, unsigned seed) {
        const std::size_t count = cases.parameters.size();
        std::mt19937 generator(seed);
        std::vector<float> us(count * 2);
        for (float& u : us) {
            u = float(generator() >> 8) * 0x1p-24F;
        }
        const Buffer packed = Upload(cases.packed);
        const Buffer directions = Upload(cases.directions);
        const Buffer normals = Upload(cases.geomNormals);
        const Buffer usBuffer = Upload(us);
        const Buffer out = Allocate(count * 12 * sizeof(float));
        _program->GetKernel("sampleAll")
            .Launch(count, packed, directions, normals, usBuffer, out, std::uint32_t(count));
        return Download<float>(out, count * 12);
    }
    /// transparency, albedo
    std::vector<float> PassThrough(const std::vector<PreviewParameters>& parameters,
                                   const std::vector<float>& cosines) {
        std::vector<float> packed;
        for (const PreviewParameters& p : parameters) {
            const std::vector<float> one = p.Pack();
            packed.insert(packed.end(), one.begin(), one.end());
        }
        const Buffer packedBuffer = Upload(packed);
        const Buffer cosineBuffer = Upload(cosines);
        const Buffer out = Allocate(parameters.size() * 6 * sizeof(float));
        _program->GetKernel("passAll").Launch(parameters.size(), packedBuffer, cosineBuffer, out,
                                              std::uint32_t(parameters.size()));
        return Download<float>(out, parameters.size() * 6);
    }
    std::unique_ptr<Program> _program;
};

TEST_F(PreviewSurfaceTest, EvaluationEqualsTheFormula) {
    // Roughness above 0.1, alpha above 0.01: a half vector's error of 6e-8 is 6e-6 alpha, which the
    // fourth power of D's denominator makes 5e-5 at most; 1e-4 with the other roundings.
    const Cases cases = RandomCases(200000, 0.1, 31);
    const std::vector<float> values = Evaluate(cases);
    for (std::size_t i = 0; i < cases.parameters.size(); ++i) {
        const glm::dvec3 expected =
            PreviewReference(cases.parameters[i])
                .Evaluate(Load(cases.directions, 2 * i), Load(cases.directions, 2 * i + 1));
        for (int c = 0; c < 3; ++c) {
            ASSERT_NEAR(values[4 * i + std::size_t(c)], expected[c], 1e-4 * expected[c] + 1e-9)
                << "case " << i;
        }
    }
}

TEST_F(PreviewSurfaceTest, IsReciprocal) {
    const Cases cases = RandomCases(100000, 0.1, 32);
    Cases swapped = cases;
    for (std::size_t i = 0; i < cases.parameters.size(); ++i) {
        std::swap_ranges(swapped.directions.begin() + std::ptrdiff_t(6 * i),
                         swapped.directions.begin() + std::ptrdiff_t(6 * i + 3),
                         swapped.directions.begin() + std::ptrdiff_t(6 * i + 3));
    }
    const std::vector<float> forward = Evaluate(cases);
    const std::vector<float> backward = Evaluate(swapped);
    for (std::size_t i = 0; i < cases.parameters.size(); ++i) {
        const double cosO = cases.directions[6 * i + 2];
        const double cosI = cases.directions[6 * i + 5];
        for (std::size_t c = 0; c < 3; ++c) {
            const double f = forward[4 * i + c] / cosI;
            const double g = backward[4 * i + c] / cosO;
            ASSERT_NEAR(f, g, 2e-5 * f + 1e-9) << "case " << i;
        }
    }
}

TEST_F(PreviewSurfaceTest, SamplesCarryTheValueAndDensityOfTheirDirection) {
    const Cases cases = RandomCases(200000, 0.0, 33);
    const std::vector<float> samples = Sample(cases, 34);
    std::size_t valid = 0;
    for (std::size_t i = 0; i < cases.parameters.size(); ++i) {
        const float* s = &samples[12 * i];
        const double length =
            std::sqrt(double(s[8]) * s[8] + double(s[9]) * s[9] + double(s[10]) * s[10]);
        ASSERT_NEAR(length, 1.0, 1e-6);
        ASSERT_EQ(s[3], s[7]); // the density is the same number, not a similar one
        if (!(s[3] > 0.0F)) {
            ASSERT_EQ(s[0], 0.0F);
            continue;
        }
        ++valid;
        for (std::size_t c = 0; c < 3; ++c) {
            ASSERT_TRUE(std::isfinite(s[c]));
            ASSERT_NEAR(s[c], s[4 + c], 1e-6 * s[4 + c] + 1e-12);
        }
    }
    EXPECT_GT(valid, cases.parameters.size() * 8 / 10);
}

TEST_F(PreviewSurfaceTest, NothingIsReflectedBelowTheGeometricSurface) {
    Cases cases = RandomCases(100000, 0.1, 35);
    std::mt19937 generator(36);
    for (std::size_t i = 0; i < cases.parameters.size(); ++i) {
        const glm::dvec3 n = RandomDirection(generator);
        cases.geomNormals[3 * i] = float(n.x);
        cases.geomNormals[3 * i + 1] = float(n.y);
        cases.geomNormals[3 * i + 2] = float(n.z);
    }
    const std::vector<float> values = Evaluate(cases);
    const std::vector<float> samples = Sample(cases, 37);
    std::size_t below = 0;
    for (std::size_t i = 0; i < cases.parameters.size(); ++i) {
        const glm::dvec3 n = Load(cases.geomNormals, i);
        const double evaluated = glm::dot(n, Load(cases.directions, 2 * i + 1));
        if (evaluated < -1e-6) {
            ++below;
            ASSERT_EQ(values[4 * i], 0.0F);
            ASSERT_EQ(values[4 * i + 3], 0.0F);
        } else if (evaluated > 1e-6) {
            ASSERT_GT(values[4 * i + 3], 0.0F);
        }
        const float* s = &samples[12 * i];
        const double sampled = n.x * s[8] + n.y * s[9] + n.z * s[10];
        ASSERT_TRUE(sampled > -1e-6 || s[3] == 0.0F);
    }
    EXPECT_GT(below, 1000U);
}

TEST_F(PreviewSurfaceTest, TransparencyFollowsOpacityAndThreshold) {
    std::vector<PreviewParameters> parameters(6);
    const std::vector<float> cosines = {1.0F, 1.0F, 0.5F, 1.0F, 1.0F, 1.0F};
    parameters[1].opacity = 0.25;
    parameters[2].opacity = 0.0;
    parameters[2].clearcoat = 1.0;
    parameters[3].opacity = 0.3;
    parameters[3].opacityThreshold = 0.4;
    parameters[4].opacity = 0.4;
    parameters[4].opacityThreshold = 0.4; // "greater or equal" is kept
    parameters[5].opacity = 0.25;
    parameters[5].isLambert = true;
    const std::vector<float> out = PassThrough(parameters, cosines);
    const double fresnel = 0.04 + 0.96 * std::pow(0.5, 5.0);
    const double expected[6] = {0.0, 0.75 * 0.96, (1.0 - fresnel) * (1.0 - fresnel),
                                1.0, 0.0,         0.75};
    for (std::size_t i = 0; i < 6; ++i) {
        EXPECT_NEAR(out[6 * i], expected[i], 1e-6) << "case " << i;
    }
    EXPECT_EQ(out[6 * 3 + 3], 0.0F); // a cut-out surface reflects nothing
    EXPECT_NEAR(out[3], 0.18 * 0.96 + 0.04, 1e-6);
}

TEST_F(PreviewSurfaceTest, ACutOutSurfaceReflectsNothing) {
    Cases cases = RandomCases(1000, 0.0, 38);
    for (std::size_t i = 0; i < cases.parameters.size(); ++i) {
        cases.packed[16 * i + 10] = 0.3F;
        cases.packed[16 * i + 11] = 0.4F;
    }
    const std::vector<float> values = Evaluate(cases);
    for (std::size_t i = 0; i < cases.parameters.size(); ++i) {
        ASSERT_EQ(values[4 * i] + values[4 * i + 1] + values[4 * i + 2], 0.0F);
    }
}

TEST_F(PreviewSurfaceTest, InputsOutOfRangeGiveFiniteValues) {
    Cases cases = RandomCases(20000, 0.0, 39);
    std::mt19937 generator(40);
    const float hostile[] = {-1.0F, 2.0F, 1e30F, -1e30F, INFINITY, -INFINITY, NAN, 0.0F};
    for (float& value : cases.packed) {
        if (generator() % 3U == 0U) {
            value = hostile[generator() % 8U];
        }
    }
    for (const float value : Evaluate(cases)) {
        ASSERT_TRUE(std::isfinite(value));
        ASSERT_GE(value, 0.0F);
    }
    for (const float value : Sample(cases, 41)) {
        ASSERT_TRUE(std::isfinite(value));
    }
}

} // namespace
} // namespace hds::test
