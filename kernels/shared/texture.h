/* SPDX-License-Identifier: Apache-2.0
 * A texture as kernels know it: one image file in one colour space. How it is looked up (wrap,
 * scale, fallback) belongs to the shader node. Explained in docs/texturing.md. */
#ifndef HDS_SHARED_TEXTURE_H
#define HDS_SHARED_TEXTURE_H
#include "shared/compat.h"

/* HdsTexture.format: how a texel is stored; channels are 1, 2 or 4. */
#define HDS_TEXEL_R8 0u
#define HDS_TEXEL_RG8 1u
#define HDS_TEXEL_RGBA8 2u
#define HDS_TEXEL_R16 3u
#define HDS_TEXEL_RG16 4u
#define HDS_TEXEL_RGBA16 5u
#define HDS_TEXEL_RHALF 6u
#define HDS_TEXEL_RGHALF 7u
#define HDS_TEXEL_RGBAHALF 8u
#define HDS_TEXEL_RFLOAT 9u
#define HDS_TEXEL_RGFLOAT 10u
#define HDS_TEXEL_RGBAFLOAT 11u

/* HdsTexture.flags */
#define HDS_TEXTURE_SRGB 1u /* colours are sRGB-encoded; linear after decoding */
#define HDS_TEXTURE_GRAY 2u /* the first channel is gray, a second one alpha */

/* Most mips of a texture. */
#define HDS_MAX_MIPS 32u

HDS_SHARED_BEGIN
/* Mip 0 is the image, rows from the top; each further mip halves both sides, rounded down, to at
 * least 1; the last is 1x1. */
typedef struct {
    u32 width; /* texels of mip 0 */
    u32 height;
    u32 numMips; /* 0: the image cannot be read, lookups give the node's fallback */
    u32 format;
    u32 flags;
    u32 firstLine; /* of its lines; without a cache: address of its texels, as a page's address */
    u32 numLines;
    u32 reserved;
} HdsTexture;
HDS_ASSERT_SIZE(HdsTexture, 32);
HDS_SHARED_END
#endif
