/* SPDX-License-Identifier: Apache-2.0
 * A prepared texture: one image in one colour space, its mips as lines of 512 bytes, the unit of
 * residency. A line holds blocks of 4x4 texels, row-major inside a rectangle of texels; lines are
 * row-major inside a mip, mip 0 (the finest) first. The coarsest mips share the last line.
 * Explained in docs/texturing.md. */
#ifndef HDS_SHARED_TEXTURE_H
#define HDS_SHARED_TEXTURE_H
#include "shared/compat.h"

#define HDS_LINE_BYTES 512u
#define HDS_LINE_BYTES_LOG2 9u

/* HdsTexture.format:
 * bits 1..0  log2 of the stored channels (1, 2 or 4)
 * bits 3..2  type of a channel
 * bit  4     the values of the colour channels are sRGB-encoded (8 bits only)
 * bit  5     the second of two channels is alpha: never encoded
 * A block takes half of what its 16 texels would: */
#define HDS_TEXEL_U8 0u   /*   8  16  32 bytes for 1, 2, 4 channels: line of 32x32, 32x16, 16x16 */
#define HDS_TEXEL_U16 4u  /*  16  32  64: 32x16, 16x16, 16x8 texels */
#define HDS_TEXEL_HALF 8u /* as U16 */
#define HDS_TEXEL_FLOAT 12u /* 32  64 128: 16x16, 16x8, 8x8 texels */
#define HDS_TEXEL_TYPE_MASK 12u
#define HDS_TEXEL_CHANNELS_LOG2_MASK 3u
#define HDS_TEXEL_SRGB 16u
#define HDS_TEXEL_SECOND_IS_ALPHA 32u

/* HdsTexture.flags */
#define HDS_TEXTURE_CONSTANT 1u /* every texel of every mip is the first one of the only line */
#define HDS_TEXTURE_MISSING 2u  /* could not be read: the node's fallback holds, not the texels */

/* HdsTexture.swizzle: per output channel R G B A two bits (R lowest), the component of the decoded
 * texel that it is. Components that are not stored decode to (0, 0, 0, 1). */
#define HDS_SWIZZLE(r, g, b, a) ((r) | ((g) << 2) | ((b) << 4) | ((a) << 6))
#define HDS_SWIZZLE_RGBA HDS_SWIZZLE(0u, 1u, 2u, 3u)
#define HDS_SWIZZLE_GRAY HDS_SWIZZLE(0u, 0u, 0u, 3u)
#define HDS_SWIZZLE_GRAY_ALPHA HDS_SWIZZLE(0u, 0u, 0u, 1u)

#define HDS_TEXTURE_MAX_SIZE 131072u /* texels a side */
#define HDS_TEXTURE_MAX_MIPS 18

HDS_SHARED_BEGIN
typedef struct {
    u32 width; /* of mip 0, texels; mip m has max(1, width >> m) */
    u32 height;
    u32 numMips;   /* down to 1x1 */
    u32 format;    /* HDS_TEXEL_* */
    u32 flags;     /* HDS_TEXTURE_* */
    u32 firstLine; /* number of its line 0 among the lines of all textures */
    u32 numLines;
    u32 swizzle; /* HDS_SWIZZLE */
    /* Where a mip's blocks begin, in blocks from the texture's line 0. A multiple of the blocks of
     * a line, but for the mips in the last line. */
    u32 mipBlock[HDS_TEXTURE_MAX_MIPS];
    u32 reserved[2];
} HdsTexture;
HDS_ASSERT_SIZE(HdsTexture, 112);

/* Where a texel is: its line, counted from the texture's line 0, and its place in the rectangle of
 * the line, for codec_texel. */
typedef struct {
    u32 line;
    u32 x;
    u32 y;
} HdsTexelPlace;

HDS_FUNCTION u32 texel_blockBytesLog2(u32 format) {
    u32 type = format & HDS_TEXEL_TYPE_MASK;
    u32 wide = type == HDS_TEXEL_U8 ? 0u : (type == HDS_TEXEL_FLOAT ? 2u : 1u);
    return 3u + wide + (format & HDS_TEXEL_CHANNELS_LOG2_MASK);
}

/* Log2 of a line's width and height in blocks. */
HDS_FUNCTION u32 texel_lineWidthLog2(u32 format) {
    return (HDS_LINE_BYTES_LOG2 + 1u - texel_blockBytesLog2(format)) >> 1;
}
HDS_FUNCTION u32 texel_lineHeightLog2(u32 format) {
    return (HDS_LINE_BYTES_LOG2 - texel_blockBytesLog2(format)) >> 1;
}

HDS_FUNCTION u32 texture_mipSize(u32 size, u32 mip) {
    u32 texels = size >> mip;
    return texels > 0u ? texels : 1u;
}

/* The place of a texel of a mip; (x, y) is inside the mip, y = 0 is the image's top row. */
HDS_FUNCTION HdsTexelPlace texture_place(u32 width, u32 format, u32 flags, u32 numLines,
                                         u32 mipBlock, u32 mip, u32 x, u32 y) {
    HdsTexelPlace place;
    u32 acrossLog2 = texel_lineWidthLog2(format);
    u32 downLog2 = texel_lineHeightLog2(format);
    u32 blocksAcross = (texture_mipSize(width, mip) + 3u) >> 2;
    u32 blockX = x >> 2;
    u32 blockY = y >> 2;
    place.line = mipBlock >> (acrossLog2 + downLog2);
    if ((flags & HDS_TEXTURE_CONSTANT) != 0u) {
        place.line = place.x = place.y = 0u;
        return place;
    }
    if (place.line + 1u == numLines) {
        u32 block =
            (mipBlock & ((1u << (acrossLog2 + downLog2)) - 1u)) + blockY * blocksAcross + blockX;
        blockX = block & ((1u << acrossLog2) - 1u);
        blockY = block >> acrossLog2;
    } else {
        u32 linesAcross = (blocksAcross + (1u << acrossLog2) - 1u) >> acrossLog2;
        place.line += (blockY >> downLog2) * linesAcross + (blockX >> acrossLog2);
        blockX &= (1u << acrossLog2) - 1u;
        blockY &= (1u << downLog2) - 1u;
    }
    place.x = (blockX << 2) | (x & 3u);
    place.y = (blockY << 2) | (y & 3u);
    return place;
}

HDS_FUNCTION float swizzle_component(float4 texel, u32 component) {
    return component == 0u ? texel.x
                           : (component == 1u ? texel.y : (component == 2u ? texel.z : texel.w));
}

/* RGBA of a decoded texel. */
HDS_FUNCTION float4 swizzle_apply(float4 texel, u32 swizzle) {
    return HDS_FLOAT4(swizzle_component(texel, swizzle & 3u),
                      swizzle_component(texel, (swizzle >> 2) & 3u),
                      swizzle_component(texel, (swizzle >> 4) & 3u),
                      swizzle_component(texel, (swizzle >> 6) & 3u));
}
HDS_SHARED_END
#endif
