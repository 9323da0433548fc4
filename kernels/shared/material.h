/* SPDX-License-Identifier: Apache-2.0
 * A UsdPreviewSurface material as the shade kernel reads it. Each input is a constant, comes from a
 * primvar of the mesh, or is set by a program (shared/program.h); the pair (material, mesh layout)
 * is resolved by commit, so slots are final. Explained in docs/shading.md. */
#ifndef HDS_SHARED_MATERIAL_H
#define HDS_SHARED_MATERIAL_H
#include "shared/compat.h"

/* Inputs in record order; each is a float4 constant (scalars in x). */
#define HDS_INPUT_DIFFUSE_COLOR 0
#define HDS_INPUT_EMISSIVE_COLOR 1
#define HDS_INPUT_SPECULAR_COLOR 2
#define HDS_INPUT_NORMAL 3 /* tangent space, already scaled and biased; (0,0,1) is unperturbed */
#define HDS_INPUT_METALLIC 4
#define HDS_INPUT_ROUGHNESS 5
#define HDS_INPUT_CLEARCOAT 6
#define HDS_INPUT_CLEARCOAT_ROUGHNESS 7
#define HDS_INPUT_OPACITY 8
#define HDS_INPUT_OPACITY_THRESHOLD 9
#define HDS_INPUT_IOR 10
#define HDS_NUM_INPUTS 11

/* HdsMaterial.flags */
#define HDS_MATERIAL_SPECULAR_WORKFLOW 1u
#define HDS_MATERIAL_CUTOUT 2u /* opacity may be below 1 */
#define HDS_MATERIAL_EMISSIVE 4u
#define HDS_MATERIAL_NORMAL 8u    /* the normal input is not (0,0,1) */
#define HDS_MATERIAL_LAMBERT 16u  /* no specular lobe at all: a mesh without bound material */
#define HDS_MATERIAL_MASK 32u     /* a constant opacityThreshold: opacity alone says what passes */
#define HDS_MATERIAL_TANGENTS 64u /* the normal input is in the frame of texture coordinates */

HDS_SHARED_BEGIN
typedef struct {
    float4 constants[HDS_NUM_INPUTS];
    u32 slots[HDS_NUM_INPUTS]; /* attribute slot, or HDS_NONE: the constant */
    u32 flags;
    u32 program;       /* first word of its program, or HDS_NONE */
    u32 programInputs; /* bit i: the program sets input i */
    u32 reserved[2];
} HdsMaterial;
HDS_ASSERT_SIZE(HdsMaterial, HDS_NUM_INPUTS * 20 + 20);
HDS_SHARED_END
#endif
