/* SPDX-License-Identifier: Apache-2.0
 * Functions of the shader stack machine (HDS_OP_MATH): the host folds constants with the same text.
 * Componentwise unless a function says otherwise; a scalar argument is in all components, and a
 * scalar result as well. Semantics: MaterialX 1.39, standard nodes. Noise is in
 * shared/programNoise.h. Explained in docs/materials.md. */
#ifndef HDS_SHARED_PROGRAM_MATH_H
#define HDS_SHARED_PROGRAM_MATH_H
#include "shared/programFlakes.h"
#include "shared/programFunctions.h"
#include "shared/programNoise.h"
#include "shared/programTiles.h"
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
#define HDS_MATH_FRACTAL2 62u
#define HDS_MATH_FRACTAL2_VECTOR 63u
/* Of position, jitter: distances to the three nearest points, and the cell of the nearest. */
#define HDS_MATH_WORLEY2 64u
#define HDS_MATH_WORLEY3 65u
/* Of position, jitter: three numbers in [0, 1] of the nearest point's cell. */
#define HDS_MATH_WORLEY2_CELL 66u
#define HDS_MATH_WORLEY3_CELL 67u
#define HDS_MATH_HEXTILE 68u /* as math_hextile */
#define HDS_MATH_FLAKE 69u   /* position in cells, coverage: as math_flake */

HDS_SHARED_BEGIN
#ifndef __OPENCL_VERSION__
using std::ceil;
using std::fabs;
using std::round;
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
        return math_exp(a);
    case HDS_MATH_LN:
        return math_log(a);
    case HDS_MATH_SIN:
        return math_sin(a);
    case HDS_MATH_COS:
        return math_cos(a);
    case HDS_MATH_TAN:
        return math_tan(a);
    case HDS_MATH_ASIN:
        return math_asin(fmin(fmax(a, -1.0f), 1.0f));
    default: /* HDS_MATH_ACOS */
        return math_acos(fmin(fmax(a, -1.0f), 1.0f));
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
        return math_pow(a, b);
    case HDS_MATH_MIN:
        return fmin(a, b);
    case HDS_MATH_MAX:
        return fmax(a, b);
    case HDS_MATH_ATAN2:
        return math_atan2(a, b);
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
        return math_spread(math_cellNoise(a[0], false));
    case HDS_MATH_CELL3:
        return math_spread(math_cellNoise(a[0], true));
    case HDS_MATH_FRACTAL3:
        return math_spread(math_fractal(a[0], a[1].x, a[2].x, a[3].x, 32u, true));
    case HDS_MATH_FRACTAL3_VECTOR:
        return HDS_FLOAT4(math_fractal(a[0], a[1].x, a[2].x, a[3].x, 0u, true),
                          math_fractal(a[0], a[1].x, a[2].x, a[3].x, 8u, true),
                          math_fractal(a[0], a[1].x, a[2].x, a[3].x, 16u, true), 0.0f);
    case HDS_MATH_FRACTAL2:
        return math_spread(math_fractal(a[0], a[1].x, a[2].x, a[3].x, 32u, false));
    case HDS_MATH_FRACTAL2_VECTOR:
        return HDS_FLOAT4(math_fractal(a[0], a[1].x, a[2].x, a[3].x, 0u, false),
                          math_fractal(a[0], a[1].x, a[2].x, a[3].x, 8u, false),
                          math_fractal(a[0], a[1].x, a[2].x, a[3].x, 16u, false), 0.0f);
    case HDS_MATH_HEXTILE:
        return math_hextile(a[0], a[1], a[2]);
    case HDS_MATH_FLAKE:
        return math_flake(a[0], a[1].x);
    default: /* HDS_MATH_WORLEY... */
        return math_worley(a[0], a[1].x,
                           function == HDS_MATH_WORLEY3 || function == HDS_MATH_WORLEY3_CELL,
                           function >= HDS_MATH_WORLEY2_CELL);
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
