/* SPDX-License-Identifier: Apache-2.0
 * A material as the shade kernel reads it: a UsdPreviewSurface, or a layered surface, which shares
 * its inputs as far as they go. Each input is a constant, comes from a primvar of the prim, or is
 * set by a program (shared/program.h); the pair (material, prim layout) is resolved by commit, so
 * slots are final. Explained in docs/shading.md and docs/materials.md. */
#ifndef HDS_SHARED_MATERIAL_H
#define HDS_SHARED_MATERIAL_H
#include "shared/compat.h"

/* HDS_INPUT_*: indices of inputs. Those below HDS_NUM_INPUTS are in the record, each a float4
 * constant with scalars in x; those above are of layered surfaces and hair alone. */
enum {
#define HDS_PREVIEW_INPUT(NAME, name, components, x, y, z, w) HDS_INPUT_##NAME,
#define HDS_LAYERED_INPUT(NAME, name, components, x, y, z, w) HDS_INPUT_##NAME,
#include "shared/materialInputs.def"
    HDS_NUM_LAYERED_INPUTS,
#define HDS_PREVIEW_INPUT(NAME, name, components, x, y, z, w) +1
    HDS_NUM_INPUTS = 0
#include "shared/materialInputs.def"
};

/* HdsMaterial.flags */
#define HDS_MATERIAL_SPECULAR_WORKFLOW 1u /* of a UsdPreviewSurface */
/* Of layered surfaces: a thin wall spreads by its roughness where that is above
 * HDS_CLEAR_ROUGHNESS, and there what has been read at a hit still has the flag. */
#define HDS_MATERIAL_FROSTED 1u
#define HDS_MATERIAL_CUTOUT 2u /* opacity may be below 1 */
#define HDS_MATERIAL_EMISSIVE 4u
#define HDS_MATERIAL_NORMAL 8u    /* the normal input is not (0,0,1) */
#define HDS_MATERIAL_LAMBERT 16u  /* no specular lobe at all: a prim without bound material */
#define HDS_MATERIAL_MASK 32u     /* a constant opacityThreshold: opacity alone says what passes */
#define HDS_MATERIAL_TANGENTS 64u /* the normal input is in the frame of texture coordinates */
#define HDS_MATERIAL_THIN_WALLED 128u /* what it transmits is not bent */
#define HDS_MATERIAL_FUZZ 256u        /* the sheen lies on top of the coat */
#define HDS_MATERIAL_COMPUTES 512u    /* its program does more than add and multiply */
#define HDS_MATERIAL_PRESENCE 1024u   /* of a UsdPreviewSurface: opacityMode presence */
/* Of layered surfaces: the sheen lies on all but the coat, on metal too, not on what is diffuse
 * alone. Where a hit chooses from closures with sheens of several kinds, their roughnesses say
 * which they are (shared/sheen.h). */
#define HDS_MATERIAL_SHEEN_OVER 1024u
#define HDS_MATERIAL_MEDIUM 2048u    /* light is scattered below the surface */
#define HDS_MATERIAL_HAIR 4096u      /* hair, or hair by chance (HDS_INPUT_HAIR) */
#define HDS_MATERIAL_GLASS 8192u     /* shadow rays pass where it refracts and is smooth */
#define HDS_MATERIAL_SPLAT 16384u    /* of Gaussian splats: opacity and emission are theirs */
#define HDS_MATERIAL_DEGREE_SHIFT 15 /* 2 bits: the degree of their spherical harmonics */

/* HdsMaterial.lobes: what a layered surface is made of; 0: a UsdPreviewSurface. HDS_LOBES is the
 * union over a scene: what is not in it is not compiled. */
#define HDS_LOBE_BASE 1u
#define HDS_LOBE_COAT 2u
#define HDS_LOBE_SHEEN 4u
#define HDS_LOBE_ANISOTROPY 8u
#define HDS_LOBE_TRANSMISSION 16u /* refraction */
#define HDS_LOBE_TRANSLUCENCY 32u /* diffuse transmission */
#define HDS_LOBE_FILM 64u         /* a thin film over the base */
#define HDS_LOBE_CONDUCTOR 128u   /* metal by Fresnel's equations, not by Schlick's term */
#define HDS_LOBE_SCHLICK 256u     /* a dielectric's reflection by Schlick's term, generalised */
#define HDS_LOBE_COAT_FRAME 512u  /* a coat with a normal of its own, or stretched */
#define HDS_LOBE_FROST 1024u      /* thin walls that spread what they transmit */
#define HDS_LOBE_RETRO 2048u      /* reflections that send light back */
#define HDS_LOBE_COVERED 4096u    /* what lies on it is chosen apart (HDS_INPUT_COVER) */
#define HDS_LOBES_ALL 8191u
#define HDS_LOBES_RARE 6912u /* those that HDS_RARE_INPUT is for */
/* Those that are known to the form of one path alone (HDS_SHADE_WIDE). */
#define HDS_LOBES_ALONE (HDS_LOBE_FILM | HDS_LOBE_SCHLICK)

/* What lies on a closure that a hit has chosen: so many are looked at (HDS_LOBE_COVERED). */
#define HDS_MAX_COVERS 32

/* Thin walls that are no rougher let light straight on: the default of the models and a little
 * more.
 */
#define HDS_CLEAR_ROUGHNESS 0.35f

/* What a ray goes through (shading/medium.clh). */
#define HDS_MEDIUM_NONE 0u     /* vacuum, or what only absorbs */
#define HDS_MEDIUM_INTERIOR 1u /* the inside of a surface that refracts */
#define HDS_MEDIUM_WALK 2u     /* below a surface with subsurface scattering */
/* The inside of a mesh, of its material's volume (shared/meshMedium.h). */
#define HDS_MEDIUM_ABSORBS 3u /* it scatters nothing, and what is left of light is exact */
#define HDS_MEDIUM_SCATTERS 4u
#define HDS_MEDIUM_PROBE 5u /* none: the ray looks for the media that the camera is in */

HDS_SHARED_BEGIN
typedef struct {
    float4 constants[HDS_NUM_INPUTS];
    u32 slots[HDS_NUM_INPUTS]; /* attribute slot, or HDS_NONE: the constant */
    u32 flags;
    u32 program;       /* first word of its program, or HDS_NONE */
    u32 programInputs; /* bit i: the program sets input i of those above */
    u32 lobes;         /* HDS_LOBE_* */
    u32 meshMedium;    /* number of the medium inside (shared/meshMedium.h); 0: none of its own */
} HdsMaterial;
HDS_ASSERT_SIZE(HdsMaterial, HDS_NUM_INPUTS * 20 + 20);
HDS_SHARED_END
#endif
