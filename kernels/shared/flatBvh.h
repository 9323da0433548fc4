/* SPDX-License-Identifier: Apache-2.0
 * The flat hierarchy: one BVH in world space over the triangles of placed meshes, with boxes of
 * floats and leaves that hold vertices. It takes the place of TLAS, groups, top trees and the BVHs
 * of chunks where everything is resident, and finds the same hits. A mesh of many copies has a tree
 * of its own, in its own space, and the BVH in world space has a box for each copy. All of it lies
 * in one buffer: the header, nodes, leaves, places and their transforms. Explained in
 * docs/accel.md. */
#ifndef HDS_SHARED_FLAT_BVH_H
#define HDS_SHARED_FLAT_BVH_H
#include "shared/compat.h"

/* HdsFlatNode.child: bits 31..30 kind, 29..0 the node, the place of a copy, the leaf, or the record
 * of an instance that is not flattened: of one in an instance chunk HDS_FLAT_IN_CHUNK and its
 * number without HDS_RECORD_IN_CHUNK, which takes the other 29 bits. */
#define HDS_FLAT_NODE 0u
#define HDS_FLAT_COPY 0x40000000u
#define HDS_FLAT_LEAF 0x80000000u
#define HDS_FLAT_INSTANCE 0xc0000000u
#define HDS_FLAT_KIND 0xc0000000u
#define HDS_FLAT_IN_CHUNK 0x20000000u

/* Triangles of a leaf. */
#define HDS_FLAT_TRIANGLES 4

/* Offsets in the buffer are in units of so many bytes, the alignment of nodes and leaves. */
#define HDS_FLAT_UNIT_BYTES 64u

/* Most records on the way to a place that is flattened. */
#define HDS_FLAT_MAX_RECORDS 3

HDS_SHARED_BEGIN
/* Begins the buffer; nodes follow, root first, then those of the trees of copies. */
typedef struct {
    u32 leaves;     /* offset of HdsFlatLeaf[] */
    u32 places;     /* offset of HdsFlatPlace[] */
    u32 transforms; /* offset of HdsFlatTransform[] */
    u32 unused[13];
} HdsFlatHeader;
HDS_ASSERT_SIZE(HdsFlatHeader, 64);

/* Eight boxes per axis, in world space or, in the tree of a mesh, in its own; a slot without a
 * child is inside out and infinite, and leads to leaf 0, which holds nothing: only rays without a
 * direction come to it. */
typedef struct {
    f32 lo[3][8];
    f32 hi[3][8];
    u32 child[8];
    u32 unused[8];
} HdsFlatNode;
HDS_ASSERT_SIZE(HdsFlatNode, 256);

/* Up to four triangles of one chunk in one place; the place means nothing in the tree of a mesh.
 * Lanes without a triangle have equal corners. */
typedef struct {
    f32 positions[3][3][HDS_FLAT_TRIANGLES]; /* per corner, per axis; object space */
    u32 place;
    u32 chunk;
    u32 triangle[HDS_FLAT_TRIANGLES]; /* chunk-local */
    u32 primId[HDS_FLAT_TRIANGLES];   /* as in the page */
    u32 numTriangles;
    u32 unused;
} HdsFlatLeaf;
HDS_ASSERT_SIZE(HdsFlatLeaf, 192);

/* Object from parent, as of HdsInstance; by columns, so that a ray is transformed in lanes. */
typedef struct {
    f32 columns[4][4]; /* the last one is the translation; the last component of each is 0 */
} HdsFlatTransform;
HDS_ASSERT_SIZE(HdsFlatTransform, 64);

/* A placement of a mesh, through all levels. */
typedef struct {
    u32 instance;       /* record that its hits name (HdsHit.instance) */
    u32 flags;          /* of the leaf record */
    u32 seen;           /* flags that all records on the way have */
    u32 firstTransform; /* on the way, from the TLAS inwards; places with equal ones share them */
    u32 numTransforms;
    u32 pathIndex[2]; /* low, high */
    u32 root;         /* of a copy: the root of its mesh's tree */
} HdsFlatPlace;
HDS_ASSERT_SIZE(HdsFlatPlace, 32);
HDS_SHARED_END
#endif
