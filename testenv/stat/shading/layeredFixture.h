// SPDX-License-Identifier: Apache-2.0
// Layered surfaces (kernels/shading/layeredSurface.clh) on the device: parameters, samples, values.
#pragma once

#include "kernels/shared/material.h"
#include "testenv/support/deviceFixture.h"

#include <glm/vec3.hpp>

#include <array>
#include <cmath>
#include <string>
#include <vector>

namespace hds::test {

/// Inputs as the kernel reads them; black besides what is set.
struct LayeredParameters {
    std::array<std::array<float, 4>, HDS_NUM_LAYERED_INPUTS> values{};
    std::uint32_t flags = 0;
    bool isBack = false;

    LayeredParameters() {
        for (const std::uint32_t input :
             {HDS_INPUT_SPECULAR_COLOR, HDS_INPUT_OPACITY, HDS_INPUT_DIELECTRIC,
              HDS_INPUT_SPECULAR_WEIGHT, HDS_INPUT_METAL_COLOR, HDS_INPUT_EDGE_COLOR,
              HDS_INPUT_COAT_TINT, HDS_INPUT_SHEEN_COLOR, HDS_INPUT_TRANSMISSION_COLOR,
              HDS_INPUT_WEIGHT}) {
            Set(input, 1.0F);
        }
        for (const std::uint32_t input : {HDS_INPUT_STRETCH, HDS_INPUT_COAT_STRETCH}) {
            values[input] = {1.0F, 1.0F, 0.0F, 0.0F};
        }
        for (const std::uint32_t input :
             {HDS_INPUT_SCHLICK_COLOR, HDS_INPUT_SCHLICK_GRAZING, HDS_INPUT_SCHLICK_EDGE}) {
            Set(input, 1.0F);
        }
        Set(HDS_INPUT_IOR, 1.5F);
        Set(HDS_INPUT_COAT_IOR, 1.6F);
        Set(HDS_INPUT_ROUGHNESS, 0.3F);
        Set(HDS_INPUT_SHEEN_ROUGHNESS, 0.3F);
    }
    LayeredParameters& Set(std::uint32_t input, float value) {
        values[input] = {value, value, value, value};
        return *this;
    }
    LayeredParameters& Set(std::uint32_t input, float x, float y, float z) {
        values[input] = {x, y, z, 0.0F};
        return *this;
    }
    /// 4 floats an input, then the flags and the side.
    std::vector<float> Pack() const {
        std::vector<float> packed;
        for (const auto& value : values) {
            packed.insert(packed.end(), value.begin(), value.end());
        }
        packed.push_back(static_cast<float>(flags));
        packed.push_back(isBack ? 1.0F : 0.0F);
        return packed;
    }
};

constexpr const char* kUnpackLayered = R"(
#include "sample/sampler.clh"
#include "shading/layeredSample.clh"
#define PACKED (4 * HDS_NUM_LAYERED_INPUTS + 2)
HdsLayeredSurface unpackLayered(global const float* packed, float3 wo) {
    float4 values[HDS_NUM_LAYERED_INPUTS];
    for (uint i = 0; i < HDS_NUM_LAYERED_INPUTS; ++i) values[i] = vload4(i, packed);
    values[HDS_INPUT_IOR].y = 1.0f; /* air is outside */
    HdsLayeredSurface s;
    const float3 normal = values[HDS_INPUT_COAT_NORMAL].xyz; /* of the base, as the coat has it */
    const bool isOwn = vec_lengthSquared(normal) > 0.0f;
    s.base = frame_fromNormal(isOwn ? normal : (float3)(0.0f, 0.0f, 1.0f));
    layered_setup(&s, values, (uint)packed[PACKED - 2], (float3)(0.0f, 0.0f, 1.0f), wo,
                  packed[PACKED - 1] > 0.0f);
    return s;
}
kernel void evaluateAll(global const float* packed, global const float* directions,
                        global float* out, uint count) {
    uint i = (uint)get_global_id(0);
    if (i >= count) return;
    float3 wo = vload3(2 * i, directions);
    HdsLayeredSurface s = unpackLayered(packed, wo);
    float pdf;
    float3 value = layered_evaluate(&s, wo, vload3(2 * i + 1, directions), &pdf);
    vstore4((float4)(value, pdf), i, out);
}
kernel void sampleAll(global const float* packed, float x, float y, float z,
                      global const float* us, global float* out, uint count) {
    uint i = (uint)get_global_id(0);
    if (i >= count) return;
    float3 wo = (float3)(x, y, z);
    HdsLayeredSurface s = unpackLayered(packed, wo);
    float3 wi;
    float pdf;
    float choice = (float)(sampler_hash(i) >> 8) * 0x1p-24f;
    float3 weight = layered_sample(&s, wo, vload2(i, us), choice, &wi, &pdf);
    float again;
    float3 value = layered_evaluate(&s, wo, wi, &again);
    vstore4((float4)(weight, pdf), 3 * i, out);
    vstore4((float4)(wi, 0.0f), 3 * i + 1, out);
    vstore4((float4)(value, again), 3 * i + 2, out);
}
)";

struct LayeredSample {
    glm::dvec3 weight;
    double pdf;
    glm::dvec3 wi;
    glm::dvec3 value; ///< of an evaluation at wi, with its density
    double evaluatedPdf;
};

class LayeredFixture : public DeviceFixture {
protected:
    void SetUp() override {
        DeviceFixture::SetUp();
        if (device) {
            _program = Build(kUnpackLayered);
        }
    }

    std::vector<LayeredSample> Sample(const LayeredParameters& parameters, const glm::dvec3& wo,
                                      const std::vector<float>& us) {
        const std::size_t count = us.size() / 2;
        const Buffer packed = Upload(parameters.Pack());
        const Buffer in = Upload(us);
        const Buffer out = Allocate(count * 12 * sizeof(float));
        _program->GetKernel("sampleAll")
            .Launch(count, packed, float(wo.x), float(wo.y), float(wo.z), in, out,
                    std::uint32_t(count));
        const std::vector<float> raw = Download<float>(out, count * 12);
        std::vector<LayeredSample> samples;
        for (std::size_t i = 0; i < count; ++i) {
            const float* at = &raw[12 * i];
            samples.push_back({{at[0], at[1], at[2]},
                               at[3],
                               {at[4], at[5], at[6]},
                               {at[8], at[9], at[10]},
                               at[11]});
        }
        return samples;
    }

    /// Values in xyz, densities in w, for pairs of wo and wi.
    std::vector<std::array<double, 4>>
    Evaluate(const LayeredParameters& parameters,
             const std::vector<std::array<glm::dvec3, 2>>& pairs) {
        std::vector<float> directions;
        for (const auto& pair : pairs) {
            for (const glm::dvec3& d : pair) {
                directions.insert(directions.end(), {float(d.x), float(d.y), float(d.z)});
            }
        }
        const Buffer packed = Upload(parameters.Pack());
        const Buffer in = Upload(directions);
        const Buffer out = Allocate(pairs.size() * 4 * sizeof(float));
        _program->GetKernel("evaluateAll")
            .Launch(pairs.size(), packed, in, out, std::uint32_t(pairs.size()));
        const std::vector<float> raw = Download<float>(out, pairs.size() * 4);
        std::vector<std::array<double, 4>> values;
        for (std::size_t i = 0; i < pairs.size(); ++i) {
            values.push_back({raw[4 * i], raw[4 * i + 1], raw[4 * i + 2], raw[4 * i + 3]});
        }
        return values;
    }

    static glm::dvec3 Towards(double cosine, double phi = 0.0) {
        const double sine = std::sqrt(1.0 - cosine * cosine);
        return {sine * std::cos(phi), sine * std::sin(phi), cosine};
    }

private:
    std::unique_ptr<Program> _program;
};

} // namespace hds::test
