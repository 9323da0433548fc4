/* SPDX-License-Identifier: Apache-2.0
 * Programs of the shader stack machine: u32 words, an instruction is a word and its operands.
 * The low 8 bits of an instruction are the operation, the others its argument. The stack holds
 * float4; texture coordinates take two places: (s, t, 0, 0), then their derivatives
 * (ds/du, dt/du, ds/dv, dt/dv) by the barycentrics of the triangle. Source: Fujieda and Harada 2022
 * (shader programs as data for a stack machine). Explained in docs/shading.md. */
#ifndef HDS_SHARED_PROGRAM_H
#define HDS_SHARED_PROGRAM_H
#include "shared/compat.h"

/* HDS_OP_* */
enum {
#define HDS_OPERATION(NAME, operands, isPattern) HDS_OP_##NAME,
#include "shared/programOperations.def"
    HDS_NUM_OPERATIONS
};

#define HDS_OP(operation, argument) ((operation) | ((argument) << 8))

/* Channels: one of the four in all places, or all as they are. */
#define HDS_CHANNEL_ALL 4u
#define HDS_STORE(input, channel) ((input) | ((channel) << 8))

/* Argument of HDS_OP_TEXTURE. */
#define HDS_WRAP_BLACK 0u
#define HDS_WRAP_CLAMP 1u
#define HDS_WRAP_REPEAT 2u
#define HDS_WRAP_MIRROR 3u
#define HDS_LOOKUP_WRAPS(wrapS, wrapT) ((wrapS) | ((wrapT) << 2))
#define HDS_LOOKUP_UDIM 16u     /* tile i of the texture list is UDIM 1001 + i */
#define HDS_LOOKUP_TANGENTS 32u /* the normal input is in the frame of these coordinates */
#define HDS_LOOKUP_POPS 64u
#define HDS_LOOKUP_AGAIN 128u /* at the coordinates of the look-up before: none are popped */
/* What of the argument says which texels are read. */
#define HDS_LOOKUP_WHERE (15u | HDS_LOOKUP_UDIM)

#define HDS_MATH(function, count) ((function) | ((count) << 8))

#define HDS_SPACE_OBJECT 0u
#define HDS_SPACE_WORLD 1u
#define HDS_TANGENT_ACROSS 2u

/* What HDS_OP_TO_SPACE carries. */
#define HDS_CARRIES_POINT 0u
#define HDS_CARRIES_VECTOR 2u
#define HDS_CARRIES_NORMAL 4u /* by the inverse transpose; its length is any */

#define HDS_SHIFT_BACK 0u
#define HDS_SHIFT_S 1u /* along s */
#define HDS_SHIFT_T 2u
#define HDS_SHIFT_MINUS 4u            /* in the other direction */
#define HDS_SHIFT_STEP 0.00048828125f /* 2^-11, the texel of an image 2048 wide */

/* What an amount of displacement is. */
#define HDS_DISPLACES_ALONG 0u   /* x, along the normal */
#define HDS_DISPLACES_TANGENT 1u /* along dP/ds, on the side of dP/dt, along the normal */
#define HDS_DISPLACES_OBJECT 2u  /* a vector in object space */

/* Most values on the stack, and registers; the compiler keeps programs below them. */
#define HDS_PROGRAM_STACK 16u
#define HDS_PROGRAM_REGISTERS 8u

#endif
