// SPDX-License-Identifier: Apache-2.0
// The directional albedo of every lobe equals a double-precision integral of its formula within
// 0.5 % and never exceeds 1: once by sampling, once by quadrature of the evaluation.
#include "testenv/device/shading/previewReference.h"
#include "testenv/support/deviceFixture.h"

#include <algorithm>
#include <cmath>
#include <string>

namespace hds::test {
namespace {

constexpr double kTolerance = 0.005; // of the requirement
constexpr std::uint32_t kChunks = 64;
constexpr std::uint32_t kSamplesPerChunk = 1024;

const char* const kKernels = R"(
#include "sample/sampler.clh"
kernel void albedos(global const float* parameters, global const float* cosines, uint perChunk,
                    uint chunks, global float* out, uint count) {
    uint i = (uint)get_global_id(0);
    if (i >= count) return;
    uint config = i / chunks;
    HdsSurface s = unpackSurface(parameters + 16 * config, (float3)(0.0f, 0.0f, 1.0f));
    float cosO = cosines[config];
    float3 wo = (float3)(sqrt((1.0f - cosO) * (1.0f + cosO)), 0.0f, cosO);
    float3 sum = (float3)(0.0f);
    for (uint k = 0; k < perChunk; ++k) {
        HdsSampler sampler = sampler_init(config, 0u, (i % chunks) * perChunk + k, 1u);
        float3 wi;
        float pdf;
        sum += surface_sample(&s, surface_lobeProbabilities(&s, wo.z), wo,
                              sampler_get2(sampler, 1u), &wi, &pdf);
    }
    vstore3(sum / (float)perChunk, i, out);
}
kernel void evaluateAll(global const float* parameters, float cosO, global const float* directions,
                        global float* out, uint count) {
    uint i = (uint)get_global_id(0);
    if (i >= count) return;
    HdsSurface s = unpackSurface(parameters, (float3)(0.0f, 0.0f, 1.0f));
    float3 wo = (float3)(sqrt((1.0f - cosO) * (1.0f + cosO)), 0.0f, cosO);
    float pdf;
    vstore3(surface_evaluate(&s, surface_lobeProbabilities(&s, wo.z), wo,
                              vload3(i, directions), &pdf), i, out);
}
)";

const double kCosines[] = {0.02, 0.1, 0.3, 0.7, 1.0};
const double kRoughness[] = {0.0, 0.05, 0.2, 0.5, 1.0};

struct Case {
    std::string name;
    PreviewParameters parameters;
};

/// Each lobe alone: the others are black by their parameters.
PreviewParameters LambertOnly() {
    PreviewParameters p;
    p.diffuseColor = glm::dvec3(1.0, 0.5, 0.1);
    p.isLambert = true;
    return p;
}
PreviewParameters DielectricOnly(double roughness) {
    PreviewParameters p;
    p.diffuseColor = glm::dvec3(0.0);
    p.roughness = roughness;
    return p;
}
PreviewParameters MetalOnly(double roughness) {
    PreviewParameters p;
    p.diffuseColor = glm::dvec3(1.0, 0.8, 0.3);
    p.metallic = 1.0;
    p.roughness = roughness;
    return p;
}
PreviewParameters SpecularWorkflowOnly(double roughness) {
    PreviewParameters p = DielectricOnly(roughness);
    p.isSpecularWorkflow = true;
    p.specularColor = glm::dvec3(1.0, 0.4, 0.0);
    return p;
}
PreviewParameters CoatOnly(double roughness) {
    PreviewParameters p;
    p.diffuseColor = glm::dvec3(0.0);
    p.metallic = 1.0;
    p.clearcoat = 1.0;
    p.clearcoatRoughness = roughness;
    return p;
}
PreviewParameters Everything(double roughness) {
    PreviewParameters p;
    p.diffuseColor = glm::dvec3(0.9, 0.5, 0.2);
    p.metallic = 0.3;
    p.roughness = roughness;
    p.clearcoat = 0.7;
    p.clearcoatRoughness = 0.1;
    p.opacity = 0.8;
    return p;
}
PreviewParameters WhiteDielectric(double roughness) {
    PreviewParameters p = DielectricOnly(roughness);
    p.diffuseColor = glm::dvec3(1.0);
    return p;
}

std::vector<Case> AllCases() {
    std::vector<Case> cases{{"lambert", LambertOnly()}};
    for (const double r : kRoughness) {
        const std::string suffix = " roughness " + std::to_string(r);
        cases.push_back({"dielectric" + suffix, DielectricOnly(r)});
        cases.push_back({"metal" + suffix, MetalOnly(r)});
        cases.push_back({"specular workflow" + suffix, SpecularWorkflowOnly(r)});
        cases.push_back({"clearcoat" + suffix, CoatOnly(r)});
        cases.push_back({"everything" + suffix, Everything(r)});
        cases.push_back({"white dielectric" + suffix, WhiteDielectric(r)});
    }
    return cases;
}

class AlbedoTest : public DeviceFixture {
protected:
    void SetUp() override {
        DeviceFixture::SetUp();
        if (device) {
            _program = Build(std::string(kUnpackSurface) + kKernels);
        }
    }
    std::vector<glm::dvec3> SampledAlbedos(const std::vector<PreviewParameters>& parameters,
                                           const std::vector<float>& cosines) {
        std::vector<float> packed;
        for (const PreviewParameters& p : parameters) {
            const std::vector<float> one = p.Pack();
            packed.insert(packed.end(), one.begin(), one.end());
        }
        const std::size_t items = parameters.size() * kChunks;
        const Buffer packedBuffer = Upload(packed);
        const Buffer cosineBuffer = Upload(cosines);
        const Buffer out = Allocate(items * 3 * sizeof(float));
        _program->GetKernel("albedos").Launch(items, packedBuffer, cosineBuffer, kSamplesPerChunk,
                                              kChunks, out, std::uint32_t(items));
        const std::vector<float> sums = Download<float>(out, items * 3);
        std::vector<glm::dvec3> albedos(parameters.size(), glm::dvec3(0.0));
        for (std::size_t i = 0; i < items; ++i) {
            albedos[i / kChunks] +=
                glm::dvec3(sums[3 * i], sums[3 * i + 1], sums[3 * i + 2]) / double(kChunks);
        }
        return albedos;
    }
    std::unique_ptr<Program> _program;
};

TEST_F(AlbedoTest, SampledAlbedosEqualTheIntegralsOfTheFormulas) {
    std::vector<PreviewParameters> parameters;
    std::vector<float> cosines;
    std::vector<std::string> names;
    for (const Case& c : AllCases()) {
        for (const double cosine : kCosines) {
            parameters.push_back(c.parameters);
            cosines.push_back(float(cosine));
            names.push_back(c.name + " cosine " + std::to_string(cosine));
        }
    }
    const std::vector<glm::dvec3> sampled = SampledAlbedos(parameters, cosines);
    double largestSum = 0.0;
    double worst = 0.0;
    for (std::size_t i = 0; i < parameters.size(); ++i) {
        const PreviewReference reference(parameters[i]);
        const glm::dvec3 diffuse = reference.DiffuseAlbedo(cosines[i]);
        const glm::dvec3 specular = reference.SpecularAlbedo(cosines[i]);
        const double coat = reference.CoatAlbedo(cosines[i]);
        EXPECT_LE(std::max({diffuse.x, diffuse.y, diffuse.z}), 1.0 + 1e-6) << names[i];
        EXPECT_LE(std::max({specular.x, specular.y, specular.z}), 1.0 + 1e-6) << names[i];
        EXPECT_LE(coat, 1.0 + 1e-6) << names[i];
        const glm::dvec3 expected = diffuse + specular + coat;
        largestSum = std::max(largestSum, expected.x);
        for (int c = 0; c < 3; ++c) {
            EXPECT_NEAR(sampled[i][c], expected[c], kTolerance * expected[c] + 1e-6) << names[i];
            worst = std::max(worst,
                             std::abs(sampled[i][c] - expected[c]) / std::max(expected[c], 1e-3));
        }
        const bool isOneLobe =
            names[i].compare(0, 10, "everything") != 0 && names[i].compare(0, 5, "white") != 0;
        if (isOneLobe) {
            EXPECT_LE(sampled[i].x, 1.0 + 1e-4) << names[i];
        }
    }
    RecordProperty("worstRelativeError", std::to_string(worst));
    RecordProperty("largestSumOfLobes", std::to_string(largestSum));
}

/// Integral of the device's evaluation over microfacet normals of a lobe with this alpha.
TEST_F(AlbedoTest, QuadratureOfTheEvaluationEqualsTheIntegralsOfTheFormulas) {
    constexpr int kSteps = 384;
    for (const double roughness : {0.1, 0.3, 0.7, 1.0}) {
        const double alpha = roughness * roughness;
        for (const Case& c :
             {Case{"dielectric", DielectricOnly(roughness)}, Case{"metal", MetalOnly(roughness)},
              Case{"clearcoat", CoatOnly(roughness)}}) {
            for (const double cosO : {0.1, 0.5, 1.0}) {
                const glm::dvec3 wo(std::sqrt(1.0 - cosO * cosO), 0.0, cosO);
                std::vector<float> directions;
                std::vector<double> weights;
                for (int i = 0; i < kSteps * kSteps; ++i) {
                    const double s = (i / kSteps + 0.5) / kSteps;
                    const double phi = 2.0 * kReferencePi * (i % kSteps + 0.5) / kSteps;
                    const double tangent = alpha * std::sqrt(s / (1.0 - s));
                    const double cosH = 1.0 / std::sqrt(1.0 + tangent * tangent);
                    const glm::dvec3 h(tangent * cosH * std::cos(phi),
                                       tangent * cosH * std::sin(phi), cosH);
                    const double e = glm::dot(wo, h);
                    const glm::dvec3 wi = 2.0 * e * h - wo;
                    directions.insert(directions.end(),
                                      {float(wi.x), float(wi.y), e > 0.0 ? float(wi.z) : -1.0F});
                    weights.push_back(4.0 * e /
                                      (PreviewReference::Distribution(cosH, alpha) * cosH) /
                                      (double(kSteps) * kSteps));
                }
                const Buffer packed = Upload(c.parameters.Pack());
                const Buffer in = Upload(directions);
                const Buffer out = Allocate(directions.size() * sizeof(float));
                _program->GetKernel("evaluateAll")
                    .Launch(weights.size(), packed, float(cosO), in, out,
                            std::uint32_t(weights.size()));
                const std::vector<float> values = Download<float>(out, directions.size());
                double integral = 0.0;
                for (std::size_t i = 0; i < weights.size(); ++i) {
                    integral += values[3 * i] * weights[i];
                }
                const PreviewReference reference(c.parameters);
                const double expected =
                    reference.SpecularAlbedo(cosO).x + reference.CoatAlbedo(cosO);
                EXPECT_NEAR(integral, expected, kTolerance * expected)
                    << c.name << " roughness " << roughness << " cosine " << cosO;
                EXPECT_LE(integral, 1.0 + 1e-4);
            }
        }
    }
}

} // namespace
} // namespace hds::test
