// SPDX-License-Identifier: Apache-2.0
// Every texel of every mip has a place of its own inside the texture's lines, and no line is
// without texels. Oracle: counting all of them.
#include "hdStream/texture/textureLayout.h"

#include "testenv/support/textureFormats.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <set>

namespace hds {
namespace {

TEST(TextureLayout, EveryTexelHasItsOwnPlace) {
    const std::uint32_t sizes[][2] = {{1, 1}, {1, 77},  {130, 1},  {16, 16}, {17, 16}, {64, 64},
                                      {5, 3}, {33, 65}, {100, 37}, {31, 28}, {3, 200}, {256, 4}};
    for (const std::uint32_t format : test::AllTexelFormats()) {
        const std::uint32_t lineWidth = 4u << shared::texel_lineWidthLog2(format);
        const std::uint32_t lineHeight = 4u << shared::texel_lineHeightLog2(format);
        ASSERT_EQ(lineWidth * lineHeight * TexelBytes(format), 2 * HDS_LINE_BYTES);
        for (const auto& [width, height] : sizes) {
            const shared::HdsTexture texture = MakeTextureLayout(width, height, format);
            std::set<std::uint64_t> places;
            std::set<std::uint32_t> lines;
            std::size_t numTexels = 0;
            for (std::uint32_t mip = 0; mip < texture.numMips; ++mip) {
                const std::uint32_t w = std::max(1u, width >> mip);
                const std::uint32_t h = std::max(1u, height >> mip);
                for (std::uint32_t i = 0; i < w * h; ++i, ++numTexels) {
                    const shared::HdsTexelPlace place = PlaceOf(texture, mip, i % w, i / w);
                    ASSERT_LT(place.x, lineWidth);
                    ASSERT_LT(place.y, lineHeight);
                    lines.insert(place.line);
                    places.insert((std::uint64_t{place.line} * lineHeight + place.y) * lineWidth +
                                  place.x);
                }
            }
            EXPECT_EQ(places.size(), numTexels) << width << "x" << height << " " << format;
            EXPECT_EQ(lines.size(), texture.numLines) << width << "x" << height << " " << format;
            EXPECT_EQ(*lines.rbegin() + 1, texture.numLines);
        }
    }
}

TEST(TextureLayout, KnownSizes) {
    constexpr std::uint32_t kRgba8 = HDS_TEXEL_U8 | 2u;
    const shared::HdsTexture square = MakeTextureLayout(2048, 2048, kRgba8);
    EXPECT_EQ(square.numMips, 12u);
    EXPECT_EQ(square.numLines, 21845u + 1u); // 128^2 + 64^2 + ... + 1, and one for 8x8 and coarser
    EXPECT_EQ(PlaceOf(square, 11, 0, 0).line, square.numLines - 1);
    EXPECT_EQ(PlaceOf(square, 8, 7, 7).line, square.numLines - 1);
    EXPECT_EQ(PlaceOf(square, 7, 0, 0).line, square.numLines - 2);
    const shared::HdsTexelPlace place = PlaceOf(square, 0, 33, 18);
    EXPECT_EQ(place.line, 128u + 2u);
    EXPECT_EQ(place.x, 1u);
    EXPECT_EQ(place.y, 2u);
    EXPECT_EQ(MakeTextureLayout(1, 1, kRgba8).numLines, 1u);
    EXPECT_EQ(MakeTextureLayout(131072, 1, kRgba8).numMips, std::uint32_t{HDS_TEXTURE_MAX_MIPS});
    // The largest image that is read at all (2^33 texels) has a layout within 32 bits.
    EXPECT_EQ(MakeTextureLayout(131072, 65536, kRgba8).numLines, 44739242u + 1u);
}

TEST(TextureLayout, AConstantTextureHasOnePlace) {
    shared::HdsTexture texture = MakeTextureLayout(640, 480, HDS_TEXEL_U8);
    MakeConstant(&texture);
    EXPECT_EQ(texture.numLines, 1u);
    for (std::uint32_t mip = 0; mip < texture.numMips; ++mip) {
        const shared::HdsTexelPlace place = PlaceOf(texture, mip, (639u >> mip), (479u >> mip));
        EXPECT_EQ(place.line + place.x + place.y, 0u);
    }
}

} // namespace
} // namespace hds
