/* SPDX-License-Identifier: Apache-2.0
 * What tables have no longer where there are instance chunks (HDS_FEATURE_INSTANCE_CHUNKS): objects
 * of one chunk, prims that no record in the table names, and the materials of prims that have one.
 * Explained in docs/streaming.md, "Instances that stream". */
#ifndef HDS_SHARED_INSTANCE_CHUNK_H
#define HDS_SHARED_INSTANCE_CHUNK_H
#include "shared/geometry.h"

/* HdsInstance.object: the index of an object or, of HDS_OBJECT_CHUNK and HDS_OBJECT_INSTANCES, the
 * kind above this shift and the chunk below. */
#define HDS_OBJECT_NUMBER_SHIFT 30

/* In HdsPrim.flags: the prim has one material, whose number is above HDS_PRIM_MATERIAL_SHIFT, and
 * no entry in primMaterials. */
#define HDS_PRIM_ONE_MATERIAL 32u
#define HDS_PRIM_MATERIAL_SHIFT 8
#define HDS_PRIM_MAX_MATERIALS (1u << (32 - HDS_PRIM_MATERIAL_SHIFT))

/* The page of an instance chunk ends with the HdsPrims of what it places, each once; their offset
 * is in HdsPageHeader.vertices. HdsInstance.lightBase is the index there: what a leaf in a chunk
 * places does not glow. */

#endif
