/* SPDX-License-Identifier: Apache-2.0
 * Lights as the light kernels read them. Radiance is linear, in the working space, with intensity,
 * exposure, colour, temperature and normalize already folded in by hdStream/shading/lightTable.
 * Lights at infinity come first. Explained in docs/lights.md. */
#ifndef HDS_SHARED_LIGHT_H
#define HDS_SHARED_LIGHT_H
#include "shared/compat.h"

/* HdsLight.type */
#define HDS_LIGHT_DISTANT 0u  /* a cone of directions about axis, radiance constant inside */
#define HDS_LIGHT_SPHERE 1u   /* surface light; any affine transform (ellipsoid) */
#define HDS_LIGHT_RECT 2u     /* emits along -z of the light's space, one side */
#define HDS_LIGHT_DISK 3u     /* emits along -z of the light's space, one side */
#define HDS_LIGHT_CYLINDER 4u /* axis x of the light's space, no caps */
#define HDS_LIGHT_DOME 5u
#define HDS_LIGHT_MESH 6u /* a cluster of emissive triangles of one instance: lightTriangles */

/* HdsLight.flags */
#define HDS_LIGHT_VISIBLE 1u /* seen by camera rays; of HDS_LIGHT_REPLACES alone: of meshes */
#define HDS_LIGHT_POINT 2u   /* delta position or direction (treatAsPoint, angle 0): only sampled */
#define HDS_LIGHT_TEXTURED 4u  /* dome or rect with an image */
#define HDS_LIGHT_TWO_SIDED 8u /* mesh: emits on both sides */
#define HDS_LIGHT_SAMPLED                                                  \
    16u /* only light samples find it after the first hit: its shadows are \
           not those of geometry, or its part in the lobes is not 1 */
#define HDS_LIGHT_TEXTURED_EMISSION                                                             \
    32u /* mesh: radiance is a factor on what the material emits at the point, which the shadow \
           ray finds out */
#define HDS_LIGHT_WEIGHED                                                  \
    64u /* mesh: triangles are sampled by weights that are not their areas \
         */
#define HDS_LIGHT_REPLACES                                                   \
    128u /* mesh with UsdLuxMeshLightAPI: its radiance replaces the emission \
            of the material, for camera rays only if it is visible to them */

#define HDS_LIGHT_GUIDED 256u /* dome without portals: light samples follow its guide */

/* The guide of domes (light/domeGuide.clh): cells of directions, powers of two, and cubes. */
#define HDS_GUIDE_COLUMNS 16u
#define HDS_GUIDE_ROWS 8u
#define HDS_GUIDE_PLACES 2048u
/* Of the light of a dome, what is taken to arrive there, among other lights. */
#define HDS_GUIDE_ESTIMATE 0.25f

/* Above the flags: the number of the light's group among the groups of the scene, 0: none. */
#define HDS_LIGHT_GROUP_SHIFT 16
#define HDS_MAX_LIGHT_GROUPS 65535u

/* Most lights that are weighed one by one. */
#define HDS_LIGHT_LOOP_MAX 32u

/* Distance of lights at infinity. */
#define HDS_LIGHT_FAR 3.0e38f

HDS_SHARED_BEGIN
typedef struct {
    f32 worldFromLight[12]; /* 3 rows of 4, relative to the scene centre; |determinant| is 1: scale
                               is folded into params. Distant: a rotation. Mesh: [0..2] the mean
                               normal, unit or zero; of one that moves, [3], [7], [11]: its centre
                             */
    f32 lightFromWorld[12]; /* rows of its inverse; in place of the translation, which is not used:
                               the unit normal of the planes of constant z, world space */
    f32 radiance[3]; /* factor on the image of a textured light; point sphere: radiant intensity;
                        distant with angle 0: irradiance at normal incidence */
    u32 type;
    f32 params[4];   /* sphere: radius; rect: width, height; disk: radius; cylinder: radius, length;
                        distant: 1 - cos(half angle); mesh: flatness, 1 when all normals are alike, 0
                        when they cancel out; with an image, [3]: the coarsest mip that is looked up,
                        of which its distribution is made; guided dome, [0]: the bits of where in
                        lightCdf its guide is: the camera [3], then where the distribution of
                        each place is, or HDS_NONE [HDS_GUIDE_PLACES]; before each the share of
                        light samples that follow it */
    f32 area;        /* world area of the shape; mesh: of all its triangles */
    u32 treePlace;   /* finite lights: 8 * node + slot of the light tree; dome: in lightCdf, the
                        number of its portals, or HDS_NONE */
    u32 flags;       /* and the group */
    u32 dataBase;    /* image: its texture; mesh: first triangle in lightTriangles */
    u32 dataSize[2]; /* image: cells of its distribution, columns, rows; mesh: number of triangles,
                        and in lightCdf its HdsMeshMotion, or HDS_NONE: it rests */
    u32 cdfBase;     /* in lightCdf: image: marginal [height + 1], then conditionals
                        [height][width + 1], of a dome then its texels (light/domeImage); mesh: by
                        weight [numTriangles + 1] */
    f32 strength;    /* luminance; finite: power / (4 pi); at infinity: irradiance */
    f32 center[3];   /* of a sphere that bounds the emitting shape, world */
    f32 boundRadius; /* HDS_LIGHT_FAR: at infinity */
    u32 shapingBase; /* in lightCdf: an HdsLightShaping, or HDS_NONE */
    u32 controlBase; /* in lightCdf: an HdsLightControls, or HDS_NONE */
    u32 lightLink;   /* in lightCdf: the bits of the link sets that it lights, or HDS_NONE: all */
    u32 shadowLink;  /* in lightCdf: the bits of the link sets that cast its shadows, or HDS_NONE */
} HdsLight;
HDS_ASSERT_SIZE(HdsLight, 192);

/* How the radiance of a light depends on the direction in which it leaves (UsdLuxShapingAPI). */
typedef struct {
    f32 axis[3];     /* unit, world: the middle of the beam */
    f32 cutoff;      /* radians off the axis, above which there is nothing */
    f32 side[3];     /* unit, world: azimuth 0 of the profile */
    f32 smoothStart; /* radians off the axis, up to which the cone dims nothing */
    f32 up[3];       /* unit, world: azimuth 90 degrees */
    f32 focus;       /* exponent */
    f32 focusTint[3];
    f32 peak;        /* bound on the luminance of the factor over all directions */
    u32 profileBase; /* in lightCdf: polar angles [numPolar] and azimuths [numAzimuths] in radians,
                        then factors [numAzimuths][numPolar]; HDS_NONE: no profile */
    u32 numPolar;    /* at least 2 */
    u32 numAzimuths; /* at least 2, from 0 to 2 pi */
    f32 angleScale;  /* of polar angles; 0: as they are */
    f32 profilePeak; /* the largest factor */
    u32 pad0[3];
} HdsLightShaping;
HDS_ASSERT_SIZE(HdsLightShaping, 96);

/* What is not physical about a light: its part in the lobes of surfaces, and its shadows. And how
 * it moves. */
typedef struct {
    f32 diffuse;        /* factor on what diffuse lobes receive */
    f32 specular;       /* and on what all others do */
    f32 shadowDistance; /* what is farther from the lit point casts no shadow; HDS_LIGHT_FAR: all do
                         */
    f32 shadowFade; /* 1 / length, up to that distance, over which shadows fade; 0: they do not */
    f32 shadowColor[3]; /* factor on what arrives in the shadow */
    f32 shadowGamma;    /* exponent of the fading, which is linear in the distance */
    u32 motionBase;     /* in lightCdf: an HdsLightKey for each of the equal steps in time */
    u32 motionSegments; /* keys after the first; 0: the light rests */
    u32 filterBase;     /* in lightCdf: the first HdsLightFilter */
    u32 numFilters;     /* 0: what leaves the light arrives */
    u32 cellBase; /* in lightCdf: an HdsLight for each of equal parts of the shutter's interval */
    u32 numCells; /* 0: its size and emission do not change */
    u32 pad0[2];
} HdsLightControls;
HDS_ASSERT_SIZE(HdsLightControls, 64);

/* HdsLightFilter.type */
#define HDS_FILTER_BARN 0u   /* an opening in the plane z = 0 of the filter */
#define HDS_FILTER_COOKIE 1u /* an image in that plane */
#define HDS_FILTER_RAMP 2u   /* by a distance of the lit point */
#define HDS_FILTER_ROD 3u    /* by whether the lit point is in a box */

/* HdsLightFilter.mode of a barn: what a way does that does not cross the plane of the opening */
#define HDS_FILTER_PASSES 0u /* it is left alone */
#define HDS_FILTER_CONE 1u   /* the straight line on through the light decides */
#define HDS_FILTER_BLOCKED 2u
/* of a cookie: what lies beyond its image */
#define HDS_FILTER_FILL 0u
#define HDS_FILTER_REPEAT 1u
#define HDS_FILTER_CLAMP 2u
/* of a ramp: which distance */
#define HDS_FILTER_TO_LIGHT 0u
#define HDS_FILTER_LINEAR 1u    /* along -z of the filter */
#define HDS_FILTER_SPHERICAL 2u /* from its origin */
#define HDS_FILTER_RADIAL 3u    /* from its z axis */

/* What a light filter leaves of a light (UsdLuxLightFilter). */
typedef struct {
    f32 filterFromWorld[12]; /* 3 rows of 4, relative to the scene centre */
    u32 type;
    u32 mode;
    f32 density;     /* part of the effect, 0: none */
    f32 inverted;    /* 1: inside and outside change places, else 0 */
    f32 low[3];      /* barn, rod: corners of the inner box; cookie: of its rect */
    f32 radius;      /* barn, rod: by which the box grows */
    f32 high[3];     /* likewise */
    f32 edge;        /* width of the border over which the effect ends */
    f32 inside[3];   /* factor: rod: in its box; cookie: tint */
    f32 begin;       /* ramp: distance of its first position */
    f32 outside[3];  /* cookie: beyond its image */
    f32 perLength;   /* ramp: 1 / its length */
    f32 texture[4];  /* cookie: image coordinates are xy * coordinate + zw, y from the top */
    u32 dataBase;    /* in lightCdf: cookie: texels rgb; ramp: positions and rgb, twice */
    u32 dataSize[2]; /* cookie: width, height; ramp: positions of either; 0: white */
    u32 pad0;
} HdsLightFilter;
HDS_ASSERT_SIZE(HdsLightFilter, 160);

/* Where a light is at a time: it is turned about the origin of its space, then moved. */
typedef struct {
    f32 turn[4]; /* unit quaternion: x, y, z, w */
    f32 offset[3];
    u32 pad0;
} HdsLightKey;
HDS_ASSERT_SIZE(HdsLightKey, 32);

/* How the triangles of a mesh light move: as its instance and its vertices do, so that light
 * samples lie on what rays meet. */
typedef struct {
    u32 matrixBase;     /* in lightCdf: worldFromObject, 3 rows of 4, at equal steps in time */
    u32 matrixSegments; /* keys after the first; 0: the instance rests */
    u32 edgesBase;     /* in lightCdf: p0, e1, e2 of the light's triangles in object space, for each
                          key after the first at equal steps in time */
    u32 edgesSegments; /* such keys; 0: vertices rest */
} HdsMeshMotion;
HDS_ASSERT_SIZE(HdsMeshMotion, 16);

/* A node of the light tree, the root first, with up to eight children in its slots. A child is a
 * light, or all lights below a node: a sphere that bounds them, around the mean of their centres by
 * strength. */
typedef struct {
    f32 centerX[8]; /* relative to the scene centre */
    f32 centerY[8];
    f32 centerZ[8];
    f32 radius[8];
    f32 axisX[8]; /* unit or zero: mean direction in which lights are seen that send by the cosine
                   */
    f32 axisY[8];
    f32 axisZ[8];
    f32 strength[8];       /* of what is sent alike in all directions */
    f32 cosineStrength[8]; /* of what is sent by the cosine about the axis: intensity there */
    u32 child[8];          /* node, HDS_LIGHT_LEAF | light, or HDS_NONE: the slot is empty */
    u32 place;             /* of the node: 8 * parent + slot; HDS_NONE: the root */
    u32 bothWays; /* one bit a slot: the light sends by the cosine in both directions of the axis */
    u32 inDetail; /* one bit a slot: the light is shaped, linked or moves, and has an estimate of
                     its own */
    u32 metByRays; /* one bit a slot: it holds lights that rays can meet: not points, not meshes */
} HdsLightNode;
HDS_ASSERT_SIZE(HdsLightNode, 336);
#define HDS_LIGHT_LEAF 0x80000000u

/* An emissive triangle in world space (relative to the scene centre); of a mesh that moves, in
 * object space when the shutter opens. */
typedef struct {
    f32 p0[3];
    u32 light; /* that it is part of */
    f32 e1[3];
    u32 primId; /* object triangle index: identity for shadow rays */
    f32 e2[3];
    f32 error; /* bound on the error of a point's position, world units */
} HdsLightTriangle;
HDS_ASSERT_SIZE(HdsLightTriangle, 48);
HDS_SHARED_END

/* The portals of a dome in lightCdf: their number; where in lightCdf the sums over the cells of its
 * image begin, if it has one, u32 [height + 1][width + 1]; then an HdsLight each, a rect of
 * radiance 1. */
#define HDS_DOME_IMAGE_SUMS 1u
#define HDS_DOME_PORTALS 2u /* where the first of them begins */

/* The lights of an emissive mesh in lightCdf, u32: the light of all its triangles, or HDS_NONE;
 * then only: the number of triangles, their primIds in ascending order, and for each of these its
 * index in lightTriangles. lightByEntry tells where that begins. */
#define HDS_MESH_LIGHT 0u
#define HDS_MESH_LIGHT_COUNT 1u
#define HDS_MESH_LIGHT_TRIANGLES 2u
#endif
