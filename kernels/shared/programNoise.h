/* SPDX-License-Identifier: Apache-2.0
 * Noise of the shader stack machine: Perlin 2002 and Worley 1996 on Jenkins' lookup3 hash, as
 * MaterialX's and Open Shading Language's. Part of shared/programMath.h. Explained in
 * docs/materials.md. */
#ifndef HDS_SHARED_PROGRAM_NOISE_H
#define HDS_SHARED_PROGRAM_NOISE_H
#include "shared/compat.h"
#ifndef __OPENCL_VERSION__
#include <cmath>
#endif

#define HDS_MATH_MAX_OCTAVES 16

HDS_SHARED_BEGIN
#ifndef __OPENCL_VERSION__
using std::floor;
using std::fmax;
using std::fmin;
using std::sqrt;
#endif

HDS_FUNCTION u32 math_rotate(u32 x, u32 bits) {
    return (x << bits) | (x >> (32u - bits));
}

/* The end of Jenkins' lookup3 (2006). */
HDS_FUNCTION u32 math_hashEnd(u32 a, u32 b, u32 c) {
    c = (c ^ b) - math_rotate(b, 14u);
    a = (a ^ c) - math_rotate(c, 11u);
    b = (b ^ a) - math_rotate(a, 25u);
    c = (c ^ b) - math_rotate(b, 16u);
    a = (a ^ c) - math_rotate(c, 4u);
    b = (b ^ a) - math_rotate(a, 14u);
    return (c ^ b) - math_rotate(b, 24u);
}

/* lookup3 of two or three integers. */
HDS_FUNCTION u32 math_hash(i32 x, i32 y, i32 z, u32 count) {
    const u32 start = 0xdeadbeefu + (count << 2) + 13u;
    return math_hashEnd(start + (u32)x, start + (u32)y, count > 2u ? start + (u32)z : start);
}

/* lookup3 of four or five integers. */
HDS_FUNCTION u32 math_hashLong(i32 x, i32 y, i32 z, i32 w, i32 last, u32 count) {
    const u32 start = 0xdeadbeefu + (count << 2) + 13u;
    u32 a = start + (u32)x;
    u32 b = start + (u32)y;
    u32 c = start + (u32)z;
    a = (a - c) ^ math_rotate(c, 4u);
    c += b;
    b = (b - a) ^ math_rotate(a, 6u);
    a += c;
    c = (c - b) ^ math_rotate(b, 8u);
    b += a;
    a = (a - c) ^ math_rotate(c, 16u);
    c += b;
    b = (b - a) ^ math_rotate(a, 19u);
    a += c;
    c = (c - b) ^ math_rotate(b, 4u);
    b += a;
    return math_hashEnd(a + (u32)w, b + (u32)last, c);
}
HDS_FUNCTION u32 math_hash4(i32 x, i32 y, i32 z, i32 w) {
    return math_hashLong(x, y, z, w, 0, 4u);
}
HDS_FUNCTION u32 math_hash5(i32 x, i32 y, i32 z, i32 w, i32 last) {
    return math_hashLong(x, y, z, w, last, 5u);
}

HDS_FUNCTION f32 math_unit(u32 hash) {
    return (f32)hash / 4294967295.0f;
}

HDS_FUNCTION f32 math_signed(f32 value, u32 isNegative) {
    return isNegative != 0u ? -value : value;
}

HDS_FUNCTION f32 math_gradient2(u32 hash, f32 x, f32 y) {
    const u32 h = hash & 7u;
    const f32 u = h < 4u ? x : y;
    const f32 v = 2.0f * (h < 4u ? y : x);
    return math_signed(u, h & 1u) + math_signed(v, h & 2u);
}

HDS_FUNCTION f32 math_gradient3(u32 hash, f32 x, f32 y, f32 z) {
    const u32 h = hash & 15u;
    const f32 u = h < 8u ? x : y;
    const f32 v = h < 4u ? y : (h == 12u || h == 14u) ? x : z;
    return math_signed(u, h & 1u) + math_signed(v, h & 2u);
}

HDS_FUNCTION f32 math_fade(f32 t) {
    return t * t * t * (t * (t * 6.0f - 15.0f) + 10.0f);
}

HDS_FUNCTION f32 math_mix(f32 a, f32 b, f32 t) {
    return a * (1.0f - t) + b * t;
}

/* Floor as an integer; far away from 0 the noise is that of the largest. */
HDS_FUNCTION i32 math_cell(f32 x) {
    return (i32)fmin(fmax(floor(x), -2.0e9f), 2.0e9f);
}

/* Perlin's noise. \param shift which bits of the hash choose gradients: 0, 8 or 16 for three
 * independent noises, 32 for all of them. */
HDS_FUNCTION f32 math_noise2(float4 p, u32 shift) {
    const i32 x = math_cell(p.x);
    const i32 y = math_cell(p.y);
    const f32 fx = p.x - floor(p.x);
    const f32 fy = p.y - floor(p.y);
    f32 row[2];
    for (i32 j = 0; j < 2; ++j) {
        f32 corner[2];
        for (i32 i = 0; i < 2; ++i) {
            const u32 hash = math_hash(x + i, y + j, 0, 2u);
            corner[i] = math_gradient2(shift < 32u ? hash >> shift & 0xffu : hash, fx - (f32)i,
                                       fy - (f32)j);
        }
        row[j] = math_mix(corner[0], corner[1], math_fade(fx));
    }
    return 0.6616f * math_mix(row[0], row[1], math_fade(fy));
}

HDS_FUNCTION f32 math_noise3(float4 p, u32 shift) {
    const i32 x = math_cell(p.x);
    const i32 y = math_cell(p.y);
    const i32 z = math_cell(p.z);
    const f32 fx = p.x - floor(p.x);
    const f32 fy = p.y - floor(p.y);
    const f32 fz = p.z - floor(p.z);
    f32 layer[2];
    for (i32 k = 0; k < 2; ++k) {
        f32 row[2];
        for (i32 j = 0; j < 2; ++j) {
            f32 corner[2];
            for (i32 i = 0; i < 2; ++i) {
                const u32 hash = math_hash(x + i, y + j, z + k, 3u);
                corner[i] = math_gradient3(shift < 32u ? hash >> shift & 0xffu : hash, fx - (f32)i,
                                           fy - (f32)j, fz - (f32)k);
            }
            row[j] = math_mix(corner[0], corner[1], math_fade(fx));
        }
        layer[k] = math_mix(row[0], row[1], math_fade(fy));
    }
    return 0.9820f * math_mix(layer[0], layer[1], math_fade(fz));
}

/* Octaves of Perlin's noise, each of higher frequency by lacunarity and of less weight by diminish.
 * \param shift as math_noise2's. */
HDS_FUNCTION f32 math_fractal(float4 p, f32 octaves, f32 lacunarity, f32 diminish, u32 shift,
                              bool isIn3d) {
    const i32 count = (i32)fmin(fmax(octaves, 0.0f), (f32)HDS_MATH_MAX_OCTAVES);
    f32 sum = 0.0f;
    f32 amplitude = 1.0f;
    for (i32 i = 0; i < count; ++i) {
        sum += amplitude * (isIn3d ? math_noise3(p, shift) : math_noise2(p, shift));
        amplitude *= diminish;
        p.x *= lacunarity;
        p.y *= lacunarity;
        p.z *= lacunarity;
    }
    return sum;
}

HDS_FUNCTION f32 math_cellNoise(float4 p, bool isIn3d) {
    return math_unit(math_hash(math_cell(p.x), math_cell(p.y), math_cell(p.z), isIn3d ? 3u : 2u));
}

/* Three numbers in [0, 1] of a cell. */
HDS_FUNCTION float4 math_cellVector(i32 x, i32 y, i32 z, bool isIn3d) {
    if (isIn3d) {
        return HDS_FLOAT4(math_unit(math_hash4(x, y, z, 0)), math_unit(math_hash4(x, y, z, 1)),
                          math_unit(math_hash4(x, y, z, 2)), 0.0f);
    }
    return HDS_FLOAT4(math_unit(math_hash(x, y, 0, 3u)), math_unit(math_hash(x, y, 1, 3u)),
                      math_unit(math_hash(x, y, 2, 3u)), 0.0f);
}

/* Worley 1996, "A cellular texture basis function", with one point a cell. \param wantsCell
 * HDS_MATH_WORLEY2_CELL or HDS_MATH_WORLEY3_CELL. */
HDS_FUNCTION float4 math_worley(float4 p, f32 jitter, bool isIn3d, bool wantsCell) {
    const i32 x = math_cell(p.x);
    const i32 y = math_cell(p.y);
    const i32 z = isIn3d ? math_cell(p.z) : 0;
    const f32 fx = p.x - floor(p.x);
    const f32 fy = p.y - floor(p.y);
    const f32 fz = isIn3d ? p.z - floor(p.z) : 0.0f;
    f32 first = 1e6f; /* squares of distances */
    f32 second = 1e6f;
    f32 third = 1e6f;
    float4 nearest = p;
    for (i32 i = -1; i <= 1; ++i) {
        for (i32 j = -1; j <= 1; ++j) {
            for (i32 k = isIn3d ? -1 : 0; k <= (isIn3d ? 1 : 0); ++k) {
                const float4 cell = math_cellVector(x + i, y + j, z + k, isIn3d);
                const f32 dx = (f32)i + ((cell.x - 0.5f) * jitter + 0.5f) - fx;
                const f32 dy = (f32)j + ((cell.y - 0.5f) * jitter + 0.5f) - fy;
                const f32 dz = isIn3d ? (f32)k + ((cell.z - 0.5f) * jitter + 0.5f) - fz : 0.0f;
                const f32 distance = dx * dx + dy * dy + dz * dz;
                if (distance < first) {
                    third = second;
                    second = first;
                    first = distance;
                    nearest = HDS_FLOAT4(p.x + dx, p.y + dy, p.z + dz, 0.0f);
                } else if (distance < second) {
                    third = second;
                    second = distance;
                } else if (distance < third) {
                    third = distance;
                }
            }
        }
    }
    if (wantsCell) {
        return math_cellVector(math_cell(nearest.x), math_cell(nearest.y), math_cell(nearest.z),
                               isIn3d);
    }
    return HDS_FLOAT4(sqrt(first), sqrt(second), sqrt(third), math_cellNoise(nearest, isIn3d));
}
HDS_SHARED_END

#endif
