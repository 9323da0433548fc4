// SPDX-License-Identifier: Apache-2.0
// Time of the shader stack machine against the same material written into the kernel: a base colour
// with opacity, roughness and metallic from a second texture, a normal map. Prints one line of
// JSON.
//   benchShaderCost [device]
// Both kernels evaluate the inputs alone, or inputs and the BSDF for one direction; results are
// compared bit for bit. Runs are interleaved and the least time of each counts.
#include "testenv/support/plainTextures.h"

#include "hdStream/base/timer.h"
#include "hdStream/device/program.h"
#include "kernels/shared/geometry.h"
#include "kernels/shared/material.h"
#include "kernels/shared/program.h"

#include <algorithm>
#include <array>
#include <cstdio>
#include <cstring>
#include <map>
#include <string>

namespace {

using namespace hds;

const char* const kSource = R"(
#include "shading/program.clh"
#include "shading/material.clh"

void setPoint(uint i, const HdsTextureView* view, global const uint* page, HdsProgramPoint* point) {
    /* Neighbours lie side by side, as the pixels of a tile do. */
    const float2 uv = (float2)((float)(i & 511u), (float)(i >> 9)) / 1024.0f;
    point->attributes = page;
    point->at = attributes_atTriangle(0u, (uint3)(0u, 1u, 2u), uv);
    point->textures = view;
    point->footprint = (float4)(1.3f / 1024.0f, 0.0f, 0.0f, 1.7f / 1024.0f);
    point->mipBias = 0.0f;
    point->choice.number = (float)(i & 63u) / 64.0f;
    point->choice.numTexels = 4u;
    point->isMissing = false;
    point->tangents = (float4)(0.0f);
}

void finish(const float4* values, float4 tangents, uint withBsdf, global float4* out) {
    float4 sum = tangents;
    if (withBsdf == 0u) {
        for (uint k = 0u; k < HDS_NUM_INPUTS; ++k) sum += values[k];
    } else {
        HdsPreviewInputs inputs;
        HdsShadingPoint shading;
        HdsSurface bsdf;
        float pdf;
        material_readInputs(values, 0u, &inputs);
        material_frame((float3)(0.0f, 0.0f, 1.0f), (float3)(0.0f), values[HDS_INPUT_NORMAL].xyz,
                       tangents.xyy, tangents.zwx, vec_normalize((float3)(0.3f, 0.2f, 0.9f)), &shading);
        surface_setup(&bsdf, &inputs, shading.geomLocal);
        const float3 value = surface_evaluate(&bsdf, surface_lobeProbabilities(&bsdf, shading.wo.z), shading.wo,
                                              vec_normalize((float3)(0.2f, -0.4f, 0.7f)), &pdf);
        sum = (float4)(value, pdf);
    }
    *out = sum;
}

kernel void machine(HDS_TEXTURE_ARGS, global const HdsMaterial* material, global const uint* program,
                    global const uint* page, uint withBsdf, global float4* out, uint count) {
    uint i = (uint)get_global_id(0);
    if (i >= count) return;
    HdsTextureView view;
    HDS_TEXTURE_VIEW(view);
    HdsProgramPoint point;
    setPoint(i, &view, page, &point);
    float4 values[HDS_NUM_INPUTS];
    for (uint k = 0u; k < HDS_NUM_INPUTS; ++k) values[k] = material->constants[k];
    program_run(program, false, &point, values);
    finish(values, point.tangents, withBsdf, out + i);
}

float4 lookUp(HdsProgramPoint* point, uint texture, float4 st, float4 d) {
    const float4 f = point->footprint;
    const float4 axes = (float4)(fma(d.x, f.x, d.z * f.y), fma(d.y, f.x, d.w * f.y),
                                 fma(d.x, f.z, d.z * f.w), fma(d.y, f.z, d.w * f.w));
    const float level = lookup_level(point->textures->textures + texture, axes, 0.0f);
    return texture_lookup(point->textures, texture, HDS_LOOKUP_WRAPS(HDS_WRAP_REPEAT, HDS_WRAP_REPEAT),
                          st.xy, level, point->choice, &point->isMissing);
}

kernel void hardCoded(HDS_TEXTURE_ARGS, global const HdsMaterial* material,
                      global const uint* program, global const uint* page, uint withBsdf,
                      global float4* out, uint count) {
    uint i = (uint)get_global_id(0);
    if (i >= count) return;
    HdsTextureView view;
    HDS_TEXTURE_VIEW(view);
    HdsProgramPoint point;
    setPoint(i, &view, page, &point);
    float4 values[HDS_NUM_INPUTS];
    for (uint k = 0u; k < HDS_NUM_INPUTS; ++k) values[k] = material->constants[k];
    float4 alongU, alongV;
    attributes_readDerivatives(page, HDS_SLOT_USER, &point.at, &alongU, &alongV);
    const float4 st = attributes_read(page, HDS_SLOT_USER, &point.at, (float4)(0.0f));
    const float4 d = (float4)(alongU.xy, alongV.xy);
    const float4 base = lookUp(&point, 0u, st, d);
    values[HDS_INPUT_DIFFUSE_COLOR] = base;
    values[HDS_INPUT_OPACITY] = base.wwww;
    const float4 packed = lookUp(&point, 1u, st, d);
    values[HDS_INPUT_ROUGHNESS] = packed.yyyy;
    values[HDS_INPUT_METALLIC] = packed.zzzz;
    const float4 bump = lookUp(&point, 2u, st, d);
    values[HDS_INPUT_NORMAL] = fma(bump, (float4)(2.0f, 2.0f, 2.0f, 1.0f),
                                   (float4)(-1.0f, -1.0f, -1.0f, 0.0f));
    finish(values, d, withBsdf, out + i);
}
)";

constexpr std::uint32_t kCount = 1U << 18U;
constexpr int kRuns = 9;

void AddFloats(std::vector<std::uint32_t>* words, const std::vector<float>& values) {
    for (const float value : values) {
        std::uint32_t word = 0;
        std::memcpy(&word, &value, sizeof(word));
        words->push_back(word);
    }
}

/// What the compiler writes for the material.
std::vector<std::uint32_t> MakeProgram() {
    std::vector<std::uint32_t> words;
    const auto look = [&](std::uint32_t texture, const std::vector<float>& parameters,
                          std::uint32_t flags) {
        words.push_back(HDS_OP(HDS_OP_COORDINATES, HDS_SLOT_USER));
        words.push_back(
            HDS_OP(HDS_OP_TEXTURE, HDS_LOOKUP_WRAPS(HDS_WRAP_REPEAT, HDS_WRAP_REPEAT) | flags));
        words.push_back(1);
        words.push_back(texture);
        AddFloats(&words, parameters);
    };
    const auto store = [&](std::uint32_t input, std::uint32_t channel) {
        words.push_back(HDS_OP(HDS_OP_STORE, HDS_STORE(input, channel)));
    };
    const std::vector<float> plain = {0, 0, 0, 1, 1, 1, 1, 1, 0, 0, 0, 0};
    look(0, plain, 0);
    store(HDS_INPUT_DIFFUSE_COLOR, HDS_CHANNEL_ALL);
    store(HDS_INPUT_OPACITY, 3);
    words.push_back(HDS_OP(HDS_OP_POP, 0U));
    words.push_back(HDS_OP(HDS_OP_MASK_END, 0U));
    look(2, {0, 0, 0, 1, 2, 2, 2, 1, -1, -1, -1, 0}, HDS_LOOKUP_TANGENTS);
    store(HDS_INPUT_NORMAL, HDS_CHANNEL_ALL);
    words.push_back(HDS_OP(HDS_OP_POP, 0U));
    look(1, plain, 0);
    store(HDS_INPUT_METALLIC, 2);
    store(HDS_INPUT_ROUGHNESS, 1);
    words.push_back(HDS_OP(HDS_OP_POP, 0U));
    words.push_back(HDS_OP(HDS_OP_END, 0U));
    return words;
}

std::vector<std::uint32_t> MakePage() {
    std::vector<std::uint32_t> page(4, 0);
    page[HDS_SLOT_USER] = HDS_ATTR_SLOT(HDS_ATTR_VERTEX, 2U, 1U);
    AddFloats(&page, {0, 0, 1, 0, 0, 1, 0, 0});
    return page;
}

} // namespace

int main(int argc, char** argv) {
    const std::shared_ptr<Device> device = Device::Create(argc > 1 ? argv[1] : "");
    const std::string text = kSource;
    Program program(device, "shaderCost.cl",
                    {{"HDS_NUM_TEXTURE_POOLS", "1"}, {"HDS_TEXTURE_PLAIN", "1"}}, nullptr, &text);
    test::PlainTextures textures;
    for (std::uint32_t seed = 0; seed < 3; ++seed) {
        textures.Add(1024, 1024, HDS_TEXEL_U8 | 2U | (seed == 0 ? HDS_TEXEL_SRGB : 0U),
                     HDS_SWIZZLE_RGBA, seed + 1);
    }
    shared::HdsMaterial material{};
    for (shared::float4& constant : material.constants) {
        constant = {0.5F, 0.5F, 0.5F, 1.0F};
    }
    const Buffer records = UploadVector(device, "textures", textures.Records());
    const Buffer texels = UploadVector(device, "texels", textures.Texels());
    const Buffer materials =
        UploadVector(device, "material", std::vector<shared::HdsMaterial>{material});
    const Buffer words = UploadVector(device, "program", MakeProgram());
    const Buffer page = UploadVector(device, "page", MakePage());
    std::map<std::string, double> best;
    bool isSame = true;
    std::map<std::string, Kernel> kernels;
    kernels.emplace("machine", program.GetKernel("machine"));
    kernels.emplace("hardCoded", program.GetKernel("hardCoded"));
    for (const std::uint32_t withBsdf : {0U, 1U}) {
        std::array<std::vector<float>, 2> results;
        for (int run = 0; run <= kRuns; ++run) { // the first warms up
            int which = 0;
            for (auto& [name, kernel] : kernels) {
                const Buffer out(device, "out", kCount * 4 * sizeof(float));
                const Timer timer;
                kernel.Launch(kCount, HDS_TEST_TEXTURE_ARGS(records, texels), materials, words,
                              page, withBsdf, out, kCount);
                device->Finish();
                const double seconds = timer.Seconds();
                const std::string key = name + (withBsdf != 0 ? "WithBsdf" : "");
                if (run > 0 && (best.count(key) == 0 || seconds < best[key])) {
                    best[key] = seconds;
                }
                results[static_cast<std::size_t>(which)].resize(kCount * 4);
                out.Read(results[static_cast<std::size_t>(which)].data(),
                         kCount * 4 * sizeof(float));
                ++which;
            }
        }
        isSame = isSame && std::memcmp(results[0].data(), results[1].data(),
                                       results[0].size() * sizeof(float)) == 0;
    }
    const double scale = 1e9 / kCount;
    std::printf(
        "{\"machine\": %.1f, \"hardCoded\": %.1f, \"ratio\": %.3f, \"machineWithBsdf\": %.1f, "
        "\"hardCodedWithBsdf\": %.1f, \"ratioWithBsdf\": %.3f, \"sameBits\": %s}\n",
        best["machine"] * scale, best["hardCoded"] * scale, best["machine"] / best["hardCoded"],
        best["machineWithBsdf"] * scale, best["hardCodedWithBsdf"] * scale,
        best["machineWithBsdf"] / best["hardCodedWithBsdf"], isSame ? "true" : "false");
    return isSame ? 0 : 1;
}
