/* SPDX-License-Identifier: Apache-2.0
 * Decodes one texel of a line of a prepared texture (shared/texture.h). Host and device run this
 * same text and get the same bits. What the modes are for, and how good they are:
 * docs/texturing.md, section "Codec". The encoder is hdStream/texture/blockEncoder.
 *
 * A channel of a block is an interval and an index per texel that interpolates it. Blocks are read
 * in words of 32 bits, least significant bit first; texel i of a block is (i % 4, i / 4).
 *
 * U8, 1 channel (8 bytes; 2 channels: two of them, one after the other)
 *   word 0  bit 0 mode; mode 0 "interval": bits 8..1 low, 15..9 range code
 *                       mode 1 "ramp": bits 6..1 base, 9..7 and 12..10 slopes in x and y plus 4,
 *                                      15..13 step code
 *   bits 63..16  index of texel i, 3 bits at 16 + 3 i
 * U8, 4 channels (32 bytes)
 *   words 0, 1   bit 0: the three colours are Y, Co, Cg (YCoCg-R: Malvar, Sullivan 2003), Co and Cg
 *                plus 255; else R, G, B. bit 1: alpha varies or is not 255.
 *                bits 5..2 index width of the first colour, 8..6 of the second; with alpha 11..9 of
 *                the third; the last channel has what is left of 12 bits, with alpha of 11.
 *                from bit 9, with alpha 12: low 8, range 8 | low 9, range 9 | low 9, range 9 bits
 *   words 2..5   byte i: bits 7..0 of texel i's index; the first channel's are lowest
 *   words 6, 7   opaque: 4 bits a texel, the index' bits 11..8
 *                alpha: 3 bits a texel (texels 0 to 7 and 8 to 15), the index' bits 10..8; in bits
 *                31..24 alpha's low (word 6) and range (word 7)
 * U16 and HALF, 1 channel (16 bytes; 2 channels: two of them)
 *   word 0       first end of the interval, second end << 16. HALF: first > second as numbers is
 *                the mark for interpolating the ordered bits (about the logarithm), not the values
 *   words 1, 2   bits 3..0 of the index, 4 bits a texel; word 3 bits 5..4 of it, 2 bits a texel
 * U16 and HALF, 4 channels (64 bytes)
 *   words 0..3   the ends of each channel, as above
 *   words 4..15  24 bits of index: three planes of a byte a texel. Alpha's ends are equal: 8 bits
 *                each for R, G, B. Else 6 bits each, R lowest.
 * FLOAT, each channel (32 bytes)
 *   words 0, 1   the ends as above; words 2..7 index of 12 bits: as U8, 4 channels, opaque */
#ifndef HDS_SHARED_TEXTURE_CODEC_H
#define HDS_SHARED_TEXTURE_CODEC_H
#include "shared/srgbTable.h"
#include "shared/texture.h"

#define HDS_CODEC_COLOR_YCOCG 1u
#define HDS_CODEC_ALPHA 2u
#define HDS_CODEC_COLOR_BITS 12u
#define HDS_CODEC_ALPHA_BITS 11u /* of an index when alpha has a part of it */
/* Ranges of U8 intervals above this are coded in steps, the last of which is 255. */
#define HDS_CODEC_EXACT_RANGE 96u
#define HDS_CODEC_MAX_RANGE_CODE 127u

HDS_SHARED_BEGIN
/* round(2^(14 + n) / (2^n - 1)): interpolation by an index of n bits without a division. */
HDS_TABLE u32 codec_scale[13] = {0,     32768, 21845, 18725, 17476, 16913, 16644,
                                 16513, 16448, 16416, 16400, 16392, 16388};
/* Distance of two indices in a ramp, in codes. */
HDS_TABLE u32 codec_rampStep[8] = {1, 2, 3, 4, 6, 9, 13, 20};

/* The part of `range` that index `q` of `bits` bits stands for, rounded. range <= 511, bits <= 9.
 */
HDS_FUNCTION u32 codec_interpolate(u32 range, u32 q, u32 bits) {
    return (range * q * codec_scale[bits] + (1u << (13u + bits))) >> (14u + bits);
}

/* As codec_interpolate, for any range and up to 12 bits. */
HDS_FUNCTION u32 codec_interpolateWide(u32 range, u32 q, u32 bits) {
    u64 product = (u64)range * q * codec_scale[bits];
    return (u32)((product + ((u64)1 << (13u + bits))) >> (14u + bits));
}

HDS_FUNCTION u32 codec_rangeOfCode(u32 code) {
    u32 coarse = code - HDS_CODEC_EXACT_RANGE;
    u32 steps = HDS_CODEC_MAX_RANGE_CODE - HDS_CODEC_EXACT_RANGE;
    return code <= HDS_CODEC_EXACT_RANGE
               ? code
               : HDS_CODEC_EXACT_RANGE + coarse * (255u - HDS_CODEC_EXACT_RANGE) / steps;
}

HDS_FUNCTION u32 codec_byteOf(i32 value) {
    return value < 0 ? 0u : (value > 255 ? 255u : (u32)value);
}

/* A value of a ramp: a plane through the block's middle, (slopeX, slopeY) steps a texel. */
HDS_FUNCTION u32 codec_ramp(u32 base, i32 slopeX, i32 slopeY, u32 step, u32 q, u32 texel) {
    i32 x = 2 * (i32)(texel & 3u) - 3;
    i32 y = 2 * (i32)(texel >> 2) - 3;
    i32 steps = 2 * (i32)q - 7 + slopeX * x + slopeY * y;
    return codec_byteOf((8 * (i32)base + (i32)step * steps + 1) >> 1);
}

/* One channel of 8 bits. */
HDS_FUNCTION u32 codec_scalar8(HDS_GLOBAL const u32* block, u32 texel) {
    u32 head = block[0];
    u64 bits = ((u64)block[1] << 32) | head;
    u32 q = (u32)(bits >> (16u + 3u * texel)) & 7u;
    if ((head & 1u) == 0u) {
        u32 value =
            ((head >> 1) & 255u) + codec_interpolate(codec_rangeOfCode((head >> 9) & 127u), q, 3u);
        return value < 255u ? value : 255u;
    }
    return codec_ramp((head >> 1) & 63u, (i32)((head >> 7) & 7u) - 4, (i32)((head >> 10) & 7u) - 4,
                      codec_rampStep[(head >> 13) & 7u], q, texel);
}

typedef struct {
    u32 r, g, b, a;
} HdsTexel8;

/* Four channels of 8 bits. */
HDS_FUNCTION HdsTexel8 codec_color8(HDS_GLOBAL const u32* block, u32 texel) {
    u64 head = ((u64)block[1] << 32) | block[0];
    u32 hasAlpha = block[0] & HDS_CODEC_ALPHA;
    u32 width0 = (block[0] >> 2) & 15u;
    u32 width1 = (block[0] >> 6) & 7u;
    u32 width2 = HDS_CODEC_COLOR_BITS - width0 - width1;
    u32 q = (block[2u + (texel >> 2)] >> (8u * (texel & 3u))) & 255u;
    u32 high = block[6u + (texel >> 3)];
    u64 ends = head >> 9;
    u32 alpha = 255u;
    if (hasAlpha != 0u) {
        width2 = (block[0] >> 9) & 7u;
        q |= ((high >> (3u * (texel & 7u))) & 7u) << 8;
        ends = head >> 12;
        alpha =
            (block[6] >> 24) + codec_interpolate(block[7] >> 24, q >> (width0 + width1 + width2),
                                                 HDS_CODEC_ALPHA_BITS - width0 - width1 - width2);
    } else {
        q |= ((high >> (4u * (texel & 7u))) & 15u) << 8;
    }
    u32 low = (u32)ends;
    u32 c0 = (low & 255u) + codec_interpolate((low >> 8) & 255u, q & ((1u << width0) - 1u), width0);
    q >>= width0;
    u32 c1 = ((low >> 16) & 511u) +
             codec_interpolate((u32)(ends >> 25) & 511u, q & ((1u << width1) - 1u), width1);
    q >>= width1;
    u32 c2 = ((u32)(ends >> 34) & 511u) +
             codec_interpolate((u32)(ends >> 43) & 511u, q & ((1u << width2) - 1u), width2);
    HdsTexel8 out;
    out.r = c0;
    out.g = c1;
    out.b = c2;
    out.a = alpha;
    if ((block[0] & HDS_CODEC_COLOR_YCOCG) != 0u) {
        i32 co = (i32)c1 - 255;
        i32 cg = (i32)c2 - 255;
        i32 t = (i32)c0 - (cg >> 1);
        i32 blue = t - (co >> 1);
        out.r = codec_byteOf(blue + co);
        out.g = codec_byteOf(cg + t);
        out.b = codec_byteOf(blue);
    }
    return out;
}

/* Halves and floats as integers in the order of the numbers; both zeros are one. */
HDS_FUNCTION u32 codec_orderOfHalf(u32 bits) {
    return (bits & 0x8000u) != 0u ? 0x10000u - bits : 0x8000u + bits;
}
HDS_FUNCTION u32 codec_halfOfOrder(u32 order) {
    return order >= 0x8000u ? order - 0x8000u : 0x10000u - order;
}
HDS_FUNCTION u32 codec_orderOfFloat(u32 bits) {
    return (bits & 0x80000000u) != 0u ? 0u - bits : 0x80000000u + bits;
}
HDS_FUNCTION u32 codec_floatOfOrder(u32 order) {
    return order >= 0x80000000u ? order - 0x80000000u : 0u - order;
}

/* Value of a finite half; exact, also where the device flushes denormal floats. */
HDS_FUNCTION f32 codec_floatOfHalf(u32 bits) {
    u32 magnitude = bits & 0x7fffu;
    f32 value = magnitude < 0x400u ? (f32)magnitude * 5.9604644775390625e-8f
                                   : HDS_AS_FLOAT((magnitude << 13) + 0x38000000u);
    return (bits & 0x8000u) != 0u ? -value : value;
}

/* Between two numbers; exactly one of them at both ends of the index. */
HDS_FUNCTION f32 codec_mix(f32 a, f32 b, u32 q, u32 bits) {
    f32 last = (f32)((1u << bits) - 1u);
    f32 t = bits == 6u ? 0.015873016f : (bits == 8u ? 0.0039215689f : 0.00024420026f);
    f32 weight = (f32)q == last ? 1.0f : (f32)q * t;
    return q == 0u ? a : a * (1.0f - weight) + b * weight;
}

/* A value of a channel of 16 bits from its ends and an index of 6 or 8 bits. */
HDS_FUNCTION f32 codec_value16(u32 ends, u32 q, u32 bits, u32 type) {
    u32 a = ends & 0xffffu;
    u32 b = ends >> 16;
    if (type == HDS_TEXEL_U16) {
        return (f32)(a + codec_interpolateWide(b - a, q, bits)) * 1.5259022e-5f;
    }
    u32 orderA = codec_orderOfHalf(a);
    u32 orderB = codec_orderOfHalf(b);
    if (orderA > orderB) {
        u32 order = orderB + codec_interpolateWide(orderA - orderB, q, bits);
        return codec_floatOfHalf(codec_halfOfOrder(order));
    }
    return codec_mix(codec_floatOfHalf(a), codec_floatOfHalf(b), q, bits);
}

HDS_FUNCTION f32 codec_scalar16(HDS_GLOBAL const u32* block, u32 texel, u32 type) {
    u32 q = (block[1u + (texel >> 3)] >> (4u * (texel & 7u))) & 15u;
    q |= ((block[3] >> (2u * texel)) & 3u) << 4;
    return codec_value16(block[0], q, 6u, type);
}

HDS_FUNCTION float4 codec_color16(HDS_GLOBAL const u32* block, u32 texel, u32 type) {
    u32 word = texel >> 2;
    u32 shift = 8u * (texel & 3u);
    u32 q0 = (block[4u + word] >> shift) & 255u;
    u32 q1 = (block[8u + word] >> shift) & 255u;
    u32 q2 = (block[12u + word] >> shift) & 255u;
    u32 bits = 8u;
    u32 q3 = 0u;
    if ((block[3] & 0xffffu) != (block[3] >> 16)) {
        u32 q = q0 | (q1 << 8) | (q2 << 16);
        bits = 6u;
        q0 = q & 63u;
        q1 = (q >> 6) & 63u;
        q2 = (q >> 12) & 63u;
        q3 = q >> 18;
    }
    return HDS_FLOAT4(
        codec_value16(block[0], q0, bits, type), codec_value16(block[1], q1, bits, type),
        codec_value16(block[2], q2, bits, type), codec_value16(block[3], q3, bits, type));
}

/* A value of a channel of 32 bits from its ends and an index of 12 bits. */
HDS_FUNCTION f32 codec_value32(u32 a, u32 b, u32 q) {
    u32 orderA = codec_orderOfFloat(a);
    u32 orderB = codec_orderOfFloat(b);
    if (orderA > orderB) {
        u32 order = orderB + codec_interpolateWide(orderA - orderB, q, 12u);
        return HDS_AS_FLOAT(codec_floatOfOrder(order));
    }
    return codec_mix(HDS_AS_FLOAT(a), HDS_AS_FLOAT(b), q, 12u);
}

HDS_FUNCTION f32 codec_scalar32(HDS_GLOBAL const u32* block, u32 texel) {
    u32 q = (block[2u + (texel >> 2)] >> (8u * (texel & 3u))) & 255u;
    q |= ((block[6u + (texel >> 3)] >> (4u * (texel & 7u))) & 15u) << 8;
    return codec_value32(block[0], block[1], q);
}

HDS_FUNCTION f32 codec_linear8(u32 code, u32 isEncoded) {
    return isEncoded != 0u ? srgb_linear[code] : (f32)code * 0.0039215689f;
}

/* The texel at (x, y) of a line's rectangle, linear; channels that are not stored are 0, 0, 0, 1.
 * \param line HDS_LINE_BYTES
 * \param format HDS_TEXEL_* */
HDS_FUNCTION float4 codec_texel(HDS_GLOBAL const u32* line, u32 format, u32 x, u32 y) {
    u32 type = format & HDS_TEXEL_TYPE_MASK;
    u32 channelsLog2 = format & HDS_TEXEL_CHANNELS_LOG2_MASK;
    u32 blockIndex = ((y >> 2) << texel_lineWidthLog2(format)) | (x >> 2);
    HDS_GLOBAL const u32* block = line + (blockIndex << (texel_blockBytesLog2(format) - 2u));
    u32 texel = ((y & 3u) << 2) | (x & 3u);
    float4 out = HDS_FLOAT4(0.0f, 0.0f, 0.0f, 1.0f);
    if (type == HDS_TEXEL_U8) {
        u32 isEncoded = format & HDS_TEXEL_SRGB;
        if (channelsLog2 == 2u) {
            HdsTexel8 codes = codec_color8(block, texel);
            return HDS_FLOAT4(codec_linear8(codes.r, isEncoded), codec_linear8(codes.g, isEncoded),
                              codec_linear8(codes.b, isEncoded), codec_linear8(codes.a, 0u));
        }
        out.x = codec_linear8(codec_scalar8(block, texel), isEncoded);
        if (channelsLog2 == 1u) {
            u32 second = (format & HDS_TEXEL_SECOND_IS_ALPHA) != 0u ? 0u : isEncoded;
            out.y = codec_linear8(codec_scalar8(block + 2, texel), second);
        }
    } else if (type == HDS_TEXEL_FLOAT) {
        out.x = codec_scalar32(block, texel);
        if (channelsLog2 >= 1u) {
            out.y = codec_scalar32(block + 8, texel);
        }
        if (channelsLog2 == 2u) {
            out.z = codec_scalar32(block + 16, texel);
            out.w = codec_scalar32(block + 24, texel);
        }
    } else if (channelsLog2 == 2u) {
        return codec_color16(block, texel, type);
    } else {
        out.x = codec_scalar16(block, texel, type);
        if (channelsLog2 == 1u) {
            out.y = codec_scalar16(block + 4, texel, type);
        }
    }
    return out;
}
HDS_SHARED_END
#endif
