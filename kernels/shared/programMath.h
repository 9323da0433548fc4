/* SPDX-License-Identifier: Apache-2.0
 * Functions of the shader stack machine (HDS_OP_MATH): the host folds constants with the same text.
 * Componentwise unless a function says otherwise; a scalar argument is in all components, and a
 * scalar result as well. Semantics: MaterialX 1.39, standard nodes. Noise: Perlin 2002 on Jenkins'
 * lookup3 hash, as MaterialX's and Open Shading Language's. Explained in docs/materials.md. */
#ifndef HDS_SHARED_PROGRAM_MATH_H
#define HDS_SHARED_PROGRAM_MATH_H
#include "shared/compat.h"
#ifndef __OPENCL_VERSION__
#include <cmath>
#endif

/* Of one argument. */
#define HDS_MATH_ABS 0u
#define HDS_MATH_SIGN 1u
#define HDS_MATH_FLOOR 2u
#define HDS_MATH_CEIL 3u
#define HDS_MATH_ROUND 4u
#define HDS_MATH_SQRT 5u
#define HDS_MATH_EXP 6u
#define HDS_MATH_LN 7u
#define HDS_MATH_SIN 8u
#define HDS_MATH_COS 9u
#define HDS_MATH_TAN 10u
#define HDS_MATH_ASIN 11u
#define HDS_MATH_ACOS 12u
/* Of two. */
#define HDS_MATH_ADD 16u
#define HDS_MATH_SUBTRACT 17u
#define HDS_MATH_MULTIPLY 18u
#define HDS_MATH_DIVIDE 19u
#define HDS_MATH_MODULO 20u
#define HDS_MATH_POWER 21u
#define HDS_MATH_MIN 22u
#define HDS_MATH_MAX 23u
#define HDS_MATH_ATAN2 24u
#define HDS_MATH_GREATER 25u /* 1 or 0 */
#define HDS_MATH_GREATER_OR_EQUAL 26u
#define HDS_MATH_EQUAL 27u
/* Of three. */
#define HDS_MATH_MIX 32u        /* background, foreground, share of the foreground */
#define HDS_MATH_SMOOTHSTEP 33u /* x, low, high */
#define HDS_MATH_SELECT 34u     /* condition, value where it is not 0, value where it is */
/* Not componentwise. */
#define HDS_MATH_DOT 48u /* of xyz; scalar */
#define HDS_MATH_CROSS 49u
#define HDS_MATH_NORMALIZE 50u /* xyz */
#define HDS_MATH_COMBINE 51u   /* of the x of four */
#define HDS_MATH_RGB_TO_HSV 52u
#define HDS_MATH_HSV_TO_RGB 53u
#define HDS_MATH_NOISE2 54u /* of xy; scalar in [-1, 1] */
#define HDS_MATH_NOISE3 55u /* of xyz */
#define HDS_MATH_NOISE2_VECTOR 56u
#define HDS_MATH_NOISE3_VECTOR 57u
#define HDS_MATH_CELL2 58u /* scalar in [0, 1] */
#define HDS_MATH_CELL3 59u
#define HDS_MATH_FRACTAL3 60u /* position, octaves, lacunarity, diminish; scalar */
#define HDS_MATH_FRACTAL3_VECTOR 61u

#define HDS_MATH_MAX_OCTAVES 16

HDS_SHARED_BEGIN
#ifndef __OPENCL_VERSION__
using std::acos;
using std::asin;
using std::atan2;
using std::ceil;
using std::cos;
using std::exp;
using std::fabs;
using std::floor;
using std::fmax;
using std::fmin;
using std::log;
using std::pow;
using std::round;
using std::sin;
using std::sqrt;
using std::tan;
#endif

HDS_FUNCTION f32 math_scalar1(u32 function, f32 a) {
    switch (function) {
    case HDS_MATH_ABS:
        return fabs(a);
    case HDS_MATH_SIGN:
        return a > 0.0f ? 1.0f : a < 0.0f ? -1.0f : 0.0f;
    case HDS_MATH_FLOOR:
        return floor(a);
    case HDS_MATH_CEIL:
        return ceil(a);
    case HDS_MATH_ROUND:
        return floor(a + 0.5f);
    case HDS_MATH_SQRT:
        return sqrt(fmax(a, 0.0f));
    case HDS_MATH_EXP:
        return exp(a);
    case HDS_MATH_LN:
        return log(a);
    case HDS_MATH_SIN:
        return sin(a);
    case HDS_MATH_COS:
        return cos(a);
    case HDS_MATH_TAN:
        return tan(a);
    case HDS_MATH_ASIN:
        return asin(fmin(fmax(a, -1.0f), 1.0f));
    default: /* HDS_MATH_ACOS */
        return acos(fmin(fmax(a, -1.0f), 1.0f));
    }
}

HDS_FUNCTION f32 math_scalar2(u32 function, f32 a, f32 b) {
    switch (function) {
    case HDS_MATH_ADD:
        return a + b;
    case HDS_MATH_SUBTRACT:
        return a - b;
    case HDS_MATH_MULTIPLY:
        return a * b;
    case HDS_MATH_DIVIDE:
        return a / b;
    case HDS_MATH_MODULO:
        return a - b * floor(a / b);
    case HDS_MATH_POWER:
        return pow(a, b);
    case HDS_MATH_MIN:
        return fmin(a, b);
    case HDS_MATH_MAX:
        return fmax(a, b);
    case HDS_MATH_ATAN2:
        return atan2(a, b);
    case HDS_MATH_GREATER:
        return a > b ? 1.0f : 0.0f;
    case HDS_MATH_GREATER_OR_EQUAL:
        return a >= b ? 1.0f : 0.0f;
    default: /* HDS_MATH_EQUAL */
        return a == b ? 1.0f : 0.0f;
    }
}

HDS_FUNCTION f32 math_scalar3(u32 function, f32 a, f32 b, f32 c) {
    f32 t;
    switch (function) {
    case HDS_MATH_MIX:
        return a * (1.0f - c) + b * c;
    case HDS_MATH_SMOOTHSTEP:
        t = fmin(fmax((a - b) / (c - b), 0.0f), 1.0f);
        return t * t * (3.0f - 2.0f * t);
    default: /* HDS_MATH_SELECT */
        return a != 0.0f ? b : c;
    }
}

HDS_FUNCTION f32 math_dot(float4 a, float4 b) {
    return a.x * b.x + a.y * b.y + a.z * b.z;
}

HDS_FUNCTION float4 math_spread(f32 a) {
    return HDS_FLOAT4(a, a, a, a);
}

/* Hue of [0, 1); Smith 1978, "Color gamut transform pairs". */
HDS_FUNCTION float4 math_rgbToHsv(float4 c) {
    const f32 high = fmax(c.x, fmax(c.y, c.z));
    const f32 range = high - fmin(c.x, fmin(c.y, c.z));
    f32 hue = 0.0f;
    if (range > 0.0f) {
        if (c.x >= high) {
            hue = (c.y - c.z) / range;
        } else if (c.y >= high) {
            hue = 2.0f + (c.z - c.x) / range;
        } else {
            hue = 4.0f + (c.x - c.y) / range;
        }
        hue = hue / 6.0f;
        hue = hue - floor(hue);
    }
    return HDS_FLOAT4(hue, high > 0.0f ? range / high : 0.0f, high, c.w);
}

HDS_FUNCTION f32 math_hsvChannel(float4 hsv, f32 shift) {
    f32 k = shift + (hsv.x - floor(hsv.x)) * 6.0f;
    k = k - 6.0f * floor(k / 6.0f);
    return hsv.z * (1.0f - hsv.y * fmin(fmax(fmin(k, 4.0f - k), 0.0f), 1.0f));
}

HDS_FUNCTION float4 math_hsvToRgb(float4 hsv) {
    return HDS_FLOAT4(math_hsvChannel(hsv, 5.0f), math_hsvChannel(hsv, 3.0f),
                      math_hsvChannel(hsv, 1.0f), hsv.w);
}

HDS_FUNCTION u32 math_rotate(u32 x, u32 bits) {
    return (x << bits) | (x >> (32u - bits));
}

/* Jenkins 2006, lookup3, of two or three integers. */
HDS_FUNCTION u32 math_hash(i32 x, i32 y, i32 z, u32 count) {
    const u32 start = 0xdeadbeefu + (count << 2) + 13u;
    u32 a = start + (u32)x;
    u32 b = start + (u32)y;
    u32 c = count > 2u ? start + (u32)z : start;
    c = (c ^ b) - math_rotate(b, 14u);
    a = (a ^ c) - math_rotate(c, 11u);
    b = (b ^ a) - math_rotate(a, 25u);
    c = (c ^ b) - math_rotate(b, 16u);
    a = (a ^ c) - math_rotate(c, 4u);
    b = (b ^ a) - math_rotate(a, 14u);
    return (c ^ b) - math_rotate(b, 24u);
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

HDS_FUNCTION f32 math_fractal3(float4 p, f32 octaves, f32 lacunarity, f32 diminish, u32 shift) {
    const i32 count = (i32)fmin(fmax(octaves, 0.0f), (f32)HDS_MATH_MAX_OCTAVES);
    f32 sum = 0.0f;
    f32 amplitude = 1.0f;
    for (i32 i = 0; i < count; ++i) {
        sum += amplitude * math_noise3(p, shift);
        amplitude *= diminish;
        p.x *= lacunarity;
        p.y *= lacunarity;
        p.z *= lacunarity;
    }
    return sum;
}

HDS_FUNCTION float4 math_special(u32 function, const float4* a) {
    switch (function) {
    case HDS_MATH_DOT:
        return math_spread(math_dot(a[0], a[1]));
    case HDS_MATH_CROSS:
        return HDS_FLOAT4(a[0].y * a[1].z - a[0].z * a[1].y, a[0].z * a[1].x - a[0].x * a[1].z,
                          a[0].x * a[1].y - a[0].y * a[1].x, 0.0f);
    case HDS_MATH_NORMALIZE: {
        const f32 length = sqrt(math_dot(a[0], a[0]));
        const f32 scale = length > 0.0f ? 1.0f / length : 0.0f;
        return HDS_FLOAT4(a[0].x * scale, a[0].y * scale, a[0].z * scale, 0.0f);
    }
    case HDS_MATH_COMBINE:
        return HDS_FLOAT4(a[0].x, a[1].x, a[2].x, a[3].x);
    case HDS_MATH_RGB_TO_HSV:
        return math_rgbToHsv(a[0]);
    case HDS_MATH_HSV_TO_RGB:
        return math_hsvToRgb(a[0]);
    case HDS_MATH_NOISE2:
        return math_spread(math_noise2(a[0], 32u));
    case HDS_MATH_NOISE3:
        return math_spread(math_noise3(a[0], 32u));
    case HDS_MATH_NOISE2_VECTOR:
        return HDS_FLOAT4(math_noise2(a[0], 0u), math_noise2(a[0], 8u), math_noise2(a[0], 16u),
                          0.0f);
    case HDS_MATH_NOISE3_VECTOR:
        return HDS_FLOAT4(math_noise3(a[0], 0u), math_noise3(a[0], 8u), math_noise3(a[0], 16u),
                          0.0f);
    case HDS_MATH_CELL2:
        return math_spread((f32)math_hash(math_cell(a[0].x), math_cell(a[0].y), 0, 2u) /
                           4294967295.0f);
    case HDS_MATH_CELL3:
        return math_spread(
            (f32)math_hash(math_cell(a[0].x), math_cell(a[0].y), math_cell(a[0].z), 3u) /
            4294967295.0f);
    case HDS_MATH_FRACTAL3:
        return math_spread(math_fractal3(a[0], a[1].x, a[2].x, a[3].x, 32u));
    default: /* HDS_MATH_FRACTAL3_VECTOR */
        return HDS_FLOAT4(math_fractal3(a[0], a[1].x, a[2].x, a[3].x, 0u),
                          math_fractal3(a[0], a[1].x, a[2].x, a[3].x, 8u),
                          math_fractal3(a[0], a[1].x, a[2].x, a[3].x, 16u), 0.0f);
    }
}

/* \param a as many arguments as the function has. */
HDS_FUNCTION float4 math_apply(u32 function, const float4* a) {
    if (function >= 48u) {
        return math_special(function, a);
    }
    if (function >= 32u) {
        return HDS_FLOAT4(math_scalar3(function, a[0].x, a[1].x, a[2].x),
                          math_scalar3(function, a[0].y, a[1].y, a[2].y),
                          math_scalar3(function, a[0].z, a[1].z, a[2].z),
                          math_scalar3(function, a[0].w, a[1].w, a[2].w));
    }
    if (function >= 16u) {
        return HDS_FLOAT4(
            math_scalar2(function, a[0].x, a[1].x), math_scalar2(function, a[0].y, a[1].y),
            math_scalar2(function, a[0].z, a[1].z), math_scalar2(function, a[0].w, a[1].w));
    }
    return HDS_FLOAT4(math_scalar1(function, a[0].x), math_scalar1(function, a[0].y),
                      math_scalar1(function, a[0].z), math_scalar1(function, a[0].w));
}
HDS_SHARED_END

#endif
