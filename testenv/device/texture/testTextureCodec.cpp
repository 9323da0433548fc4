// SPDX-License-Identifier: Apache-2.0
// The device decodes every texel of every format to the bits that the host decodes, and finds
// texels at the places that the host finds.
#include "hdStream/texture/blockEncoder.h"
#include "kernels/shared/textureCodec.h"
#include "testenv/support/deviceFixture.h"
#include "testenv/support/textureFormats.h"

#include <cstring>

namespace hds::test {
namespace {

const char* const kDecode = R"(
#include "texture/codec.clh"
kernel void decode(global const uint* lines, uint format, uint width, uint height,
                   global float* texels, uint count) {
    uint i = (uint)get_global_id(0);
    if (i >= count) return;
    uint texel = i % (width * height);
    float4 value = codec_texel(lines + (i / (width * height)) * (HDS_LINE_BYTES / 4), format,
                               texel % width, texel / width);
    vstore4(value, i, texels);
}
)";

/* Four texels of four lines that have little to do with each other. */
const char* const kDecodeQuad = R"(
#include "texture/codecQuad.clh"
kernel void decode(global const uint* lines, uint format, uint width, uint height,
                   global float* texels, uint count) {
    uint i = (uint)get_global_id(0);
    if (i >= count) return;
    uint at[4] = {i, (i * 7u + 1u) % count, (i + 1u) % count, (i * 31u + 5u) % count};
    uint x[4], y[4];
    global const uint* from[4];
    for (uint k = 0; k < 4u; ++k) {
        from[k] = lines + (at[k] / (width * height)) * (HDS_LINE_BYTES / 4);
        x[k] = at[k] % (width * height) % width;
        y[k] = at[k] % (width * height) / width;
    }
    float4 values[4];
    codec_quad(from, format, vload4(0, x), vload4(0, y), values);
    bool isEqual = true;
    for (uint k = 0; k < 4u; ++k) {
        isEqual = isEqual && all(as_int4(codec_texel(from[k], format, x[k], y[k])) ==
                                 as_int4(values[k]));
    }
    vstore4(isEqual ? values[0] : (float4)(NAN), i, texels);
}
)";

/* Two columns and two rows of one line, in one block or in up to four. */
const char* const kDecodeLine = R"(
#include "texture/codecQuad.clh"
kernel void decode(global const uint* lines, uint format, uint width, uint height,
                   global float* texels, uint count) {
    uint i = (uint)get_global_id(0);
    if (i >= count) return;
    global const uint* line = lines + (i / (width * height)) * (HDS_LINE_BYTES / 4);
    const uint x0 = i % (width * height) % width;
    const uint y0 = i % (width * height) / width;
    const uint x1 = (x0 + (i % 3u == 0u ? 1u : i % 5u)) % width;
    const uint y1 = (y0 + (i % 7u == 0u ? 4u : 1u)) % height;
    const uint4 x = (uint4)(x0, x1, x0, x1);
    const uint4 y = (uint4)(y0, y0, y1, y1);
    float4 values[4];
    codec_lineQuad(line, format, x, y, values);
    const bool isEqual =
        all(as_int4(codec_texel(line, format, x.s0, y.s0)) == as_int4(values[0])) &&
        all(as_int4(codec_texel(line, format, x.s1, y.s1)) == as_int4(values[1])) &&
        all(as_int4(codec_texel(line, format, x.s2, y.s2)) == as_int4(values[2])) &&
        all(as_int4(codec_texel(line, format, x.s3, y.s3)) == as_int4(values[3]));
    vstore4(isEqual ? values[0] : (float4)(NAN), i, texels);
}
)";

const char* const kPlace = R"(
#include "texture/codec.clh"
kernel void place(global const HdsTexture* textures, uint mip, uint width, uint height,
                  global uint* places) {
    uint i = (uint)get_global_id(0);
    if (i >= width * height) return;
    HdsTexelPlace p = texture_place(textures[0].width, textures[0].format, textures[0].flags,
                                    textures[0].numLines, textures[0].mipBlock[mip], mip,
                                    i % width, i / width);
    places[3 * i] = p.line;
    places[3 * i + 1] = p.x;
    places[3 * i + 2] = p.y;
}
)";

class TextureCodec : public DeviceFixture {
protected:
    /// The program's kernel "decode" against the host, all formats.
    void ExpectHostsBits(const Program& program);
};

/// Lines of random blocks.
std::vector<std::uint32_t> RandomLines(std::uint32_t format, std::size_t numLines) {
    std::mt19937 generator(format + 1);
    const std::size_t blockWords = std::size_t{1} << (shared::texel_blockBytesLog2(format) - 2);
    std::vector<std::uint32_t> words(numLines * HDS_LINE_BYTES / 4);
    for (std::size_t at = 0; at < words.size(); at += blockWords) {
        EncodeBlock(format, RandomBlock(format, generator).data(), &words[at]);
    }
    return words;
}

TEST_F(TextureCodec, DecodesToTheHostsBits) {
    ExpectHostsBits(*Build(kDecode));
}

TEST_F(TextureCodec, DecodesFourTexelsToTheBitsOfEach) {
    ExpectHostsBits(*Build(kDecodeQuad));
}

TEST_F(TextureCodec, DecodesFourTexelsOfALineToTheBitsOfEach) {
    ExpectHostsBits(*Build(kDecodeLine));
}

void TextureCodec::ExpectHostsBits(const Program& program) {
    constexpr std::size_t kNumLines = 64;
    for (const std::uint32_t format : AllTexelFormats()) {
        const std::uint32_t width = 4u << shared::texel_lineWidthLog2(format);
        const std::uint32_t height = 4u << shared::texel_lineHeightLog2(format);
        const std::vector<std::uint32_t> lines = RandomLines(format, kNumLines);
        const std::size_t numTexels = kNumLines * width * height;
        const Buffer input = Upload(lines);
        const Buffer output = Allocate(numTexels * sizeof(shared::float4));
        program.GetKernel("decode").Launch(numTexels, input, format, width, height, output,
                                           std::uint32_t(numTexels));
        const auto texels = Download<shared::float4>(output, numTexels);
        for (std::size_t i = 0; i < numTexels; ++i) {
            const std::uint32_t texel = static_cast<std::uint32_t>(i % (width * height));
            const shared::float4 expected =
                shared::codec_texel(&lines[i / (width * height) * HDS_LINE_BYTES / 4], format,
                                    texel % width, texel / width);
            ASSERT_EQ(std::memcmp(&texels[i], &expected, sizeof(expected)), 0)
                << "format " << format << " texel " << i << ": " << texels[i].x << " for "
                << expected.x;
        }
    }
}

TEST_F(TextureCodec, FindsTheHostsPlaces) {
    const auto program = Build(kPlace);
    for (const std::uint32_t format : {HDS_TEXEL_U8, HDS_TEXEL_HALF | 2u, HDS_TEXEL_FLOAT | 2u}) {
        const shared::HdsTexture texture = MakeTextureLayout(75, 131, format);
        const Buffer record = Upload(std::vector<shared::HdsTexture>{texture});
        for (std::uint32_t mip = 0; mip < texture.numMips; ++mip) {
            const std::uint32_t width = shared::texture_mipSize(75, mip);
            const std::uint32_t height = shared::texture_mipSize(131, mip);
            const Buffer output = Allocate(std::uint64_t{3} * width * height * 4);
            program->GetKernel("place").Launch(std::size_t{width} * height, record, mip, width,
                                               height, output);
            const auto places = Download<std::uint32_t>(output, std::size_t{3} * width * height);
            for (std::uint32_t i = 0; i < width * height; ++i) {
                const shared::HdsTexelPlace expected = PlaceOf(texture, mip, i % width, i / width);
                ASSERT_EQ(places[3 * i], expected.line);
                ASSERT_EQ(places[3 * i + 1], expected.x);
                ASSERT_EQ(places[3 * i + 2], expected.y);
            }
        }
    }
}

} // namespace
} // namespace hds::test
