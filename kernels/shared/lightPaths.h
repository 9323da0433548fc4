/* SPDX-License-Identifier: Apache-2.0
 * The automaton of light path expressions as kernels read it: words that follow HdsFrameParams in
 * its buffer. Made of hdStream/film/lightPaths; explained in docs/film.md. */
#ifndef HDS_SHARED_LIGHT_PATHS_H
#define HDS_SHARED_LIGHT_PATHS_H
#include "shared/compat.h"

/* Words of the table. */
#define HDS_LIGHT_PATH_STRIDE 0 /* words of a state */
#define HDS_LIGHT_PATH_STATES 1 /* where states begin */
#define HDS_LIGHT_PATH_GROUPS 2 /* the number of the label of each group of lights */

/* Words of a state: the states after each scattering, then by what emits a bit for each expression
 * that matches: for each label lights and domes in turn, and last what is no light. */
#define HDS_SCATTERINGS 7u
#define HDS_SCATTERING_DIFFUSE 0u
#define HDS_SCATTERING_GLOSSY 1u
#define HDS_SCATTERING_SINGULAR 2u
#define HDS_SCATTERING_TRANSMISSION 3u /* is added to these */
#define HDS_SCATTERING_VOLUME 6u

/* Three states, one of each colour channel, in one word. */
#define HDS_LIGHT_PATH_STATE_BITS 10
#define HDS_LIGHT_PATH_STATE_MASK 1023u

/* Most expressions, each a bit of a word. */
#define HDS_MAX_LIGHT_PATHS 32

HDS_SHARED_BEGIN
/* Sums of a pixel for one expression, as HdsFilmPixel's: rgb, the fourth is 0. */
typedef struct {
    float4 sum;      /* of finished blocks; w: film/filmPixel.clh */
    float4 blockSum; /* of the present block */
} HdsLightPathPixel;
HDS_ASSERT_SIZE(HdsLightPathPixel, 32);
HDS_SHARED_END
#endif
