/* SPDX-License-Identifier: Apache-2.0
 * Tiles of a hexagonal grid that are turned, scaled and moved at random: HDS_MATH_HEXTILE.
 * Source: Mikkelsen 2022, "Practical Real-Time Hex-Tiling", JCGT 11(3), with the random numbers and
 * ranges of MaterialX 1.39's hextiledimage. Explained in docs/materials.md. */
#ifndef HDS_SHARED_PROGRAM_TILES_H
#define HDS_SHARED_PROGRAM_TILES_H
#include "shared/compat.h"
#ifndef __OPENCL_VERSION__
#include <cmath>
#endif

HDS_SHARED_BEGIN
#ifndef __OPENCL_VERSION__
using std::floor;
using std::sqrt;
#endif

HDS_FUNCTION f32 math_fraction(f32 a) {
    return a - floor(a);
}

/* Two numbers in [0, 1) of a grid point. */
HDS_FUNCTION float4 math_hextileRandom(f32 x, f32 y) {
    f32 a = math_fraction(x * 0.1031f);
    f32 b = math_fraction(y * 0.1030f);
    f32 c = math_fraction(x * 0.0973f);
    const f32 mixed = a * (b + 33.33f) + b * (c + 33.33f) + c * (a + 33.33f);
    a = a + mixed;
    b = b + mixed;
    c = c + mixed;
    return HDS_FLOAT4(math_fraction((a + b) * c), math_fraction((a + c) * b), 0.0f, 0.0f);
}

/* The place in the image and the weight of one of the three tiles around a point, and how far it is
 * turned. \param st coordinates. \param spread least angle and range of angles in radians, least
 * scale and range of scales. \param move least offset and range of offsets, number of the tile. */
HDS_FUNCTION float4 math_hextile(float4 st, float4 spread, float4 move) {
    const f32 size = 3.46410162f; /* 2 sqrt(3) */
    const f32 x = st.x * size - 0.57735027f * st.y * size;
    const f32 y = 1.15470054f * st.y * size;
    const f32 fx = math_fraction(x);
    const f32 fy = math_fraction(y);
    const f32 rest = 1.0f - fx - fy;
    const f32 upper = rest <= 0.0f ? 1.0f : 0.0f;
    const f32 sign = 2.0f * upper - 1.0f;
    const f32 weight = move.z == 0.0f   ? -rest * sign
                       : move.z == 1.0f ? upper - fy * sign
                                        : upper - fx * sign;
    const f32 tileX = floor(x) + (move.z == 2.0f ? 1.0f - upper : upper);
    const f32 tileY = floor(y) + (move.z == 1.0f ? 1.0f - upper : upper);
    const f32 centreX = (tileX + 0.5f * tileY) / size;
    const f32 centreY = tileY / (1.15470054f * size);
    const float4 random = math_hextileRandom(tileX + 0.12345f, tileY + 0.12345f);
    const f32 angle = spread.x + spread.y * random.x;
    const f32 scale = spread.z + spread.w * random.y;
    const f32 dx = (st.x - centreX) / scale;
    const f32 dy = (st.y - centreY) / scale;
    return HDS_FLOAT4(
        dx * math_cos(angle) - dy * math_sin(angle) + centreX + move.x + move.y * random.x,
        dx * math_sin(angle) + dy * math_cos(angle) + centreY + move.x + move.y * random.y, weight,
        angle);
}
HDS_SHARED_END

#endif
