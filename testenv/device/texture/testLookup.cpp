// SPDX-License-Identifier: Apache-2.0
// kernels/texture/lookup.clh against a reference in double precision: formats, wrap modes, levels,
// odd sizes, coordinates of any size and not finite.
#include "testenv/support/deviceFixture.h"
#include "testenv/support/testTextures.h"

#include "kernels/shared/program.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace hds::test {
namespace {

const char* const kSource = R"(
#include "texture/lookup.clh"
kernel void look(HDS_TEXTURE_ARGS, uint texture, uint wraps, global const float* in, float bias,
                 global float4* out, uint count) {
    uint i = (uint)get_global_id(0);
    if (i >= count) return;
    HdsTextureView view;
    HDS_TEXTURE_VIEW(view);
    bool isMissing = false;
    const float level = lookup_level(
        &view.textures[texture], (float4)(vload2(3 * i + 1, in), vload2(3 * i + 2, in)), bias);
    out[i] = texture_lookupMip(&view, texture, wraps, vload2(3 * i, in), level, &isMissing);
    if (isMissing) out[i] = (float4)(NAN);
}
/* What texture_lookup's choices come to on average: of four texels, of one. */
kernel void lookByChoice(HDS_TEXTURE_ARGS, uint texture, uint wraps, global const float* in,
                         uint numChoices, global float4* out, uint count) {
    uint i = (uint)get_global_id(0);
    if (i >= count) return;
    HdsTextureView view;
    HDS_TEXTURE_VIEW(view);
    bool isMissing = false;
    const float level = lookup_level(
        &view.textures[texture], (float4)(vload2(3 * i + 1, in), vload2(3 * i + 2, in)), 0.0f);
    for (uint kind = 0u; kind < 2u; ++kind) {
        float4 sum = (float4)(0.0f);
        for (uint k = 0u; k < numChoices; ++k) {
            HdsTexelChoice choice = {((float)k + 0.5f) / (float)numChoices, kind == 0u ? 4u : 1u};
            sum += texture_lookup(&view, texture, wraps, vload2(3 * i, in), level, choice,
                                  &isMissing);
        }
        out[2 * i + kind] = sum / (float)numChoices;
    }
}
kernel void log2Of(global const float* in, global float* out, uint count) {
    uint i = (uint)get_global_id(0);
    if (i < count) out[i] = lookup_log2(in[i]);
}
)";

/// Coordinates and the footprint's two axes.
struct Query {
    glm::vec2 st;
    glm::vec4 axes{0.0F};
};

class LookupTest : public DeviceFixture {
protected:
    std::vector<glm::vec4> Look(std::uint32_t texture, std::uint32_t wrapS, std::uint32_t wrapT,
                                const std::vector<Query>& queries, float bias = 0.0F) {
        return Launch("look", texture, wrapS, wrapT, queries, bias, 1);
    }

    /// Two values a query: the means over `numChoices` choices, of four texels and of one.
    std::vector<glm::vec4> LookByChoice(std::uint32_t texture, std::uint32_t wrapS,
                                        std::uint32_t wrapT, const std::vector<Query>& queries,
                                        std::uint32_t numChoices) {
        return Launch("lookByChoice", texture, wrapS, wrapT, queries, numChoices, 2);
    }

    Program& GetProgram() {
        if (!_program) {
            _program = Build(kSource, {{"HDS_NUM_TEXTURE_POOLS", "1"}});
        }
        return *_program;
    }

    void ExpectReference(std::uint32_t texture, std::uint32_t wrapS, std::uint32_t wrapT,
                         const std::vector<Query>& queries, double tolerance, float bias = 0.0F) {
        const std::vector<glm::vec4> found = Look(texture, wrapS, wrapT, queries, bias);
        for (std::size_t i = 0; i < queries.size(); ++i) {
            const glm::dvec4 expected = LookUp(textures, texture, wrapS, wrapT, queries[i].st,
                                               queries[i].axes, double(bias));
            for (int c = 0; c < 4; ++c) {
                ASSERT_NEAR(found[i][c], expected[c], tolerance)
                    << "texture " << texture << " wrap " << wrapS << "," << wrapT << " st "
                    << queries[i].st.x << "," << queries[i].st.y << " channel " << c;
            }
        }
    }

    /// Coordinates in and around the image, with footprints from points to half the image.
    std::vector<Query> RandomQueries(std::size_t count, float range) {
        std::uniform_real_distribution<float> position(-range, range);
        std::uniform_real_distribution<float> exponent(-14.0F, 1.0F);
        std::uniform_real_distribution<float> unit(-1.0F, 1.0F);
        std::vector<Query> queries;
        for (std::size_t i = 0; i < count; ++i) {
            const float size = std::exp2(exponent(_generator));
            queries.push_back({{position(_generator), position(_generator)},
                               size * glm::vec4(unit(_generator), unit(_generator),
                                                unit(_generator), unit(_generator))});
        }
        return queries;
    }

    TestTextures textures;

private:
    template <typename Parameter>
    std::vector<glm::vec4> Launch(const char* kernel, std::uint32_t texture, std::uint32_t wrapS,
                                  std::uint32_t wrapT, const std::vector<Query>& queries,
                                  Parameter parameter, std::size_t numValues) {
        std::vector<float> in;
        for (const Query& query : queries) {
            in.insert(in.end(), {query.st.x, query.st.y, query.axes.x, query.axes.y, query.axes.z,
                                 query.axes.w});
        }
        const Buffer records = Upload(textures.Records());
        const Buffer lines = Upload(textures.Lines());
        const Buffer input = Upload(in);
        const Buffer out = Allocate(numValues * queries.size() * sizeof(glm::vec4));
        GetProgram().GetKernel(kernel).Launch(queries.size(), HDS_TEST_TEXTURE_ARGS(records, lines),
                                              texture,
                                              std::uint32_t(HDS_LOOKUP_WRAPS(wrapS, wrapT)), input,
                                              parameter, out, std::uint32_t(queries.size()));
        return Download<glm::vec4>(out, numValues * queries.size());
    }

    std::unique_ptr<Program> _program;
    std::mt19937 _generator{7};
};

TEST_F(LookupTest, EveryFormatIsDecoded) {
    const std::vector<Query> queries = RandomQueries(300, 1.0F);
    const std::uint32_t swizzles[] = {HDS_SWIZZLE_GRAY, HDS_SWIZZLE_GRAY_ALPHA, HDS_SWIZZLE_RGBA};
    for (const std::uint32_t type : {HDS_TEXEL_U8, HDS_TEXEL_U8 | HDS_TEXEL_SRGB,
                                     HDS_TEXEL_U8 | HDS_TEXEL_SRGB | HDS_TEXEL_SECOND_IS_ALPHA,
                                     HDS_TEXEL_U16, HDS_TEXEL_HALF, HDS_TEXEL_FLOAT}) {
        for (std::uint32_t channelsLog2 = 0; channelsLog2 < 3; ++channelsLog2) {
            if (channelsLog2 == 2 && (type & HDS_TEXEL_SECOND_IS_ALPHA) != 0) {
                continue; /* of textures of two channels */
            }
            for (const std::uint32_t swizzle : {swizzles[channelsLog2], HDS_SWIZZLE_RGBA}) {
                const std::uint32_t texture =
                    textures.Add(5, 3, type | channelsLog2, swizzle, type + channelsLog2);
                ExpectReference(texture, HDS_WRAP_REPEAT, HDS_WRAP_CLAMP, queries, 2e-5);
            }
        }
    }
}

TEST_F(LookupTest, WrapModesAreIndependent) {
    const std::uint32_t texture = textures.Add(7, 4, HDS_TEXEL_FLOAT | 2U, HDS_SWIZZLE_RGBA, 1);
    const std::vector<Query> queries = RandomQueries(500, 3.5F);
    for (std::uint32_t wrapS = HDS_WRAP_BLACK; wrapS <= HDS_WRAP_MIRROR; ++wrapS) {
        for (std::uint32_t wrapT = HDS_WRAP_BLACK; wrapT <= HDS_WRAP_MIRROR; ++wrapT) {
            ExpectReference(texture, wrapS, wrapT, queries, 5e-5);
        }
    }
}

TEST_F(LookupTest, SizesOfAnyKindHaveAllMips) {
    const std::vector<Query> queries = RandomQueries(300, 1.5F);
    const glm::uvec2 sizes[] = {{1, 1}, {1, 9}, {17, 1}, {2, 2}, {31, 33}, {64, 16}, {127, 5}};
    for (const glm::uvec2& size : sizes) {
        const std::uint32_t texture =
            textures.Add(size.x, size.y, HDS_TEXEL_U8 | 2U, HDS_SWIZZLE_RGBA, size.x);
        ExpectReference(texture, HDS_WRAP_REPEAT, HDS_WRAP_MIRROR, queries, 1e-4);
    }
}

TEST_F(LookupTest, CoordinatesFarAwayWrapAsNearOnes) {
    const std::uint32_t texture = textures.Add(8, 8, HDS_TEXEL_FLOAT | 2U, HDS_SWIZZLE_RGBA, 3);
    std::vector<Query> queries;
    for (const float far : {1e6F, -1e6F, 1e4F, -1e4F, 3e9F, -1e30F, 3.4e38F}) {
        for (int i = 0; i < 16; ++i) {
            queries.push_back({{far + 0.0625F * float(i), 0.3F - far}});
        }
    }
    for (std::uint32_t wrap = HDS_WRAP_CLAMP; wrap <= HDS_WRAP_MIRROR; ++wrap) {
        const std::vector<glm::vec4> found = Look(texture, wrap, wrap, queries);
        for (std::size_t i = 0; i < queries.size(); ++i) {
            // 1 - t is rounded to the spacing of floats at t; what is exact is compared.
            ASSERT_TRUE(std::isfinite(found[i].x)) << queries[i].st.x;
            if (std::abs(queries[i].st.x) <= 1e6F) {
                const glm::dvec2 st(queries[i].st.x, 1.0 - double(1.0F - queries[i].st.y));
                const glm::dvec4 expected =
                    LookUp(textures, texture, wrap, wrap, st, glm::dvec4(0.0), 0.0);
                ASSERT_NEAR(found[i].x, expected.x, 1e-4) << queries[i].st.x << " wrap " << wrap;
            }
        }
    }
    for (const glm::vec4& value : Look(texture, HDS_WRAP_BLACK, HDS_WRAP_REPEAT, queries)) {
        EXPECT_EQ(value, glm::vec4(0.0F));
    }
}

TEST_F(LookupTest, CoordinatesAndFootprintsThatAreNotFinite) {
    const std::uint32_t texture = textures.Add(8, 8, HDS_TEXEL_FLOAT | 2U, HDS_SWIZZLE_RGBA, 4);
    const glm::vec4 small(1e-4F, 0.0F, 0.0F, 1e-4F);
    const std::vector<Query> queries = {{{NAN, 0.5F}, small},
                                        {{0.5F, NAN}, small},
                                        {{INFINITY, -INFINITY}, small},
                                        {{0.5F, 0.5F}, glm::vec4(NAN)},
                                        {{0.5F, 0.5F}, glm::vec4(INFINITY)},
                                        {{0.5F, 0.5F}, glm::vec4(1e30F)},
                                        {{0.5F, 0.5F}, glm::vec4(1e-30F, 0.0F, 0.0F, 1e-30F)}};
    for (std::uint32_t wrap = HDS_WRAP_BLACK; wrap <= HDS_WRAP_MIRROR; ++wrap) {
        for (const glm::vec4& value : Look(texture, wrap, wrap, queries)) {
            EXPECT_TRUE(std::isfinite(value.x + value.y + value.z + value.w));
        }
    }
    EXPECT_EQ(Look(texture, HDS_WRAP_REPEAT, HDS_WRAP_REPEAT, {{{NAN, 1.0F}, small}})[0],
              Look(texture, HDS_WRAP_REPEAT, HDS_WRAP_REPEAT, {{{0.0F, 1.0F}, small}})[0]);
}

TEST_F(LookupTest, TheLevelFollowsTheMinorAxisUpToTheAnisotropy) {
    const std::uint32_t texture = textures.Add(256, 256, HDS_TEXEL_FLOAT | 2U, HDS_SWIZZLE_RGBA, 5);
    const double texel = 1.0 / 256.0;
    const auto at = [&](double major, double minor, double angle) {
        const glm::dvec2 axis(std::cos(angle), std::sin(angle));
        return Query{{0.4F, 0.6F},
                     glm::vec4(texel * major * axis.x, texel * major * axis.y,
                               -texel * minor * axis.y, texel * minor * axis.x)};
    };
    // One footprint of 4 x 4 texels is mip 2; rotated and 6 times longer it still is.
    const glm::vec4 round = Look(texture, 2, 2, {at(4.0, 4.0, 0.0)})[0];
    const glm::vec4 longer = Look(texture, 2, 2, {at(24.0, 4.0, 0.7)})[0];
    const glm::vec4 longest = Look(texture, 2, 2, {at(64.0, 4.0, 0.7)})[0];
    const glm::vec4 coarse = Look(texture, 2, 2, {at(8.0, 8.0, 0.0)})[0];
    for (int c = 0; c < 4; ++c) {
        EXPECT_NEAR(round[c], longer[c], 2e-5);
        EXPECT_NEAR(longest[c], coarse[c], 2e-5) << "64 / 8 texels";
    }
    EXPECT_NE(round, coarse);
    ExpectReference(texture, 2, 2, RandomQueries(2000, 1.0F), 2e-4);
    ExpectReference(texture, 2, 2, RandomQueries(200, 1.0F), 2e-4, 1.5F);
    ExpectReference(texture, 2, 2, RandomQueries(200, 1.0F), 2e-4, -2.0F);
}

TEST_F(LookupTest, LongImagesKeepTheirShortSide) {
    const std::uint32_t texture = textures.Add(3, 997, HDS_TEXEL_FLOAT | 2U, HDS_SWIZZLE_RGBA, 5);
    // A hundredth of the square that the image covers: 10 rows, 0.03 columns.
    const Query square{{0.4F, 0.6F}, {0.01F, 0.0F, 0.0F, 0.01F}};
    const Query point{{0.4F, 0.6F}, {}};
    EXPECT_EQ(Look(texture, 2, 2, {square}), Look(texture, 2, 2, {point}));
    // A row of a thousand is known to 2^-14 of its height.
    ExpectReference(texture, 2, 2, RandomQueries(2000, 1.0F), 1e-3);
    const std::uint32_t wide = textures.Add(640, 20, HDS_TEXEL_FLOAT | 2U, HDS_SWIZZLE_RGBA, 7);
    ExpectReference(wide, 2, 2, RandomQueries(2000, 1.0F), 1e-3);
}

TEST_F(LookupTest, ChoicesAverageToTheTrilinearValue) {
    const std::uint32_t texture = textures.Add(32, 64, HDS_TEXEL_U8 | 2U, HDS_SWIZZLE_RGBA, 6);
    const std::vector<Query> queries = RandomQueries(200, 1.5F);
    constexpr std::uint32_t kChoices = 4096;
    // Values are in [0, 1]; [0, 1) is cut into at most 2 and 8 parts, and each cut may be off by
    // one choice.
    const double tolerance[2] = {2.0 / kChoices, 8.0 / kChoices};
    for (std::uint32_t wrap = HDS_WRAP_BLACK; wrap <= HDS_WRAP_MIRROR; ++wrap) {
        const std::vector<glm::vec4> found = LookByChoice(texture, wrap, wrap, queries, kChoices);
        for (std::size_t i = 0; i < found.size(); ++i) {
            const Query& query = queries[i / 2];
            const glm::dvec4 expected =
                LookUp(textures, texture, wrap, wrap, query.st, query.axes, 0.0);
            for (int c = 0; c < 4; ++c) {
                ASSERT_NEAR(found[i][c], expected[c], tolerance[i % 2])
                    << "query " << i / 2 << (i % 2 == 0 ? " four texels" : " one texel");
            }
        }
    }
}

TEST_F(LookupTest, LogarithmsAreExact) {
    std::vector<float> in;
    for (int e = -126; e < 128; ++e) {
        for (const float m : {1.0F, 1.0000001F, 1.3F, 1.4142135F, 1.4142137F, 1.7F, 1.9999999F}) {
            in.push_back(std::ldexp(m, e));
        }
    }
    const Buffer input = Upload(in);
    const Buffer out = Allocate(in.size() * sizeof(float));
    GetProgram().GetKernel("log2Of").Launch(in.size(), input, out, std::uint32_t(in.size()));
    const std::vector<float> found = Download<float>(out, in.size());
    for (std::size_t i = 0; i < in.size(); ++i) {
        const double expected = std::log2(double(in[i]));
        EXPECT_NEAR(found[i], expected, 1.5e-7 + 6e-8 * std::abs(expected)) << in[i];
    }
}

} // namespace
} // namespace hds::test
