// SPDX-License-Identifier: Apache-2.0
// kernels/texture/lookup.clh against a reference in double precision: formats, wrap modes, levels,
// odd sizes, coordinates of any size and not finite.
#include "testenv/support/deviceFixture.h"
#include "testenv/support/plainTextures.h"

#include "kernels/shared/program.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace hds::test {
namespace {

const char* const kSource = R"(
#define HDS_TEXTURE_PLAIN 1
#include "texture/lookup.clh"
kernel void look(HDS_TEXTURE_ARGS, uint texture, uint wraps, global const float* in, float bias,
                 global float4* out, uint count) {
    uint i = (uint)get_global_id(0);
    if (i >= count) return;
    HdsTextureView view;
    HDS_TEXTURE_VIEW(view);
    bool isMissing = false;
    out[i] = texture_lookup(&view, texture, wraps, vload2(3 * i, in),
                            (float4)(vload2(3 * i + 1, in), vload2(3 * i + 2, in)), bias,
                            &isMissing);
    if (isMissing) out[i] = (float4)(NAN);
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
        if (!_program) {
            _program = Build(kSource, {{"HDS_NUM_TEXTURE_POOLS", "1"}});
        }
        std::vector<float> in;
        for (const Query& query : queries) {
            in.insert(in.end(), {query.st.x, query.st.y, query.axes.x, query.axes.y, query.axes.z,
                                 query.axes.w});
        }
        const Buffer records = Upload(textures.Records());
        const Buffer texels = Upload(textures.Texels());
        const Buffer input = Upload(in);
        const Buffer out = Allocate(queries.size() * sizeof(glm::vec4));
        _program->GetKernel("look").Launch(queries.size(), HDS_TEST_TEXTURE_ARGS(records, texels),
                                           texture, std::uint32_t(HDS_LOOKUP_WRAPS(wrapS, wrapT)),
                                           input, bias, out, std::uint32_t(queries.size()));
        return Download<glm::vec4>(out, queries.size());
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

    PlainTextures textures;

private:
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

} // namespace
} // namespace hds::test
