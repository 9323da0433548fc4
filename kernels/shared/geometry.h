/* SPDX-License-Identifier: Apache-2.0
 * Device tables of geometry: instances, objects, prims, and the layout of a chunk's two pages.
 * Always resident: top nodes, instances, objects, prims (shared/instanceChunk.h). In pools: pages.
 * Explained in docs/architecture.md and docs/accel.md. */
#ifndef HDS_SHARED_GEOMETRY_H
#define HDS_SHARED_GEOMETRY_H
#include "shared/bvhNode.h"
#include "shared/residency.h"

/* HdsObject.kind */
#define HDS_OBJECT_GROUP 0u    /* BVH over instances (the TLAS is group object 0) */
#define HDS_OBJECT_TOP_TREE 1u /* top tree over chunks */
#define HDS_OBJECT_CHUNK 2u    /* small geometry: one chunk, no top tree */
/* One instance chunk, HDS_PRIMITIVE_INSTANCES: its records belong to a group (or the TLAS), a
 * record of which stands in for them. That record's transform is the identity. To those who look
 * for records by their paths it comes behind all others: its pathOffset is the largest. */
#define HDS_OBJECT_INSTANCES 3u

/* In HdsObject.kind of a group whose boxes move while the shutter is open: the number of its nodes,
 * behind which lie as many with the boxes when it closes, as behind those of pages with
 * HDS_PAGE_BOXES_MOVE. */
#define HDS_OBJECT_KIND 3u /* mask of the above */
#define HDS_OBJECT_CLOSE_SHIFT 2

/* Deepest nesting of groups below the TLAS on the device; deeper hierarchies are flattened by
 * commit. */
#define HDS_MAX_GROUP_DEPTH 6

/* HdsPrim.flags */
#define HDS_PRIM_LEFT_HANDED 2u /* authored winding: the geometric normal is flipped */
#define HDS_PRIM_CULL_BACK 8u   /* camera rays do not see back faces */
#define HDS_PRIM_CULL_FRONT 16u

/* HdsInstance.flags */
#define HDS_INSTANCE_CUTOUT 1u   /* some material may let rays pass: hits are candidates */
#define HDS_INSTANCE_CAMERA 2u   /* seen by camera rays */
#define HDS_INSTANCE_MOVES 4u    /* objectFromParent holds where its keys are (HDS_MOTION_*) */
#define HDS_INSTANCE_IN_PLACE 8u /* objectFromParent is the identity, and it does not move */
#define HDS_INSTANCE_SHADOW 16u  /* casts shadows */
/* Seen by rays that a surface has sent on, by the kind of the ray (HDS_RAY_KIND_*). */
#define HDS_INSTANCE_DIFFUSE 32u
#define HDS_INSTANCE_REFLECTION 64u
#define HDS_INSTANCE_TRANSMISSION 128u
/* Who sees a prim that says nothing of it. */
#define HDS_INSTANCE_SEEN                                                                         \
    (HDS_INSTANCE_CAMERA | HDS_INSTANCE_SHADOW | HDS_INSTANCE_DIFFUSE | HDS_INSTANCE_REFLECTION | \
     HDS_INSTANCE_TRANSMISSION)
#define HDS_INSTANCE_HOLDOUT 256u  /* camera rays end on it, and leave black with alpha 0 */
#define HDS_INSTANCE_CATCHER 512u  /* camera rays end on it; what others do to its light is kept */
#define HDS_INSTANCE_FIBRE 1024u   /* hair: rays leave its curves and points unhindered */
#define HDS_INSTANCE_MEDIUM 2048u  /* some material has a medium inside (shared/meshMedium.h) */
#define HDS_INSTANCE_LINK_SHIFT 16 /* the bits from here on: the link set (shared/light.h) */

/* Words of objectFromParent of an instance that moves, as bits: the first of its keys of the map
 * outwards, in units of three rows of four floats, and the number of keys after it. Keys are at
 * equal distances in time, from the opening of the shutter to its closing. */
#define HDS_MOTION_FIRST_KEY 0
#define HDS_MOTION_SEGMENTS 1

/* The number of a record: its place in the table or, in an instance chunk, HDS_RECORD_IN_CHUNK, the
 * chunk above HDS_RECORD_CHUNK_SHIFT, and the place in its page below. Instance chunks come before
 * all other chunks. */
#define HDS_RECORD_IN_CHUNK 0x80000000u
#define HDS_RECORD_CHUNK_SHIFT 13
#define HDS_MAX_CHUNK_RECORDS (1u << HDS_RECORD_CHUNK_SHIFT)
#define HDS_MAX_INSTANCE_CHUNKS (1u << (31 - HDS_RECORD_CHUNK_SHIFT))

HDS_SHARED_BEGIN
/* One placement of an object in a group; records of a group lie in the leaf order of its BVH.
 * Spaces: "parent" is the group's space; for the TLAS it is world space relative to the scene
 * centre. */
typedef struct {
    f32 objectFromParent[12]; /* 3 rows of 4, row major; the map outwards is its inverse
                                 (math/inverse.clh) */
    u32 object;               /* index into objects (but shared/instanceChunk.h) */
    u32 flags;
    u32 pathOffset[2]; /* low, high: number of leaf instances before this one inside the group,
                          counted in scene-path order; sums along a path give the path index */
    u32 prim;          /* index into prims for a leaf, HDS_NONE for a group */
    u32 lightBase;     /* first of its material entries in lightByEntry (emissive meshes, which
                          have records in the table of the TLAS only), or HDS_NONE */
    u32 instanceCount; /* placements of the same prototype by its instancer; 0: none places it */
    u32 instanceRank;  /* which of them this is; both fold along a path into instanceId */
} HdsInstance;
HDS_ASSERT_SIZE(HdsInstance, 80);

/* What an instance places. */
typedef struct {
    u32 kind;     /* HDS_OBJECT_*; HDS_OBJECT_CLOSE_SHIFT */
    u32 nodeBase; /* GROUP, TOP_TREE: first node in topNodes */
    u32 itemBase; /* GROUP: first instance; TOP_TREE, CHUNK: first chunk */
    u32 numItems;
} HdsObject;
HDS_ASSERT_SIZE(HdsObject, 16);

/* Shading side of a prim: of a mesh, of curves or of points. */
typedef struct {
    u32 materialBase; /* first entry in primMaterials: entry 0 is the prim's, then one a subset */
    u32 flags;
    i32 primId;      /* the front end's id, for the AOV */
    u32 numPrimvars; /* user primvar slots after the fixed ones */
} HdsPrim;
HDS_ASSERT_SIZE(HdsPrim, 16);

/* A primvar with a value an instance, of a prim. Its row: (n / divisor) % numRows, where n is the
 * number of the prim's placement, folded parent-major: of the AOV instanceId, in 64 bits. */
typedef struct {
    u32 numComponents; /* 1 to 4 */
    u32 numRows;
    u32 divisor[2]; /* placements by the instancers further in: low, high */
    u32 firstValue; /* in instanceValues: [numRows][numComponents] */
} HdsInstanceSlot;
HDS_ASSERT_SIZE(HdsInstanceSlot, 20);

/* A chunk has two pages; their addresses are in the residency table chunkAddresses[2 * chunk +
 * page].
 */
#define HDS_PAGE_GEOMETRY 0u
#define HDS_PAGE_ATTRIBUTES 1u

/* Begins a geometry page; the nodes of the chunk's BVH follow, root first. Offsets are from the
 * page's start, in units of 16 bytes. */
typedef struct {
    u32 triangles; /* offset of HdsTriangle[], in the leaf order of the BVH; of instance chunks of
                      HdsInstance[], and there are neither primIds nor vertices */
    u32 primIds; /* offset of u32[]: of each triangle its index in the object, in order of (authored
                    face, sub-triangle); of instance chunks the object of their group */
    u32 vertices;     /* offset of packed f32[3] positions, object space; HDS_PAGE_MOVES,
                         HDS_PAGE_BOXES_MOVE, HDS_PAGE_SEGMENTS_SHIFT */
    u32 numTriangles; /* bits 26..0: triangles, or primitives of another kind; 31..27: the kind */
} HdsPageHeader;
HDS_ASSERT_SIZE(HdsPageHeader, 16);

/* In HdsPageHeader.vertices: vertices move while the shutter is open, straight from key to key;
 * keys are at equal steps of time, from its opening to its closing. Behind each position lie those
 * at the later keys; of curves and points, behind each vertex the later ones with their radii. The
 * attribute page has as many slots more, behind the user's: HDS_SLOT_NORMAL at the later keys. */
#define HDS_PAGE_MOVES 0x80000000u

/* A geometry page's flag: boxes move too. Behind the nodes, whose boxes are those when the shutter
 * opens, lie as many for each later key, that differ from them in origin, exponents and planes
 * only. Explained in docs/motionBlur.md. */
#define HDS_PAGE_BOXES_MOVE 0x40000000u

/* Where vertices move, 4 bits: the number of later keys less 1; and the bits below. */
#define HDS_PAGE_SEGMENTS_SHIFT 26
#define HDS_MAX_DEFORMATION_SEGMENTS 16
#define HDS_PAGE_VERTICES 0x03ffffffu

/* What the primitives of a chunk are: HDS_PRIMITIVE_* in bits 31..27 of HdsPageHeader.numTriangles.
 * All but triangles have vertices of four floats, the last one the radius; those of ribbons have
 * four more, the normal at the joint and 0. Of splats the last one is the opacity, and there are
 * eight more: the turn as a quaternion, one over the scales, and the cutoff. Where shapes of splats
 * move, later keys have all twelve, and scales as they are. Explained in docs/curves.md and
 * docs/splats.md. */
#define HDS_PRIMITIVE_SHIFT 27
#define HDS_PRIMITIVE_TRIANGLES 0u
#define HDS_PRIMITIVE_POINTS 1u
#define HDS_PRIMITIVE_LINEAR 2u
#define HDS_PRIMITIVE_BEZIER 3u
#define HDS_PRIMITIVE_BSPLINE 4u
#define HDS_PRIMITIVE_CATMULL_ROM 5u
#define HDS_PRIMITIVE_INSTANCES 6u      /* records of a group: an instance chunk */
#define HDS_PRIMITIVE_SPLATS 7u         /* Gaussian splats (accel/splat.clh) */
#define HDS_PRIMITIVE_BASIS 7u          /* mask of the above */
#define HDS_PRIMITIVE_RIBBON 8u         /* a curve that is flat and faces the normals; else round */
#define HDS_PRIMITIVE_LINEAR_WIDTHS 16u /* radii are linear between the joints of a segment */
#define HDS_PRIMITIVE_SHAPES_MOVE 16u   /* of splats: not their centres alone */

/* A triangle of a chunk: its three chunk-local vertex indices. A point or a splat: its vertex, as
 * corner 0. A piece of a segment of a curve: the first of the segment's four vertices, as corner 0,
 * and HDS_PIECE_*. The vertices before and after the four belong to the neighbours, unless the
 * segment begins or ends a curve. Behind those of a piece that stands are the next segment's. */
typedef struct {
    u64 vertices; /* corner k in bits 21 k to 21 k + 20 */
} HdsTriangle;
#define HDS_PIECE_SHIFT 21       /* 7 bits: number of the piece in the segment */
#define HDS_PIECE_LEVEL_SHIFT 28 /* 3 bits: the segment has 2^level pieces */
#define HDS_PIECE_START 0x80000000ul
#define HDS_PIECE_END 0x100000000ul
#define HDS_PIECE_STANDS 0x200000000ul /* the next segment begins where its derivative is 0 */
#define HDS_MAX_PIECE_LEVEL 7
HDS_ASSERT_SIZE(HdsTriangle, 8);
#define HDS_VERTEX_BITS 21
#define HDS_MAX_CHUNK_VERTICES (1u << HDS_VERTEX_BITS)

/* A hit, and the key (t, path index, primId) after which a continuing ray goes on. */
typedef struct {
    f32 t, u, v;      /* position = (1-u-v) p0 + u p1 + v p2; of other primitives: accel/curve.clh,
                         accel/ribbon.clh, accel/ball.clh */
    u32 triangle;     /* chunk-local triangle */
    u32 chunk;        /* HDS_NONE: no hit */
    u32 instance;     /* leaf instance record; with HDS_FEATURE_INSTANCE_CHUNKS the record that it
                         lies below, or is: the one in an instance chunk, else the TLAS's */
    u32 pathIndex[2]; /* 64-bit identity of the leaf instance: low, high */
} HdsHit;
HDS_ASSERT_SIZE(HdsHit, 32);
HDS_SHARED_END

/* Attribute page: u32 slot words, padded to 16 bytes, then blocks aligned to 16 bytes.
 * Slot word: bits 31..29 interpolation, 28..26 components, 25..0 block offset in 16-byte units. */
#define HDS_ATTR_ABSENT 0u
#define HDS_ATTR_CONSTANT 1u /* one value */
#define HDS_ATTR_TRIANGLE 2u /* one value a triangle, leaf order */
#define HDS_ATTR_VERTEX 3u   /* one value a chunk-local vertex */
#define HDS_ATTR_CORNER 4u   /* three values a triangle, in the order of its corners */
#define HDS_ATTR_LINEAR 5u   /* one value a chunk-local vertex, linear between joints of curves */
#define HDS_ATTR_SLOT(interpolation, components, offset) \
    (((interpolation) << 29) | ((components) << 26) | (offset))
/* Fixed slots; user primvars follow from HDS_SLOT_USER on, in the prim's primvar order. */
#define HDS_SLOT_FACE 0u     /* u32: authored face */
#define HDS_SLOT_MATERIAL 1u /* u32: entry of the prim's material list; absent: entry 0 */
#define HDS_SLOT_NORMAL 2u   /* 3 components, object space, towards the authored front */
#define HDS_SLOT_USER 3u
/* Not in pages: slots of the prim's HdsInstanceSlots follow from here on. 24 bits hold them all. */
#define HDS_SLOT_INSTANCE 0x800000u
/* In programs of volumes: fields of the volume, in the order of its table. */
#define HDS_SLOT_FIELD 0xc00000u
#endif
