/* SPDX-License-Identifier: Apache-2.0
 * Programs of the shader stack machine: u32 words, an instruction is a word and its operands.
 * The low 8 bits of an instruction are the operation, the others its argument. The stack holds
 * float4; texture coordinates take two places: (s, t, 0, 0), then their derivatives
 * (ds/du, dt/du, ds/dv, dt/dv) by the barycentrics of the triangle. Source: Fujieda and Harada 2022
 * (shader programs as data for a stack machine). Explained in docs/shading.md. */
#ifndef HDS_SHARED_PROGRAM_H
#define HDS_SHARED_PROGRAM_H
#include "shared/compat.h"

#define HDS_OP_END 0u
#define HDS_OP_MASK_END 1u /* opacity is known; a mask needs no more */
/* operands: 4 floats. Pushes them. */
#define HDS_OP_CONSTANT 2u
/* argument: attribute slot. Pushes its value. */
#define HDS_OP_PRIMVAR 3u
/* argument: attribute slot. Pushes its first two components as texture coordinates. */
#define HDS_OP_COORDINATES 4u
/* operands: 6 floats, rows of 3. Maps the coordinates on top of the stack. */
#define HDS_OP_AFFINE 5u
/* Pops translation, scale, rotation (degrees); maps the coordinates below as UsdTransform2d. */
#define HDS_OP_TRANSFORM 6u
/* argument: HDS_LOOKUP_*. operands: number of tiles, that many textures, and unless
 * HDS_LOOKUP_POPS fallback, scale, bias (4 floats each). Pops coordinates, and with
 * HDS_LOOKUP_POPS bias, scale, fallback; pushes texel * scale + bias, or the fallback. */
#define HDS_OP_TEXTURE 7u
/* argument: HDS_STORE(input, channel). Sets an input to the top of the stack. */
#define HDS_OP_STORE 8u
/* argument: HDS_STORE(0, channel). Replaces the top of the stack by a channel of it. */
#define HDS_OP_CHANNEL 9u
#define HDS_OP_POP 10u
/* Of patterns (HDS_FEATURE_PATTERNS). argument: HDS_MATH(function, count). Pops that many, pushes
 * the function's result (shared/programMath.h). */
#define HDS_OP_MATH 11u
/* argument: a register. Keeps the top of the stack in it; pushes what is in it. */
#define HDS_OP_SAVE 12u
#define HDS_OP_LOAD 13u
/* argument: HDS_SPACE_*. operands: 3 floats, added. Pushes the position. */
#define HDS_OP_POSITION 14u
/* argument: HDS_SPACE_*. Pushes the unit shading normal. */
#define HDS_OP_NORMAL 15u
/* argument: attribute slot. The surface's tangent is that of these coordinates. */
#define HDS_OP_TANGENTS 16u

/* Of patterns. argument: HDS_SHIFT_*. Pops coordinates and moves the point, on the plane of its
 * triangle, by HDS_SHIFT_STEP of them; HDS_SHIFT_BACK pops nothing. */
#define HDS_OP_SHIFT 17u
/* argument: HDS_SPACE_*, and HDS_TANGENT_ACROSS for the bitangent. Pops coordinates, pushes the
 * unit tangent along s, orthogonal to the shading normal, or what is orthogonal to both. */
#define HDS_OP_TANGENT 18u
/* Pushes the unit direction from the viewer, in world space. */
#define HDS_OP_VIEW 19u

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

#define HDS_MATH(function, count) ((function) | ((count) << 8))

#define HDS_SPACE_OBJECT 0u
#define HDS_SPACE_WORLD 1u
#define HDS_TANGENT_ACROSS 2u

#define HDS_SHIFT_BACK 0u
#define HDS_SHIFT_S 1u /* along s */
#define HDS_SHIFT_T 2u
#define HDS_SHIFT_MINUS 4u            /* in the other direction */
#define HDS_SHIFT_STEP 0.00048828125f /* 2^-11, the texel of an image 2048 wide */

/* Most values on the stack, and registers; the compiler keeps programs below them. */
#define HDS_PROGRAM_STACK 16u
#define HDS_PROGRAM_REGISTERS 8u

#endif
