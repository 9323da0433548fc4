/* SPDX-License-Identifier: Apache-2.0
 * Constants of a render and of a wave, as all integrator kernels read them.
 * Explained in docs/wavefront.md. */
#ifndef HDS_SHARED_FRAME_H
#define HDS_SHARED_FRAME_H
#include "shared/compat.h"

/* Samples of a pixel are summed in order inside aligned blocks of this many; block sums are added
 * in order. Farms and resumed renders split at block borders. */
#define HDS_SAMPLE_BLOCK 16u

/* What a sample counts as at most: the squares of as many as there may be (2^24) can be summed. */
#define HDS_MAX_SAMPLE 1e15f

/* HdsFrameParams.flags */
#define HDS_FRAME_ORTHOGRAPHIC 1u
#define HDS_FRAME_ROULETTE 2u
#define HDS_FRAME_CAMERA_MOVES 4u  /* cameraKeys hold; clip planes are in camera space */
#define HDS_FRAME_GLASS_SHADOWS 8u /* shadow rays pass materials with HDS_MATERIAL_GLASS */
#define HDS_FRAME_LEARNS 16u       /* paths are for a guide: holdouts are like other surfaces */
#define HDS_FRAME_DEEP 32u         /* a sample has its light at one depth */

/* HdsFrameParams.projection: what film coordinates are. */
#define HDS_PROJECTION_FILM 0u        /* of the plane at distance 1, or of the orthographic film */
#define HDS_PROJECTION_EQUIDISTANT 1u /* fisheyes: 1 is at the border of the field of view */
#define HDS_PROJECTION_EQUISOLID 2u
#define HDS_PROJECTION_STEREOGRAPHIC 3u
#define HDS_PROJECTION_LATLONG 4u /* longitude and latitude, radians */

/* Most times that one ray may pass through cut-out surfaces; a ray that would pass once more ends
 * and is counted. */
#define HDS_MAX_PASSES 1024u

/* Most keys of a motion after the first. */
#define HDS_MAX_MOTION_SEGMENTS 32

/* Most clipping planes of a camera. */
#define HDS_MAX_CLIP_PLANES 8

/* Device counters (u32 each). */
#define HDS_COUNTER_ACTIVE 0 /* paths that go on to the next ray batch */
#define HDS_COUNTER_SHADOW 1 /* shadow rays to cast */
#define HDS_COUNTER_NAN 2    /* samples that were not finite and count as black */
#define HDS_COUNTER_PASSES 3 /* rays ended by HDS_MAX_PASSES */
/* While geometry streams: what waits for pages, and what may be shaded after it has waited. */
#define HDS_COUNTER_WAITING_RAYS 4
#define HDS_COUNTER_WAITING_SHADOWS 5
#define HDS_COUNTER_WAITING_HITS 6
#define HDS_COUNTER_WAITING_CANDIDATES 7
#define HDS_COUNTER_READY 8
#define HDS_COUNTER_CLAMPED 9 /* of what paths add: what HDS_FEATURE_PATH_LIMITS has clamped */
#define HDS_COUNTER_STEPS 10  /* paths ended by HDS_MEDIUM_MAX_STEPS */
#define HDS_NUM_COUNTERS 11

/* Behind the counters, in lines of the cache of their own: the rays that met nothing, while the
 * guide of domes is learnt (integrator/domeGuidePass). */
#define HDS_GUIDE_CAMERA 32  /* f32[3] */
#define HDS_GUIDE_SCALE 35   /* f32: factor on throughput, for 1 at the camera; 0: do not count */
#define HDS_GUIDE_ESCAPED 48 /* rays that were counted */
#define HDS_GUIDE_ENDED 49   /* rays that surfaces have sent on, and that have ended somewhere */
#define HDS_GUIDE_CELLS \
    64 /* [HDS_GUIDE_PLACES][HDS_GUIDE_ROWS][HDS_GUIDE_COLUMNS]: up to 255 a ray */

HDS_SHARED_BEGIN
/* The lens at a time; as the members of HdsFrameParams. */
typedef struct {
    f32 filmOrigin[2];
    f32 filmStep[2];
    f32 lensRadius;
    f32 focusDistance;
    f32 unused[2];
} HdsLensKey;
HDS_ASSERT_SIZE(HdsLensKey, 32);

/* Camera space: x right, y up, looking along -z; world space is relative to the scene centre. */
typedef struct {
    f32 worldFromCamera[12]; /* 3 rows of 4 */
    f32 filmOrigin[2];       /* raster (0,0) at distance 1 (orthographic: at any) */
    f32 filmStep[2];         /* of one pixel; y is negative: rows go down */
    f32 nearClip;            /* scene units along -z */
    f32 farClip;
    f32 lensRadius;    /* scene units; 0: pinhole */
    f32 focusDistance; /* scene units along -z */
    f32 exposureScale; /* factor on radiance */
    u32 flags;
    u32 imageWidth; /* of the data window */
    u32 imageHeight;
    u32 seed;
    u32 maxDepth; /* bounces after the first hit */
    u32 numLights;
    u32 numClipPlanes;
    i32 dataWindowMin[2]; /* upper left pixel of the data window; rasters and samples count from the
                             display window's, so that a crop has the bits of the full image */
    f32 frameTime;        /* of the frame in the shutter's interval, 0 to 1 */
    u32 cameraSegments;   /* keys after the first */
    /* Of HDS_FEATURE_PATH_LIMITS (integrator/pathLimits.clh). */
    f32 clampDirect; /* INFINITY: none */
    f32 clampIndirect;
    f32 filterGlossy;    /* 0: none */
    u32 maxDiffuseDepth; /* bounces of these lobes */
    u32 maxGlossyDepth;
    u32 maxTransmissionDepth;
    f32 probeLength; /* of the rays that look for the media which the camera is in; 0: in none */
    u32 unused;
    f32 clipPlanes[HDS_MAX_CLIP_PLANES][4]; /* camera rays see dot(plane, (p, 1)) >= 0, world */
    /* worldFromCamera at equal distances in time, from the opening of the shutter to its closing */
    f32 cameraKeys[HDS_MAX_MOTION_SEGMENTS + 1][12];
    /* Of HDS_FEATURE_CAMERA_LENS (integrator/lens.clh). */
    u32 projection;        /* HDS_PROJECTION_* */
    f32 fieldScale;        /* fisheyes: the angle, or its function, at film coordinate 1 */
    u32 apertureBlades;    /* 0: a disk */
    f32 apertureRotation;  /* radians */
    f32 apertureRoundness; /* 0: straight blades, 1: a disk */
    f32 apertureWidth;     /* of its height */
    f32 vignetting;        /* 0: none, 1: the cosine's fourth power */
    f32 fieldRest;         /* equisolid fisheyes: 1 - fieldScale^2, before it was rounded */
    f32 filmRest[4];       /* what filmOrigin and filmStep lack, of other projections than a film */
    u32 pad[3];
    u32 lensSegments; /* lens keys after the first; 0: the lens is the same at all times */
    HdsLensKey lensKeys[HDS_MAX_MOTION_SEGMENTS + 1]; /* at equal distances in time */
} HdsFrameParams;
HDS_ASSERT_SIZE(HdsFrameParams, 352 + (48 + 32) * (HDS_MAX_MOTION_SEGMENTS + 1));

/* A wave: slot i is sample firstSample + i % numSamples of pixel pixels[firstPixel + i /
 * numSamples]. */
typedef struct {
    u32 firstPixel; /* in the list of active pixels */
    u32 numPixels;
    u32 firstSample;
    u32 numSamples;
} HdsWave;
HDS_ASSERT_SIZE(HdsWave, 16);

/* A pixel of the film. Sums are of finite samples, radiance premultiplied. */
typedef struct {
    float4 sum;                /* of finished blocks: r, g, b, alpha */
    float4 blockSum;           /* of the present block */
    f32 luminanceSquares;      /* of the samples of finished blocks */
    f32 blockLuminanceSquares; /* of the samples of the present block */
    f32 blockSquares;          /* of the luminance sums of finished blocks */
    u32 numSamples;
} HdsFilmPixel;
HDS_ASSERT_SIZE(HdsFilmPixel, 48);

/* The AOVs of first hits: X(member of HdsAovOffsets, name of the AOV in hdStream/film/aov.cpp). */
#define HDS_FIRST_HIT_AOVS(X)           \
    X(depth, "depth")                   \
    X(cameraDepth, "cameraDepth")       \
    X(normal, "normal")                 \
    X(normalEye, "Neye")                \
    X(position, "position")             \
    X(positionEye, "Peye")              \
    X(facingRatio, "facingRatio")       \
    X(motionForward, "motionForward")   \
    X(motionBackward, "motionBackward") \
    X(albedo, "albedo")                 \
    X(volumeDepth, "volumeDepth")       \
    X(primId, "primId")                 \
    X(instanceId, "instanceId")         \
    X(elementId, "elementId")

/* Where the first-hit AOVs lie inside a pixel of the float and the int buffer; HDS_NONE: not asked
 * for. */
typedef struct {
    u32 floatStride;
    u32 intStride;
#define HDS_AOV_OFFSET(member, name) u32 member;
    HDS_FIRST_HIT_AOVS(HDS_AOV_OFFSET)
#undef HDS_AOV_OFFSET
    u32 primvars;      /* of the first primvar AOV; the others follow, three floats each */
    f32 centre[3];     /* world position of the device's origin, added to positions */
    u32 numPrimvars;   /* primvar AOVs; their slots: primvarSlots[prim * numPrimvars + i] */
    f32 shutterFrames; /* length of the shutter's interval; 0: closed */
    u32 pad0[2];
} HdsAovOffsets;
HDS_ASSERT_SIZE(HdsAovOffsets, 96);
HDS_SHARED_END
#endif
