/* SPDX-License-Identifier: Apache-2.0
 * Conditions of path fields (shared/pathState.def) that several features make. Kernels evaluate
 * them in #if, where features are macros; the host (hdStream/integrator) where features are
 * variables that have the names of these macros. */
#ifndef HDS_SHARED_PATH_CONDITIONS_H
#define HDS_SHARED_PATH_CONDITIONS_H

/* Rays keep a list of the missing chunks in their way. */
#define HDS_KEEPS_WAIT_LISTS (HDS_FEATURE_STREAMING && !HDS_REQUEST_FIRST)

/* Pending chunks may lie in instance chunks. */
#define HDS_KEEPS_OUTER_WAITS (HDS_KEEPS_WAIT_LISTS && HDS_FEATURE_INSTANCE_CHUNKS)

/* Where the shadow ray goes is kept beside it. */
#define HDS_KEEPS_SHADOW_LIGHT (HDS_FEATURE_LIGHT_CONTROLS || HDS_FEATURE_TEXTURED_EMISSION)

/* Light in the media of meshes depends on whose boundary was entered. */
#define HDS_KEEPS_MEDIA_LINKS (HDS_FEATURE_MEDIA_STACK && HDS_FEATURE_LIGHT_CONTROLS)

/* Walks through volumes may wait at a collision for a line of a brick. */
#define HDS_KEEPS_COLLISIONS (HDS_FEATURE_VOLUMES && HDS_FEATURE_TEXTURE_STREAMING)

/* Some light path expression is asked for: paths carry the state of an automaton. */
#define HDS_FOLLOWS_LIGHT_PATHS (HDS_LIGHT_PATHS > 0)

/* All camera rays begin with the same throughput, radiance and source normal, which are not kept
 * until their first hit is shaded: they were three of seven fields that waves began with. Lenses
 * weigh their rays; paths in media have their own before. */
#define HDS_CAMERA_RAYS_ARE_ALIKE                                              \
    (!HDS_FEATURE_CAMERA_LENS && !HDS_FEATURE_MEDIA && !HDS_FEATURE_VOLUMES && \
     !HDS_FEATURE_OCCLUSION)

#endif
