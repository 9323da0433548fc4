/* SPDX-License-Identifier: Apache-2.0
 * A material as the shade kernel reads it: a UsdPreviewSurface, or a layered surface, which shares
 * its inputs as far as they go. Each input is a constant, comes from a primvar of the mesh, or is
 * set by a program (shared/program.h); the pair (material, mesh layout) is resolved by commit, so
 * slots are final. Explained in docs/shading.md and docs/materials.md. */
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

/* Inputs of layered surfaces alone. They are not in the record: a program sets those that are not
 * layered_defaults (shading/layeredSurface.clh). Of the inputs above a layered surface reads
 * DIFFUSE_COLOR and SPECULAR_COLOR as the colours of its dielectric part, METALLIC as the weight of
 * its metal, and CLEARCOAT as that of its coat. */
#define HDS_INPUT_DIELECTRIC 11      /* weight of all that is not metal */
#define HDS_INPUT_SPECULAR_WEIGHT 12 /* of the dielectric's reflection */
#define HDS_INPUT_METAL_COLOR 13     /* reflectance at normal incidence... */
#define HDS_INPUT_EDGE_COLOR 14      /* ...and its tint at about 82 degrees */
#define HDS_INPUT_STRETCH 15         /* xy: factors of alpha, z: turns of the tangent */
#define HDS_INPUT_DIFFUSE_ROUGHNESS 16
#define HDS_INPUT_COAT_TINT 17 /* of what lies below the coat */
#define HDS_INPUT_COAT_IOR 18
#define HDS_INPUT_SHEEN 19
#define HDS_INPUT_SHEEN_COLOR 20
#define HDS_INPUT_SHEEN_ROUGHNESS 21
#define HDS_INPUT_TRANSMISSION 22
#define HDS_INPUT_TRANSMISSION_COLOR 23
#define HDS_INPUT_ABSORPTION 24   /* of the interior, per unit of length */
#define HDS_INPUT_TRANSLUCENCY 25 /* colour of diffuse transmission */
#define HDS_INPUT_FILM 26         /* x: weight of a thin film, y: nanometres, z: its index */
#define HDS_NUM_LAYERED_INPUTS 27

/* HdsMaterial.flags */
#define HDS_MATERIAL_SPECULAR_WORKFLOW 1u
#define HDS_MATERIAL_CUTOUT 2u /* opacity may be below 1 */
#define HDS_MATERIAL_EMISSIVE 4u
#define HDS_MATERIAL_NORMAL 8u    /* the normal input is not (0,0,1) */
#define HDS_MATERIAL_LAMBERT 16u  /* no specular lobe at all: a mesh without bound material */
#define HDS_MATERIAL_MASK 32u     /* a constant opacityThreshold: opacity alone says what passes */
#define HDS_MATERIAL_TANGENTS 64u /* the normal input is in the frame of texture coordinates */
#define HDS_MATERIAL_THIN_WALLED 128u /* what it transmits goes straight on */
#define HDS_MATERIAL_FUZZ 256u        /* the sheen lies on top of the coat */
#define HDS_MATERIAL_COMPUTES 512u    /* its program does more than add and multiply */
#define HDS_MATERIAL_PRESENCE 1024u   /* opacityMode presence */

/* HdsMaterial.lobes: what a layered surface is made of; 0: a UsdPreviewSurface. HDS_LOBES is the
 * union over a scene: what is not in it is not compiled. */
#define HDS_LOBE_BASE 1u
#define HDS_LOBE_COAT 2u
#define HDS_LOBE_SHEEN 4u
#define HDS_LOBE_ANISOTROPY 8u
#define HDS_LOBE_TRANSMISSION 16u /* refraction */
#define HDS_LOBE_TRANSLUCENCY 32u /* diffuse transmission */
#define HDS_LOBE_FILM 64u         /* a thin film over the base */
#define HDS_LOBES_ALL 127u

HDS_SHARED_BEGIN
typedef struct {
    float4 constants[HDS_NUM_INPUTS];
    u32 slots[HDS_NUM_INPUTS]; /* attribute slot, or HDS_NONE: the constant */
    u32 flags;
    u32 program;       /* first word of its program, or HDS_NONE */
    u32 programInputs; /* bit i: the program sets input i */
    u32 lobes;         /* HDS_LOBE_* */
    u32 reserved;
} HdsMaterial;
HDS_ASSERT_SIZE(HdsMaterial, HDS_NUM_INPUTS * 20 + 20);
HDS_SHARED_END
#endif
