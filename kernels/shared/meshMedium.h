/* SPDX-License-Identifier: Apache-2.0
 * A homogeneous medium that fills the inside of meshes. Materials name it by its number, which is
 * its place in the table of all, counted from 1. Explained in docs/volumes.md. */
#ifndef HDS_SHARED_MESH_MEDIUM_H
#define HDS_SHARED_MESH_MEDIUM_H
#include "shared/compat.h"

/* Numbers of media have 16 bits. */
#define HDS_MAX_MESH_MEDIA 65535u

/* Media that a path may be in at a time. */
#define HDS_MEDIA_STACK_SIZE 12u

HDS_SHARED_BEGIN
typedef struct {
    f32 extinction[3]; /* per unit of length in world space, as what follows */
    f32 asymmetry;
    f32 albedo[3]; /* of one scattering event */
    u32 kind;      /* HDS_MEDIUM_* */
    f32 emission[3];
    f32 priority; /* where bodies overlap, the medium of the greatest is there */
    f32 ior;
    u32 unused[3];
} HdsMeshMedium;
HDS_ASSERT_SIZE(HdsMeshMedium, 64);
HDS_SHARED_END
#endif
