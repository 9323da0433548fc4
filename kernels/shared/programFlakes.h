/* SPDX-License-Identifier: Apache-2.0
 * Flakes at random in the cells of a grid: HDS_MATH_FLAKE. The text is that of MaterialX 1.39's
 * flake3d, with its random numbers; turns by Arvo 1991, "Fast Random Rotation Matrices" (Graphics
 * Gems III). Part of shared/programMath.h. Explained in docs/materials.md. */
#ifndef HDS_SHARED_PROGRAM_FLAKES_H
#define HDS_SHARED_PROGRAM_FLAKES_H
#include "shared/programFunctions.h"
#include "shared/programNoise.h"
#ifndef __OPENCL_VERSION__
#include <cmath>
#endif

#define HDS_FLAKE_RADIUS 0.8660254f /* of the cube that a flake is, in cells */
#define HDS_TURN 6.28318531f

HDS_SHARED_BEGIN
#ifndef __OPENCL_VERSION__
using std::fabs;
using std::sqrt;
#endif

/* How many cells have a flake where so much is covered: a fit. */
HDS_FUNCTION f32 math_flakeProbability(f32 coverage) {
    const f32 x = fmin(fmax(coverage, 0.0f), 1.0f);
    const f32 square = x * x;
    return (-26.19771808f * square + 26.39663835f * x) /
           (85.53857017f * square * x - 102.35069432f * square - 101.42634862f * x + 118.45082288f);
}

/* Whether a place is in the flake of a cell. \param p from the middle of the cell. \param random
 * three numbers in [0, 1] that turn the flake. */
HDS_FUNCTION bool math_isInFlake(float4 p, float4 random) {
    const f32 theta = HDS_TURN * random.x;
    const f32 phi = HDS_TURN * random.y;
    const f32 z = 2.0f * random.z;
    const f32 r = sqrt(z);
    const f32 vx = math_sin(phi) * r;
    const f32 vy = math_cos(phi) * r;
    const f32 vz = sqrt(2.0f - z);
    const f32 sine = math_sin(theta);
    const f32 cosine = math_cos(theta);
    const f32 sx = vx * cosine - vy * sine;
    const f32 sy = vx * sine + vy * cosine;
    const f32 x = (vx * sx - cosine) * p.x + (vy * sx + sine) * p.y + vz * sx * p.z;
    const f32 y = (vx * sy - sine) * p.x + (vy * sy - cosine) * p.y + vz * sy * p.z;
    const f32 last = vx * vz * p.x + vy * vz * p.y + (1.0f - z) * p.z;
    return fabs(x) <= HDS_FLAKE_RADIUS && fabs(y) <= HDS_FLAKE_RADIUS &&
           fabs(last) <= HDS_FLAKE_RADIUS;
}

/* Of the flake at a place that lies above the others: two numbers in [0, 1] for its normal, one of
 * its own, and how far it lies above, which is 0 where there is none. \param p in cells. */
HDS_FUNCTION float4 math_flake(float4 p, f32 coverage) {
    const f32 probability = math_flakeProbability(coverage);
    f32 most = 0.0f;
    i32 cellX = 0;
    i32 cellY = 0;
    i32 cellZ = 0;
    for (i32 i = 0; i < 27; ++i) {
        const i32 x = math_cell(p.x) + i / 9 - 1;
        const i32 y = math_cell(p.y) + i / 3 % 3 - 1;
        const i32 z = math_cell(p.z) + i % 3 - 1;
        const float4 from =
            HDS_FLOAT4(p.x - (f32)x - 0.5f, p.y - (f32)y - 0.5f, p.z - (f32)z - 0.5f, 0.0f);
        if (from.x * from.x + from.y * from.y + from.z * from.z >=
                3.0f * HDS_FLAKE_RADIUS * HDS_FLAKE_RADIUS ||
            math_unit(math_hash(x, y, z, 3u)) > probability) {
            continue;
        }
        const f32 above = math_unit(math_hash4(x, y, z, 3));
        if (above >= most && math_isInFlake(from, math_cellVector(x, y, z, true))) {
            most = above;
            cellX = x;
            cellY = y;
            cellZ = z;
        }
    }
    if (!(most > 0.0f)) {
        return HDS_FLOAT4(0.0f, 0.0f, 0.0f, 0.0f);
    }
    return HDS_FLOAT4(math_unit(math_hash5(cellX, cellY, cellZ, 2, 0)),
                      math_unit(math_hash5(cellX, cellY, cellZ, 2, 1)),
                      math_unit(math_hash5(cellX, cellY, cellZ, 2, 2)), most);
}
HDS_SHARED_END

#endif
