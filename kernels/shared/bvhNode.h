/* SPDX-License-Identifier: Apache-2.0
 * The 8-wide compressed BVH node, one format for every level: TLAS and groups (items are
 * instances), top trees (items are chunks) and chunks (items are triangles). Source: Ylitie,
 * Karras, Laine 2017, "Efficient Incoherent Ray Traversal on GPUs Through Compressed Wide BVHs",
 * section 3. Deviates: boxes are conservative after quantisation (verified at build). Explained in
 * docs/accel.md. */
#ifndef HDS_SHARED_BVH_NODE_H
#define HDS_SHARED_BVH_NODE_H
#include "shared/compat.h"

/* Most items (triangles, chunks or instances) that one child slot can hold. */
#define HDS_BVH_MAX_LEAF_ITEMS 3
/* Most nodes on a path from the root of one BVH; sizes the traversal stacks. */
#define HDS_BVH_MAX_DEPTH 24

HDS_SHARED_BEGIN
/* Child box plane = origin + 2^(e-127) * q, per axis; q is a byte.
 * meta, one byte a slot: 0 empty; leaf: bits 7..5 unary count (001, 011, 111), bits 4..0 offset
 * from itemBase (0..23); inner: 001 in bits 7..5, 24 + slot in bits 4..0 and the slot's bit in
 * imask. */
typedef struct {
    f32 origin[3];
    u32 exponentsImask; /* bits 7..0 ex, 15..8 ey, 23..16 ez (biased by 127), 31..24 imask */
    u32 childBase;      /* index of the first inner child, relative to the BVH's node base */
    u32 itemBase;       /* index of the first item, relative to the BVH's item base */
    u32 meta[2];        /* 8 bytes, slot 0 in the low byte of meta[0] */
    u32 qlo[3][2];      /* per axis 8 bytes: low planes */
    u32 qhi[3][2];      /* per axis 8 bytes: high planes */
} HdsBvhNode;
HDS_ASSERT_SIZE(HdsBvhNode, 80);
HDS_SHARED_END
#endif
