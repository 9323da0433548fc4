// SPDX-License-Identifier: Apache-2.0
// kernels/shading/material.clh: shading frames face the viewer, normal inputs tilt them, and values
// reach the inputs they belong to.
#include "testenv/support/deviceFixture.h"

#include "kernels/shared/material.h"

#include <glm/geometric.hpp>
#include <glm/vec3.hpp>

#include <array>
#include <cmath>
#include <random>

namespace hds::test {
namespace {

const char* const kSource = R"(
#include "shading/material.clh"
kernel void frames(global const float* in, global float* out, uint count) {
    uint i = (uint)get_global_id(0);
    if (i >= count) return;
    HdsShadingPoint point;
    material_frame(vload3(5 * i, in), vload3(5 * i + 1, in), vload3(5 * i + 2, in),
                   vload3(5 * i + 3, in), (float3)(0.0f), vload3(5 * i + 4, in), &point);
    vstore3(point.frame.z, 4 * i, out);
    vstore3(point.geomNormal, 4 * i + 1, out);
    vstore3(point.geomLocal, 4 * i + 2, out);
    vstore3(point.wo, 4 * i + 3, out);
}
kernel void inputs(global const HdsMaterial* material, global float* out) {
    float4 values[HDS_NUM_INPUTS];
    for (uint i = 0; i < HDS_NUM_INPUTS; ++i) {
        values[i] = material_slot(material, i) == HDS_NONE ? material_constant(material, i)
                                                           : (float4)(-1.0f);
    }
    HdsPreviewInputs p;
    material_readInputs(values, material->flags, &p);
    vstore3(p.diffuseColor, 0, out);
    vstore3(p.emissiveColor, 1, out);
    vstore3(p.specularColor, 2, out);
    vstore8((float8)(p.metallic, p.roughness, p.clearcoat, p.clearcoatRoughness, p.opacity,
                     p.opacityThreshold, p.ior, (float)p.isSpecularWorkflow), 0, out + 9);
    out[17] = (float)p.isLambert;
}
)";

struct Frame {
    glm::dvec3 shading;
    glm::dvec3 geometric;
    glm::dvec3 geomLocal;
    glm::dvec3 wo;
};

class MaterialFrameTest : public DeviceFixture {
protected:
    /// Each case: geometric normal, shading normal, bump, tangent, viewer.
    std::vector<Frame> Frames(const std::vector<std::array<glm::dvec3, 5>>& cases) {
        std::vector<float> in;
        for (const auto& c : cases) {
            for (const glm::dvec3& v : c) {
                in.insert(in.end(), {float(v.x), float(v.y), float(v.z)});
            }
        }
        auto program = Build(kSource);
        const Buffer input = Upload(in);
        const Buffer out = Allocate(cases.size() * 12 * sizeof(float));
        program->GetKernel("frames").Launch(cases.size(), input, out, std::uint32_t(cases.size()));
        const std::vector<float> values = Download<float>(out, cases.size() * 12);
        std::vector<Frame> frames;
        for (std::size_t i = 0; i < cases.size(); ++i) {
            const float* v = &values[12 * i];
            frames.push_back(
                {{v[0], v[1], v[2]}, {v[3], v[4], v[5]}, {v[6], v[7], v[8]}, {v[9], v[10], v[11]}});
        }
        return frames;
    }
};

const glm::dvec3 kNoBump(0.0, 0.0, 1.0);
const glm::dvec3 kZero(0.0);

TEST_F(MaterialFrameTest, BothNormalsFaceTheViewer) {
    std::mt19937 generator(51);
    std::normal_distribution<double> normal;
    const auto unit = [&] {
        return glm::normalize(glm::dvec3(normal(generator), normal(generator), normal(generator)));
    };
    std::vector<std::array<glm::dvec3, 5>> cases;
    for (int i = 0; i < 100000; ++i) {
        const glm::dvec3 ng = unit();
        // Shading normals of any quality, also reversed ones.
        const glm::dvec3 ns = glm::normalize(ng * (generator() & 1U ? 1.0 : -1.0) + 0.9 * unit());
        const glm::dvec3 bump = i % 3 == 0 ? 0.5 * unit() + kNoBump : kNoBump;
        cases.push_back({ng, ns, bump, i % 2 == 0 ? kZero : unit(), unit()});
    }
    const std::vector<Frame> frames = Frames(cases);
    for (std::size_t i = 0; i < cases.size(); ++i) {
        const Frame& f = frames[i];
        const glm::dvec3& viewer = cases[i][4];
        ASSERT_NEAR(glm::length(f.shading), 1.0, 1e-6);
        ASSERT_GT(glm::dot(f.geometric, viewer), -1e-6);
        ASSERT_GT(f.wo.z, 5e-4) << "the viewer is above the shading horizon";
        ASSERT_NEAR(f.wo.z, glm::dot(f.shading, viewer), 1e-6);
        ASSERT_NEAR(f.geomLocal.z, glm::dot(f.shading, f.geometric), 1e-6);
        ASSERT_NEAR(glm::dot(f.geomLocal, f.wo), glm::dot(f.geometric, viewer), 1e-6);
    }
}

TEST_F(MaterialFrameTest, AViewerAboveTheHorizonLeavesTheNormalAlone) {
    const glm::dvec3 ns = glm::normalize(glm::dvec3(0.3, 0.1, 1.0));
    const std::vector<Frame> frames = Frames(
        {{glm::dvec3(0, 0, 1), ns, kNoBump, kZero, glm::normalize(glm::dvec3(0.5, 0.2, 0.6))},
         {glm::dvec3(0, 0, 1), ns, kNoBump, kZero, glm::normalize(glm::dvec3(0.5, 0.2, -0.6))},
         {glm::dvec3(0, 0, 1), -ns, kNoBump, kZero, glm::dvec3(0, 0, 1)},
         {glm::dvec3(0, 0, 1), kZero, kNoBump, kZero, glm::dvec3(0, 0, 1)},
         {glm::dvec3(0, 0, 1), glm::dvec3(NAN), kNoBump, kZero, glm::dvec3(0, 0, 1)}});
    EXPECT_LT(glm::length(frames[0].shading - ns), 1e-6);
    EXPECT_LT(glm::length(frames[1].shading + ns), 1e-6) << "seen from behind";
    EXPECT_LT(glm::length(frames[2].shading - ns), 1e-6) << "a reversed authored normal";
    EXPECT_LT(glm::length(frames[3].shading - glm::dvec3(0, 0, 1)), 1e-6) << "flat";
    EXPECT_LT(glm::length(frames[4].shading - glm::dvec3(0, 0, 1)), 1e-6) << "not finite";
}

TEST_F(MaterialFrameTest, NormalInputsTiltTowardsTheTangent) {
    const glm::dvec3 n(0, 0, 1);
    const glm::dvec3 bump = glm::normalize(glm::dvec3(0.6, 0.0, 0.8));
    const std::vector<Frame> frames =
        Frames({{n, n, bump, glm::dvec3(0, 5, 0), n},
                {n, n, glm::dvec3(0.0, 1.2, 1.6), glm::dvec3(0, 5, 0), n},
                {n, n, bump, glm::dvec3(0, 5, 0), -n},
                {n, n, bump, kZero, n}});
    EXPECT_LT(glm::length(frames[0].shading - glm::dvec3(0.0, 0.6, 0.8)), 1e-6);
    EXPECT_LT(glm::length(frames[1].shading - glm::dvec3(-0.6, 0.0, 0.8)), 1e-6)
        << "bitangent = normal x tangent; length does not matter";
    EXPECT_LT(glm::length(frames[2].shading + glm::dvec3(0.0, 0.6, 0.8)), 1e-6)
        << "from behind: the same surface, turned";
    EXPECT_NEAR(frames[3].shading.z, 0.8, 1e-6) << "no tangent: some frame of the normal";
}

TEST_F(MaterialFrameTest, ValuesReachTheirInputs) {
    shared::HdsMaterial material{};
    for (std::uint32_t i = 0; i < HDS_NUM_INPUTS; ++i) {
        const float base = float(i + 1);
        material.constants[i] = {base, base + 0.25F, base + 0.5F, 0.0F};
        material.slots[i] = HDS_NONE;
    }
    material.slots[HDS_INPUT_ROUGHNESS] = 3;
    material.flags = HDS_MATERIAL_SPECULAR_WORKFLOW;
    auto program = Build(kSource);
    const Buffer in = Upload(std::vector<shared::HdsMaterial>{material});
    const Buffer out = Allocate(18 * sizeof(float));
    program->GetKernel("inputs").Launch(1, in, out);
    const std::vector<float> expected = {1, 1.25F, 1.5F, 2, 2.25F, 2.5F, 3,  3.25F, 3.5F,
                                         5, -1,    7,    8, 9,     10,   11, 1,     0};
    EXPECT_EQ(Download<float>(out, 18), expected);
}

} // namespace
} // namespace hds::test
