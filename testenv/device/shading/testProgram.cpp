// SPDX-License-Identifier: Apache-2.0
// kernels/shading/program.clh: every operation of the stack machine against double precision, with
// look-ups whose footprints come from the coordinates' derivatives.
#include "testenv/support/deviceFixture.h"
#include "testenv/support/testTextures.h"

#include "kernels/shared/geometry.h"
#include "kernels/shared/material.h"
#include "kernels/shared/program.h"

#include <glm/glm.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <random>

namespace hds::test {
namespace {

const ProgramDefines kDefines = {{"HDS_NUM_TEXTURE_POOLS", "1"}};
const char* const kSource = R"(
#include "shading/program.clh"
kernel void run(HDS_TEXTURE_ARGS, global const uint* program, global const uint* page,
                global const float* in, uint isMask, uint numTexels, global float4* out,
                uint count) {
    uint i = (uint)get_global_id(0);
    if (i >= count) return;
    HdsTextureView view;
    HDS_TEXTURE_VIEW(view);
    HdsProgramPoint point;
    point.attributes = page;
    point.at = attributes_atTriangle(0u, (uint3)(0u, 1u, 2u), vload2(3 * i, in));
    point.textures = &view;
    point.footprint = (float4)(vload2(3 * i + 1, in), vload2(3 * i + 2, in));
    point.mipBias = 0.0f;
#if HDS_FEATURE_VOLUME_PATTERNS
    point.isCoarse = false;
#endif
    point.choice = (HdsTexelChoice){(float)(i % 16u) / 16.0f, numTexels};
    point.isMissing = false;
    point.tangents = (float4)(0.0f);
    float4 values[HDS_NUM_INPUTS];
    for (uint k = 0; k < HDS_NUM_INPUTS; ++k) values[k] = (float4)(-7.0f);
    program_run(program, isMask != 0u, &point, values);
    for (uint k = 0; k < HDS_NUM_INPUTS; ++k) out[(HDS_NUM_INPUTS + 1) * i + k] = values[k];
    out[(HDS_NUM_INPUTS + 1) * i + HDS_NUM_INPUTS] = point.tangents;
}
kernel void tangents(global const float* in, global float* out, uint count) {
    uint i = (uint)get_global_id(0);
    if (i >= count) return;
    float3 alongS, alongT;
    program_tangents(vload4(0, in + 10 * i), vload3(0, in + 10 * i + 4), vload3(0, in + 10 * i + 7),
                     &alongS, &alongT);
    vstore3(alongS, 2 * i, out);
    vstore3(alongT, 2 * i + 1, out);
}
)";

/// Where on the triangle, and the footprint in barycentrics.
struct Point {
    glm::vec2 uv;
    glm::vec4 footprint;
};

/// Inputs by HDS_INPUT_*, then the tangents.
using Values = std::array<glm::vec4, HDS_NUM_INPUTS + 1>;

const glm::dvec2 kSt[3] = {{0.125, 0.25}, {1.5, 0.5}, {0.75, 2.25}};
const glm::dvec4 kColor[3] = {{1, 2, 3, 4}, {0, 8, -1, 2}, {5, 5, 1, 0}};
constexpr std::uint32_t kStSlot = HDS_SLOT_USER;
constexpr std::uint32_t kColorSlot = HDS_SLOT_USER + 1;

template <typename T>
T Interpolate(const T (&corners)[3], glm::dvec2 uv) {
    return corners[0] + uv.x * (corners[1] - corners[0]) + uv.y * (corners[2] - corners[0]);
}

/// Writes words the way a reader of shared/program.h would.
class Words {
public:
    Words& Op(std::uint32_t operation, std::uint32_t argument = 0) {
        words.push_back(HDS_OP(operation, argument));
        return *this;
    }
    Words& Raw(std::uint32_t word) {
        words.push_back(word);
        return *this;
    }
    Words& Floats(const std::vector<float>& values) {
        for (const float value : values) {
            std::uint32_t word = 0;
            std::memcpy(&word, &value, sizeof(word));
            words.push_back(word);
        }
        return *this;
    }
    Words& Constant(const glm::vec4& value) {
        return Op(HDS_OP_CONSTANT).Floats({value.x, value.y, value.z, value.w});
    }
    Words& Store(std::uint32_t input, std::uint32_t channel = HDS_CHANNEL_ALL) {
        return Op(HDS_OP_STORE, HDS_STORE(input, channel));
    }
    std::vector<std::uint32_t> words;
};

class ProgramKernelTest : public DeviceFixture {
protected:
    void SetUp() override {
        DeviceFixture::SetUp();
        if (IsSkipped()) {
            return;
        }
        texture = textures.Add(64, 32, HDS_TEXEL_FLOAT | 2U, HDS_SWIZZLE_RGBA, 11);
        std::mt19937 generator(3);
        std::uniform_real_distribution<float> unit(0.0F, 1.0F);
        for (int i = 0; i < 200; ++i) {
            const float size = std::exp2(-10.0F * unit(generator));
            points.push_back({{unit(generator), unit(generator)},
                              size * (glm::vec4(unit(generator), unit(generator), unit(generator),
                                                unit(generator)) -
                                      0.5F)});
        }
    }

    /// \param numTexels as HdsTexelChoice; numbers that choose run over [0, 1)
    std::vector<Values> Run(Words& words, bool isMask = false, std::uint32_t numTexels = 8) {
        words.Op(HDS_OP_END);
        if (!_program) {
            _program = Build(kSource, kDefines);
        }
        std::vector<float> in;
        for (const Point& p : points) {
            in.insert(in.end(),
                      {p.uv.x, p.uv.y, p.footprint.x, p.footprint.y, p.footprint.z, p.footprint.w});
        }
        const Buffer records = Upload(textures.Records());
        const Buffer lines = Upload(textures.Lines());
        const Buffer program = Upload(words.words);
        const Buffer page = Upload(Page());
        const Buffer input = Upload(in);
        const Buffer out = Allocate(points.size() * sizeof(Values));
        _program->GetKernel("run").Launch(points.size(), HDS_TEST_TEXTURE_ARGS(records, lines),
                                          program, page, input, std::uint32_t(isMask ? 1 : 0),
                                          numTexels, out, std::uint32_t(points.size()));
        return Download<Values>(out, points.size());
    }

    /// One triangle: st by vertex, a colour by corner.
    static std::vector<std::uint32_t> Page() {
        std::vector<std::uint32_t> page(8, 0);
        Words values;
        for (const glm::dvec2& st : kSt) {
            values.Floats({float(st.x), float(st.y)});
        }
        values.Floats({0.0F, 0.0F}); // to 16 bytes
        for (const glm::dvec4& color : kColor) {
            values.Floats({float(color.x), float(color.y), float(color.z), float(color.w)});
        }
        page[kStSlot] = HDS_ATTR_SLOT(HDS_ATTR_VERTEX, 2U, 2U);
        page[kColorSlot] = HDS_ATTR_SLOT(HDS_ATTR_CORNER, 4U, 4U);
        page.insert(page.end(), values.words.begin(), values.words.end());
        return page;
    }

    /// The look-up at coordinates `origin + matrix * st`, with the footprint that follows from
    /// them.
    glm::dvec4 Expected(const Point& p, const glm::dmat2& matrix, glm::dvec2 origin,
                        std::uint32_t index, std::uint32_t wrap) const {
        const glm::dvec2 st = origin + matrix * Interpolate(kSt, p.uv);
        const glm::dvec2 alongU = matrix * (kSt[1] - kSt[0]);
        const glm::dvec2 alongV = matrix * (kSt[2] - kSt[0]);
        const glm::dvec2 a = double(p.footprint.x) * alongU + double(p.footprint.y) * alongV;
        const glm::dvec2 b = double(p.footprint.z) * alongU + double(p.footprint.w) * alongV;
        return LookUp(textures, index, wrap, wrap, st, glm::dvec4(a, b), 0.0);
    }

    static void ExpectNear(const glm::vec4& found, const glm::dvec4& expected, double tolerance) {
        for (int c = 0; c < 4; ++c) {
            ASSERT_NEAR(found[c], expected[c], tolerance) << "channel " << c;
        }
    }

    static constexpr std::uint32_t kRepeat = HDS_LOOKUP_WRAPS(HDS_WRAP_REPEAT, HDS_WRAP_REPEAT);
    const std::vector<float> kPlain = {0, 0, 0, 1, 1, 1, 1, 1, 0, 0, 0, 0};
    TestTextures textures;
    std::uint32_t texture = 0;
    std::vector<Point> points;

private:
    std::unique_ptr<Program> _program;
};

TEST_F(ProgramKernelTest, ConstantsPrimvarsAndChannelsAreStored) {
    Words words;
    words.Constant({1, 2, 3, 4}).Store(HDS_INPUT_IOR, 2).Op(HDS_OP_CHANNEL, HDS_STORE(0U, 1U));
    words.Store(HDS_INPUT_DIFFUSE_COLOR).Op(HDS_OP_POP);
    words.Op(HDS_OP_PRIMVAR, kColorSlot)
        .Store(HDS_INPUT_EMISSIVE_COLOR)
        .Store(HDS_INPUT_OPACITY, 3);
    const std::vector<Values> found = Run(words);
    for (std::size_t i = 0; i < points.size(); ++i) {
        const glm::dvec4 color = Interpolate(kColor, points[i].uv);
        EXPECT_EQ(found[i][HDS_INPUT_IOR], glm::vec4(3.0F));
        EXPECT_EQ(found[i][HDS_INPUT_DIFFUSE_COLOR], glm::vec4(2.0F));
        ExpectNear(found[i][HDS_INPUT_EMISSIVE_COLOR], color, 1e-5);
        ExpectNear(found[i][HDS_INPUT_OPACITY], glm::dvec4(color.w), 1e-5);
        EXPECT_EQ(found[i][HDS_INPUT_ROUGHNESS], glm::vec4(-7.0F)) << "not set";
    }
}

TEST_F(ProgramKernelTest, AMaskEndsEarly) {
    for (const bool isMask : {true, false}) {
        Words words;
        words.Constant({1, 2, 3, 4}).Store(HDS_INPUT_OPACITY, 0).Op(HDS_OP_MASK_END);
        words.Store(HDS_INPUT_ROUGHNESS, 1);
        const Values found = Run(words, isMask)[0];
        EXPECT_EQ(found[HDS_INPUT_OPACITY], glm::vec4(1.0F));
        EXPECT_EQ(found[HDS_INPUT_ROUGHNESS], glm::vec4(isMask ? -7.0F : 2.0F));
    }
}

TEST_F(ProgramKernelTest, LookUpsFollowTheCoordinatesAndTheirDerivatives) {
    Words words;
    words.Op(HDS_OP_COORDINATES, kStSlot);
    words.Op(HDS_OP_TEXTURE, kRepeat | HDS_LOOKUP_TANGENTS).Raw(1).Raw(texture);
    words.Floats({0, 0, 0, 1, 2, 3, 4, 5, -1, -2, -3, -4}).Store(HDS_INPUT_DIFFUSE_COLOR);
    const std::vector<Values> found = Run(words);
    for (std::size_t i = 0; i < points.size(); ++i) {
        const glm::dvec4 texel =
            Expected(points[i], glm::dmat2(1.0), glm::dvec2(0.0), texture, HDS_WRAP_REPEAT);
        ExpectNear(found[i][HDS_INPUT_DIFFUSE_COLOR],
                   texel * glm::dvec4(2, 3, 4, 5) - glm::dvec4(1, 2, 3, 4), 2e-3);
        ExpectNear(found[i][HDS_NUM_INPUTS], glm::dvec4(kSt[1] - kSt[0], kSt[2] - kSt[0]), 1e-6);
    }
}

TEST_F(ProgramKernelTest, TransformsMapCoordinatesAndFootprints) {
    const double angle = glm::radians(35.0);
    const glm::dmat2 turn(std::cos(angle), std::sin(angle), -std::sin(angle), std::cos(angle));
    const glm::dmat2 matrix = turn * glm::dmat2(2.0, 0.0, 0.0, 0.5);
    for (const bool isFolded : {true, false}) {
        Words words;
        words.Op(HDS_OP_COORDINATES, kStSlot);
        if (isFolded) {
            words.Op(HDS_OP_AFFINE)
                .Floats({float(matrix[0][0]), float(matrix[1][0]), 0.25F, float(matrix[0][1]),
                         float(matrix[1][1]), -0.5F});
        } else {
            words.Constant({35, 0, 0, 0}).Constant({2, 0.5, 0, 0}).Constant({0.25, -0.5, 0, 0});
            words.Op(HDS_OP_TRANSFORM);
        }
        words.Op(HDS_OP_TEXTURE, kRepeat).Raw(1).Raw(texture).Floats(kPlain);
        words.Store(HDS_INPUT_DIFFUSE_COLOR);
        const std::vector<Values> found = Run(words);
        for (std::size_t i = 0; i < points.size(); ++i) {
            ExpectNear(found[i][HDS_INPUT_DIFFUSE_COLOR],
                       Expected(points[i], matrix, {0.25, -0.5}, texture, HDS_WRAP_REPEAT), 2e-3);
        }
    }
}

// The texels of the look-up before are read again where that is right, and nowhere else.
TEST_F(ProgramKernelTest, LookUpsAtTheSameCoordinatesHaveTheBitsOfLookUpsAlone) {
    const std::uint32_t ofOneSize = textures.Add(64, 32, HDS_TEXEL_FLOAT | 2U, HDS_SWIZZLE_RGBA, 5);
    const std::uint32_t taller = textures.Add(64, 64, HDS_TEXEL_FLOAT | 2U, HDS_SWIZZLE_RGBA, 7);
    const std::uint32_t turned = textures.Add(32, 64, HDS_TEXEL_FLOAT | 2U, HDS_SWIZZLE_RGBA, 6);
    const std::uint32_t clamp = HDS_LOOKUP_WRAPS(HDS_WRAP_CLAMP, HDS_WRAP_CLAMP);
    struct Step {
        std::uint32_t texture;
        std::uint32_t flags;
        bool isElsewhere;
    };
    const Step steps[] = {{texture, kRepeat, false},
                          {ofOneSize, kRepeat | HDS_LOOKUP_AGAIN, false},
                          {taller, kRepeat | HDS_LOOKUP_AGAIN, false},
                          {turned, kRepeat | HDS_LOOKUP_AGAIN, false},
                          {turned, clamp | HDS_LOOKUP_AGAIN, false},
                          {turned, clamp | HDS_LOOKUP_UDIM | HDS_LOOKUP_AGAIN, false},
                          {turned, clamp | HDS_LOOKUP_AGAIN | HDS_LOOKUP_TANGENTS, false},
                          {turned, clamp, true}};
    for (const std::uint32_t numTexels : {1U, 4U, 8U}) {
        const auto run = [&](bool isAgain) {
            Words words;
            std::uint32_t input = 0;
            for (const Step& step : steps) {
                const bool pops = (step.flags & HDS_LOOKUP_AGAIN) == 0 || !isAgain;
                if (step.isElsewhere) {
                    words.Constant({0.3, 0.6, 0, 0}).Constant({1, 0, 0, 1});
                } else if (pops) {
                    words.Op(HDS_OP_COORDINATES, kStSlot);
                }
                words.Op(HDS_OP_TEXTURE, pops ? step.flags & ~HDS_LOOKUP_AGAIN : step.flags);
                words.Raw(1).Raw(step.texture).Floats({9, 9, 9, 9, 1, 1, 1, 1, 0, 0, 0, 0});
                words.Store(input++).Op(HDS_OP_POP);
            }
            return Run(words, false, numTexels);
        };
        const std::vector<Values> again = run(true);
        const std::vector<Values> alone = run(false);
        int numUnlike[std::size(steps)] = {};
        for (std::size_t i = 0; i < points.size(); ++i) {
            for (std::size_t k = 0; k < again[i].size(); ++k) {
                ASSERT_EQ(again[i][k], alone[i][k]) << numTexels << " texels, input " << k;
            }
            for (std::size_t k = 1; k < std::size(steps); ++k) {
                numUnlike[k] += again[i][k] != again[i][k - 1] ? 1 : 0;
            }
        }
        for (std::size_t k = 1; k < std::size(steps); ++k) {
            EXPECT_GT(numUnlike[k], 20) << "look-ups " << k - 1 << " and " << k;
        }
    }
}

TEST_F(ProgramKernelTest, ParametersMayComeFromTheStack) {
    Words words;
    words.Constant({9, 9, 9, 9}).Op(HDS_OP_PRIMVAR, kColorSlot).Constant({1, 2, 3, 4});
    words.Op(HDS_OP_COORDINATES, kStSlot);
    words.Op(HDS_OP_TEXTURE, kRepeat | HDS_LOOKUP_POPS).Raw(1).Raw(texture);
    words.Store(HDS_INPUT_DIFFUSE_COLOR).Op(HDS_OP_POP).Constant({5, 0, 0, 0});
    words.Store(HDS_INPUT_ROUGHNESS);
    const std::vector<Values> found = Run(words);
    for (std::size_t i = 0; i < points.size(); ++i) {
        const glm::dvec4 texel =
            Expected(points[i], glm::dmat2(1.0), glm::dvec2(0.0), texture, HDS_WRAP_REPEAT);
        const glm::dvec4 scale = Interpolate(kColor, points[i].uv);
        ExpectNear(found[i][HDS_INPUT_DIFFUSE_COLOR], texel * scale + glm::dvec4(1, 2, 3, 4), 1e-2);
        EXPECT_EQ(found[i][HDS_INPUT_ROUGHNESS].x, 5.0F);
    }
}

TEST_F(ProgramKernelTest, TilesAreFoundByTheirNumber) {
    const std::uint32_t other = textures.Add(8, 8, HDS_TEXEL_FLOAT | 2U, HDS_SWIZZLE_RGBA, 12);
    const std::uint32_t wraps = HDS_LOOKUP_WRAPS(HDS_WRAP_CLAMP, HDS_WRAP_CLAMP);
    Words words;
    words.Op(HDS_OP_COORDINATES, kStSlot);
    // 1001 and 1011; 1002 and what lies beyond are holes.
    words.Op(HDS_OP_TEXTURE, wraps | HDS_LOOKUP_UDIM).Raw(11).Raw(texture);
    for (int i = 1; i < 10; ++i) {
        words.Raw(HDS_NONE);
    }
    words.Raw(other).Floats({7, 8, 9, 10, 1, 1, 1, 1, 0, 0, 0, 0}).Store(HDS_INPUT_DIFFUSE_COLOR);
    const std::vector<Values> found = Run(words);
    int seen[3] = {};
    for (std::size_t i = 0; i < points.size(); ++i) {
        const glm::dvec2 st = Interpolate(kSt, points[i].uv);
        const glm::dvec2 tile = glm::floor(st);
        if (std::abs(st.x - std::round(st.x)) < 1e-5 || std::abs(st.y - std::round(st.y)) < 1e-5) {
            continue;
        }
        const bool isFirst = tile == glm::dvec2(0, 0);
        const bool isOther = tile == glm::dvec2(0, 1);
        ++seen[isFirst ? 0 : isOther ? 1 : 2];
        ExpectNear(found[i][HDS_INPUT_DIFFUSE_COLOR],
                   isFirst || isOther ? Expected(points[i], glm::dmat2(1.0), -tile,
                                                 isFirst ? texture : other, HDS_WRAP_CLAMP)
                                      : glm::dvec4(7, 8, 9, 10),
                   2e-3);
    }
    EXPECT_GT(std::min({seen[0], seen[1], seen[2]}), 5);
}

TEST_F(ProgramKernelTest, WhatIsNoTileOrCannotBeReadIsAHole) {
    TestTextures empty;
    textures = empty;
    textures.Add(1, 1, HDS_TEXEL_FLOAT | 2U, HDS_SWIZZLE_RGBA, 1);
    const glm::vec2 coordinates[] = {{-0.5F, 0.5F}, {0.5F, -1e-7F},   {10.5F, 0.5F},
                                     {NAN, 0.5F},   {INFINITY, 0.0F}, {0.5F, 1e30F}};
    for (const glm::vec2& st : coordinates) {
        Words words;
        words.Constant({st.x, st.y, 0, 0}).Constant({0, 0, 0, 0});
        words.Op(HDS_OP_TEXTURE, HDS_LOOKUP_UDIM).Raw(1).Raw(0);
        words.Floats({7, 8, 9, 10, 1, 1, 1, 1, 0, 0, 0, 0}).Store(HDS_INPUT_DIFFUSE_COLOR);
        EXPECT_EQ(Run(words)[0][HDS_INPUT_DIFFUSE_COLOR], glm::vec4(7, 8, 9, 10)) << st.x;
    }
    textures.MakeUnreadable(0);
    Words words;
    words.Constant({0.5, 0.5, 0, 0}).Constant({0, 0, 0, 0});
    words.Op(HDS_OP_TEXTURE, kRepeat).Raw(1).Raw(0);
    words.Floats({7, 8, 9, 10, 1, 1, 1, 1, 0, 0, 0, 0}).Store(HDS_INPUT_DIFFUSE_COLOR);
    EXPECT_EQ(Run(words)[0][HDS_INPUT_DIFFUSE_COLOR], glm::vec4(7, 8, 9, 10));
}

TEST_F(ProgramKernelTest, TangentsRunAlongTheCoordinates) {
    std::mt19937 generator(5);
    std::normal_distribution<double> normal;
    std::vector<float> in;
    std::vector<std::array<glm::dvec3, 2>> expected;
    for (int i = 0; i < 500; ++i) {
        const glm::dvec3 alongS(normal(generator), normal(generator), normal(generator));
        const glm::dvec3 alongT(normal(generator), normal(generator), normal(generator));
        const double scale = std::exp2(40.0 * (i % 3 - 1));
        glm::dvec4 d(normal(generator), normal(generator), normal(generator), normal(generator));
        if (i == 0) {
            d = glm::dvec4(1, 2, 2, 4); // a line
        }
        // Edges whose ends have these coordinates.
        const glm::dvec3 e1 = d.x * alongS + d.y * alongT;
        const glm::dvec3 e2 = d.z * alongS + d.w * alongT;
        for (const double value : {d.x * scale, d.y * scale, d.z * scale, d.w * scale, e1.x, e1.y,
                                   e1.z, e2.x, e2.y, e2.z}) {
            in.push_back(float(value));
        }
        expected.push_back({glm::normalize(alongS), glm::normalize(alongT)});
    }
    auto program = Build(kSource, kDefines);
    const Buffer input = Upload(in);
    const Buffer out = Allocate(expected.size() * 6 * sizeof(float));
    program->GetKernel("tangents")
        .Launch(expected.size(), input, out, std::uint32_t(expected.size()));
    const std::vector<glm::vec3> found = Download<glm::vec3>(out, expected.size() * 2);
    EXPECT_EQ(found[0], glm::vec3(0.0F));
    EXPECT_EQ(found[1], glm::vec3(0.0F));
    for (std::size_t i = 1; i < expected.size(); ++i) {
        EXPECT_GT(glm::dot(glm::normalize(glm::dvec3(found[2 * i])), expected[i][0]), 1 - 1e-4);
        EXPECT_GT(glm::dot(glm::normalize(glm::dvec3(found[2 * i + 1])), expected[i][1]), 1 - 1e-4);
    }
}

} // namespace
} // namespace hds::test
