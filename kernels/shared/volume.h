/* SPDX-License-Identifier: Apache-2.0
 * A volume: what its grids mean to light. Explained in docs/volumes.md. */
#ifndef HDS_SHARED_VOLUME_H
#define HDS_SHARED_VOLUME_H
#include "shared/grid.h"

/* HdsVolumeField.flags: it has the voxels of the first field, so its cells are in the same places.
 */
#define HDS_FIELD_IS_ALIGNED 1u
/* Its three grids are red, green and blue; else one is all. */
#define HDS_FIELD_IS_COLOR 2u
/* It is no field but a pattern: `grid` is the first word of its program. From the shift on a bit
 * for each field of its volume's table that the program reads. */
#define HDS_FIELD_IS_PATTERN 4u
#define HDS_FIELD_READS_SHIFT 8

/* Fields of a volume, in this order. */
#define HDS_FIELD_DENSITY 0
#define HDS_FIELD_EMISSION 1
#define HDS_FIELD_TEMPERATURE 2
#define HDS_NUM_FIELDS 3

/* Of volumes whose coefficients are sums of products of fields. */
#define HDS_MAX_TERMS 16u
#define HDS_MAX_TERM_FIELDS 8u
#define HDS_MAX_TERM_FACTORS 4u

/* Grids of a velocity, which has signs: what is above 0 along x, y and z, then what is below. */
#define HDS_VELOCITY_GRIDS 6u

HDS_SHARED_BEGIN
typedef struct {
    u32 grid; /* the first of its grids; HDS_NONE: the value is 1 everywhere */
    u32 flags;
    float indexFromLattice[12]; /* rows; of fields that are not aligned */
} HdsVolumeField;
HDS_ASSERT_SIZE(HdsVolumeField, 56);

/* A product of fields, and what each coefficient has of it, a unit of length. */
typedef struct {
    float extinction[3];
    float scattering[3];
    float emission[3];
    float turned[3]; /* scattering times mean cosine; with HDS_TERMS_TURN */
    u32 factors; /* a byte for each of its fields, the first in the lowest: its number, counted from
                1; 0: no more */
} HdsVolumeTerm;
HDS_ASSERT_SIZE(HdsVolumeTerm, 52);

/* HdsVolumeTerms.flags: the mean cosine of an event is what its terms say, by scattering. */
#define HDS_TERMS_TURN 1u

/* What light meets in a volume, as a sum. A field that is squared is in the table twice, so that
 * each factor reads a voxel of its own. */
typedef struct {
    u32 numTerms;
    u32 numMedium;               /* the first of them, which have extinction or scattering */
    u32 flags;                   /* HDS_TERMS_* */
    float objectFromLattice[12]; /* rows: where patterns are */
    HdsVolumeField fields[HDS_MAX_TERM_FIELDS];
    HdsVolumeTerm terms[HDS_MAX_TERMS];
} HdsVolumeTerms;
HDS_ASSERT_SIZE(HdsVolumeTerms, 1340);

/* Lattice: the voxel coordinates of the volume's first field. */
typedef struct {
    float latticeFromWorld[9]; /* rows of the linear part */
    float worldCentre[3];      /* of the box, relative to the scene centre */
    float latticeCentre[3];    /* the same point */
    float boxMin[3];           /* in the lattice; nothing is outside */
    float boxMax[3];
    float extinction[3]; /* a unit of length at a density of 1 */
    float most;          /* the greatest of them */
    float albedo[3];     /* of an event */
    float asymmetry;     /* mean cosine of the phase function (Henyey and Greenstein 1941) */
    float emission[3];   /* a unit of length at an emission of 1 */
    float kelvin;        /* at a temperature of 1 */
    float blackbody[3];  /* factor on the radiance of a black body; 0: temperature is not read */
    float
        emissionRate; /* collisions a unit of length, beside those of the density, where it glows */
    HdsVolumeField fields[HDS_NUM_FIELDS];
    u32 identity; /* what tells its random numbers from those of others */
    /* Of volumes that move. Its grid is the first of HDS_VELOCITY_GRIDS; HDS_NONE: at rest. */
    HdsVolumeField velocity;
    float latticeFromVelocity[9]; /* rows: voxels a second */
    float openSeconds;            /* of the shutter, from the frame on */
    float closeSeconds;
    float workingFromRec709[9]; /* rows; with HDS_FEATURE_WORKING_SPACE */
    /* Of volumes whose transform moves: keys from a point of the lattice, less latticeCentre, to
     * the world, relative to the scene centre, at equal steps of the shutter. The map above is that
     * of the frame. */
    u32 firstKey;
    u32 numSegments; /* of keys; 0: the transform is at rest */
    /* With HDS_FEATURE_VOLUME_TERMS: among those of the scene; HDS_NONE: extinction, albedo and
     * emission are what is said above. Where there are some, the first field's cells bound the
     * greatest and the least channel of the extinction, the second's that of the emission, and
     * neither has voxels; extinction is 1, albedo and emission say nothing. */
    u32 terms;
    u32 linkSet; /* which lights are linked to it (HDS_INSTANCE_LINK_SHIFT) */
} HdsVolume;
HDS_ASSERT_SIZE(HdsVolume, 472);
HDS_SHARED_END
#endif
