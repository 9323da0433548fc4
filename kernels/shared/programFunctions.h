/* SPDX-License-Identifier: Apache-2.0
 * Elementary functions of shader programs. Devices compute them by math/power.clh and
 * math/trig.clh, which the kernel includes before, so that all have the same bits; the host, which
 * folds constants, by its library, whose last place may differ. Part of shared/programMath.h.
 * Explained in docs/materials.md. */
#ifndef HDS_SHARED_PROGRAM_FUNCTIONS_H
#define HDS_SHARED_PROGRAM_FUNCTIONS_H
#include "shared/compat.h"
#ifndef __OPENCL_VERSION__
#include <cmath>
#endif

HDS_SHARED_BEGIN
#ifdef __OPENCL_VERSION__
/* (cosine, sine) of an angle of any size; from 2^20 on, where neighbouring numbers are more than a
 * sixteenth apart, by a remainder of the rounded 2 pi. */
HDS_FUNCTION float2 math_turned(f32 angle) {
    return trig_radians(fabs(angle) < 0x1p20f ? angle : fmod(angle, HDS_TWO_PI));
}
HDS_FUNCTION f32 math_exp(f32 x) {
    return power_exp(x);
}
HDS_FUNCTION f32 math_log(f32 x) {
    return power_log(x);
}
HDS_FUNCTION f32 math_pow(f32 x, f32 y) {
    return power_pow(x, y);
}
HDS_FUNCTION f32 math_sin(f32 angle) {
    return math_turned(angle).y;
}
HDS_FUNCTION f32 math_cos(f32 angle) {
    return math_turned(angle).x;
}
HDS_FUNCTION f32 math_tan(f32 angle) {
    const float2 turned = math_turned(angle);
    return turned.y / turned.x;
}
HDS_FUNCTION f32 math_asin(f32 x) {
    return trig_asin(x);
}
HDS_FUNCTION f32 math_acos(f32 x) {
    return trig_acos(x);
}
HDS_FUNCTION f32 math_atan2(f32 y, f32 x) {
    return trig_atan2(y, x);
}
#else
HDS_FUNCTION f32 math_exp(f32 x) {
    return std::exp(x);
}
HDS_FUNCTION f32 math_log(f32 x) {
    return std::log(x);
}
HDS_FUNCTION f32 math_pow(f32 x, f32 y) {
    return std::pow(x, y);
}
HDS_FUNCTION f32 math_sin(f32 angle) {
    return std::sin(angle);
}
HDS_FUNCTION f32 math_cos(f32 angle) {
    return std::cos(angle);
}
HDS_FUNCTION f32 math_tan(f32 angle) {
    return std::tan(angle);
}
HDS_FUNCTION f32 math_asin(f32 x) {
    return std::asin(x);
}
HDS_FUNCTION f32 math_acos(f32 x) {
    return std::acos(x);
}
HDS_FUNCTION f32 math_atan2(f32 y, f32 x) {
    return std::atan2(y, x);
}
#endif
HDS_SHARED_END

#endif
