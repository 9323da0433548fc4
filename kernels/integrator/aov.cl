/* SPDX-License-Identifier: Apache-2.0
 * First-hit AOVs: one ray through each pixel's centre and the lens' centre; surfaces that let
 * everything pass are not there. From: the active queue after intersect. To: the AOV buffers, and
 * the next active queue for rays that passed. Explained in docs/film.md. */
#if HDS_FEATURE_VOLUMES
#include "integrator/aovVolume.clh"
#endif
#include "integrator/camera.clh"
#include "integrator/itemLoop.clh"
#if HDS_FEATURE_MEDIA_STACK
#include "integrator/aovMedia.clh"
#include "integrator/meshMedia.clh"
#endif
#include "integrator/passThrough.clh"
#include "integrator/pathState.clh"

/* Depth along the camera's -z, or the distance where the picture is on no film, and the [0,1] depth
 * of its clip range. */
float2 aov_depths(constant const HdsFrameParams* frame, float3 position) {
    float3 axis =
        -(float3)(frame->worldFromCamera[2], frame->worldFromCamera[6], frame->worldFromCamera[10]);
    float3 eye =
        (float3)(frame->worldFromCamera[3], frame->worldFromCamera[7], frame->worldFromCamera[11]);
    float z = vec_dot(position - eye, axis) / vec_dot(axis, axis);
#if HDS_FEATURE_CAMERA_LENS
    if (frame->projection != HDS_PROJECTION_FILM) {
        z = vec_length(position - eye) / vec_length(axis);
    }
#endif
    float n = frame->nearClip;
    float f = frame->farClip;
    float clip = (frame->flags & HDS_FRAME_ORTHOGRAPHIC) != 0u ? (z - n) / (f - n)
                                                               : (z - n) / (z * (1.0f - n / f));
    return (float2)(z, clip);
}

/* World direction in camera space, for a camera transform that may scale. */
float3 aov_toEye(constant const HdsFrameParams* frame, float3 v) {
    float3 x =
        (float3)(frame->worldFromCamera[0], frame->worldFromCamera[4], frame->worldFromCamera[8]);
    float3 y =
        (float3)(frame->worldFromCamera[1], frame->worldFromCamera[5], frame->worldFromCamera[9]);
    float3 z =
        (float3)(frame->worldFromCamera[2], frame->worldFromCamera[6], frame->worldFromCamera[10]);
    return vec_normalize((float3)(vec_dot(v, x), vec_dot(v, y), vec_dot(v, z)));
}

void aov_store1(global float* pixel, uint offset, float value) {
    if (offset != HDS_NONE) {
        pixel[offset] = value;
    }
}

void aov_store3(global float* pixel, uint offset, float3 value) {
    if (offset != HDS_NONE) {
        vstore3(value, 0, pixel + offset);
    }
}

void aov_store2(global float* pixel, uint offset, float2 value) {
    if (offset != HDS_NONE) {
        vstore2(value, 0, pixel + offset);
    }
}

void aov_storeId(global int* pixel, uint offset, int value) {
    if (offset != HDS_NONE) {
        pixel[offset] = value;
    }
}

/* A point in camera space, at a time in the shutter's interval. */
float3 aov_eyePoint(constant const HdsFrameParams* frame, float time, float3 position) {
    const HdsTransform pose = camera_pose(frame, time);
    const HdsAffine worldFromEye = affine_fromTransform(&pose);
    const HdsAffine eyeFromWorld = affine_inverse(&worldFromEye);
    return affine_point(&eyeFromWorld, position);
}

#if HDS_FEATURE_MOTION
/* Where a hit is seen at a time in the shutter's interval, in pixels. */
float2 aov_raster(constant const HdsFrameParams* frame, const HdsSceneView* scene,
                  const HdsHit* hit, float time) {
    HdsSurfaceHit surface;
    surfaceHit_load(scene, hit, time, &surface);
    const float3 eye = aov_eyePoint(frame, time, surface.point.position);
    float2 film = (frame->flags & HDS_FRAME_ORTHOGRAPHIC) != 0u ? eye.xy : eye.xy / -eye.z;
#if HDS_FEATURE_CAMERA_LENS
    if (frame->projection != HDS_PROJECTION_FILM) {
        film = lens_project(frame, eye);
    }
#endif
    const HdsLens lens = camera_lens(frame, time);
    return (float2)((film.x - lens.filmOrigin.x) / lens.filmStep.x,
                    (film.y - lens.filmOrigin.y) / lens.filmStep.y);
}

/* Pixels a frame that a hit moves by, over a part of the shutter's interval; over all of it where
 * the part is empty. */
float2 aov_motion(constant const HdsFrameParams* frame, const HdsSceneView* scene,
                  const HdsHit* hit, float from, float to, float shutterFrames) {
    const bool isEmpty = !(to > from);
    from = isEmpty ? 0.0f : from;
    to = isEmpty ? 1.0f : to;
    float2 way = aov_raster(frame, scene, hit, to) - aov_raster(frame, scene, hit, from);
#if HDS_FEATURE_CAMERA_LENS
    if (frame->projection == HDS_PROJECTION_LATLONG) { /* the short way round */
        const float turn = HDS_TWO_PI / frame->filmStep[0];
        way.x -= turn * rint(way.x / turn);
    }
#endif
    return way / ((to - from) * shutterFrames);
}
#endif

/* Writes how a hit moves on the picture to the next frame, and to the one before. */
void aov_storeMotion(constant const HdsFrameParams* frame, const HdsSceneView* scene,
                     const HdsHit* hit, HdsAovOffsets offsets, global float* pixel) {
    float2 forward = (float2)(0.0f);
    float2 backward = (float2)(0.0f);
#if HDS_FEATURE_MOTION
    if (offsets.shutterFrames > 0.0f &&
        (offsets.motionForward != HDS_NONE || offsets.motionBackward != HDS_NONE)) {
        forward = aov_motion(frame, scene, hit, frame->frameTime, 1.0f, offsets.shutterFrames);
        backward = -aov_motion(frame, scene, hit, 0.0f, frame->frameTime, offsets.shutterFrames);
    }
#endif
    aov_store2(pixel, offsets.motionForward, forward);
    aov_store2(pixel, offsets.motionBackward, backward);
}

void aov_storeMiss(HdsAovOffsets offsets, global float* pixel, global int* ids) {
    aov_store1(pixel, offsets.depth, 1.0f);
    aov_store1(pixel, offsets.cameraDepth, INFINITY);
    aov_store3(pixel, offsets.normal, (float3)(0.0f));
    aov_store3(pixel, offsets.normalEye, (float3)(0.0f));
    aov_store3(pixel, offsets.position, (float3)(0.0f));
    aov_store3(pixel, offsets.positionEye, (float3)(0.0f));
    aov_store1(pixel, offsets.facingRatio, 0.0f);
    aov_store2(pixel, offsets.motionForward, (float2)(0.0f));
    aov_store2(pixel, offsets.motionBackward, (float2)(0.0f));
    aov_store3(pixel, offsets.albedo, (float3)(0.0f));
    aov_store1(pixel, offsets.volumeDepth, INFINITY);
    aov_storeId(ids, offsets.primId, -1);
    aov_storeId(ids, offsets.instanceId, -1);
    aov_storeId(ids, offsets.elementId, -1);
    for (uint k = 0u; k < offsets.numPrimvars; ++k) {
        aov_store3(pixel, offsets.primvars + 3u * k, (float3)(0.0f));
    }
}

#if HDS_FEATURE_CLOSURES
/* Closures that a hit chooses from are evaluated at this many of the numbers that choose. */
#define HDS_AOV_CHANCES 16u

/* Mean albedo of the closures of a surface whose texels are there. One closure's keeps its bits. */
float3 aov_albedo(const HdsSceneView* scene, HdsSurfaceHit* surface, float3 viewer) {
    float3 first;
    float3 beyond = (float3)(0.0f); /* of the others, together */
    for (uint k = 0u; k < HDS_AOV_CHANCES; ++k) {
        surface->chance = ((float)k + 0.5f) / (float)HDS_AOV_CHANCES;
        HdsShadingPoint shading;
        HdsBsdf bsdf;
        surfaceMaterial_shade(scene, surface, viewer, &shading, &bsdf);
        const float3 albedo = bsdf_albedo(&bsdf, shading.wo);
        if (k == 0u) {
            first = albedo;
        } else {
            beyond += albedo - first;
        }
    }
    return first + beyond / (float)HDS_AOV_CHANCES;
}
#endif

void aov_storeHit(constant const HdsFrameParams* frame, const HdsSceneView* scene,
                  const HdsSurfaceHit* surface, float3 albedo, float3 viewer, HdsAovOffsets offsets,
                  global const uint* primvarSlots, global float* pixel, global int* ids) {
    float2 depths = aov_depths(frame, surface->point.position);
    float3 normal = surface->shadingNormal;
    if (!(vec_lengthSquared(normal) > 0.0f)) {
        normal = surface->point.normal;
    }
    aov_store1(pixel, offsets.depth, clamp(depths.y, 0.0f, 1.0f));
    aov_store1(pixel, offsets.cameraDepth, depths.x);
    aov_store3(pixel, offsets.normal, normal);
    aov_store3(pixel, offsets.normalEye, aov_toEye(frame, normal));
    aov_store3(pixel, offsets.position, surface->point.position + vload3(0, offsets.centre));
    if (offsets.positionEye != HDS_NONE) {
        aov_store3(pixel, offsets.positionEye,
                   aov_eyePoint(frame, frame->frameTime, surface->point.position));
    }
    aov_store1(pixel, offsets.facingRatio, fabs(vec_dot(vec_normalize(normal), viewer)));
    aov_store3(pixel, offsets.albedo, albedo);
    aov_store1(pixel, offsets.volumeDepth, INFINITY);
    aov_storeId(ids, offsets.primId, surfaceHit_prim(scene, surface)->primId);
    aov_storeId(ids, offsets.instanceId, surface->instanceId);
    aov_storeId(
        ids, offsets.elementId,
        (int)attributes_readInteger(surface->attributes, HDS_SLOT_FACE, surface->at.triangle, 0u));
    for (uint k = 0u; k < offsets.numPrimvars; ++k) {
        uint slot = primvarSlots[surface->prim * offsets.numPrimvars + k];
        float4 value = (float4)(0.0f);
        if (slot != HDS_NONE) {
            value = attributes_read(surface->attributes, slot, &surface->at, value);
        }
        aov_store3(pixel, offsets.primvars + 3u * k, value.xyz);
    }
}

#if HDS_FEATURE_VOLUMES || HDS_FEATURE_MEDIA_STACK
/* Where half of the light of slot i is lost, at t, unless that is nearer already. */
void aov_storeHalf(constant const HdsFrameParams* frame, HdsPaths paths, uint i, float t,
                   HdsAovOffsets offsets, global float* pixel) {
    if (offsets.volumeDepth != HDS_NONE && t < INFINITY) {
        const float3 at =
            vec_mulAdd(t, path_load_direction(paths, i).xyz, path_load_origin(paths, i).xyz);
        pixel[offsets.volumeDepth] = fmin(pixel[offsets.volumeDepth], aov_depths(frame, at).x);
    }
}
#endif

#if HDS_FEATURE_VOLUMES
/* Adds to what is written for slot i what volumes before its first hit are. \param t of that. When
 * texels are missing nothing is added, and the slot comes again. */
void aov_addVolumes(constant const HdsFrameParams* frame, const HdsSceneView* scene, HdsPaths paths,
                    uint i, float t, HdsAovOffsets offsets, global float* pixel) {
    if (offsets.albedo == HDS_NONE && offsets.volumeDepth == HDS_NONE) {
        return;
    }
    const float4 origin = path_load_origin(paths, i);
    const float4 direction = path_load_direction(paths, i);
    bool isMissing = false;
    const HdsAovVolumes volumes =
        aovVolume_cross(&scene->volumes, &scene->textures, origin.xyz, direction.xyz, origin.w,
                        fmin(t, direction.w), &isMissing);
    if (isMissing) {
        surfaceMaterial_waitForTexels(scene, i);
        return;
    }
    if (offsets.albedo != HDS_NONE) {
        const float3 behind = vload3(0, pixel + offsets.albedo);
        vstore3(fma(volumes.left, behind, volumes.albedo), 0, pixel + offsets.albedo);
    }
    aov_storeHalf(frame, paths, i, volumes.t, offsets, pixel);
}
#endif

#if HDS_FEATURE_MEDIA_STACK
/* Adds to what is written for slot i what media of meshes before its first hit are. \param t of
 * that. */
void aov_addMedia(constant const HdsFrameParams* frame, const HdsSceneView* scene, HdsPaths paths,
                  uint i, float t, HdsAovOffsets offsets, global float* pixel) {
    const HdsAovMedia media =
        aovMedia_upTo(scene->meshMedia, paths, i, fmin(t, path_load_direction(paths, i).w));
    if (offsets.albedo != HDS_NONE) {
        const float3 behind = vload3(0, pixel + offsets.albedo);
        vstore3(fma(media.left, behind, media.albedo), 0, pixel + offsets.albedo);
    }
    aov_storeHalf(frame, paths, i, media.t, offsets, pixel);
}

/* Whether the ray of slot i looks for the media that the camera is in. */
bool aov_isProbe(HdsPaths paths, uint i) {
    return (path_load_medium(paths, i).x & HDS_PATH_MEDIUM_MASK) == HDS_MEDIUM_PROBE;
}

/* Begins the camera ray of slot i, which has waited in the fields of the shadow ray. */
void aov_beginCamera(HdsPaths paths, uint i, global uint* nextQueue,
                     volatile global uint* counters) {
    path_store_origin(paths, i, path_load_shadowOrigin(paths, i));
    path_store_direction(paths, i, path_load_shadowDirection(paths, i));
    path_store_medium(paths, i, (uint4)(0u));
    path_store_status(paths, i, (uint4)(path_load_status(paths, i).xy, 0u, 0u));
    path_store_after(paths, i, (uint4)(0u));
    queue_append(nextQueue, &counters[HDS_COUNTER_ACTIVE], i);
}
#endif

#if HDS_FEATURE_CUTOUT
/* The ray of slot i goes on behind a surface, unless it has passed too many. */
bool aov_pass(const HdsSceneView* scene, const HdsHit* hit, const HdsSurfaceHit* surface,
              HdsPaths paths, uint i, global uint* nextQueue, volatile global uint* counters) {
    uint4 status = path_load_status(paths, i);
    if ((status.z >> HDS_PATH_PASS_SHIFT) >= HDS_MAX_PASSES) {
        return false;
    }
#if HDS_FEATURE_MEDIA_STACK
    if (!aov_isProbe(paths, i)) {
        aovMedia_store(aovMedia_upTo(scene->meshMedia, paths, i, hit->t), paths, i);
    }
    meshMedia_pass(scene, surface, path_load_direction(paths, i).xyz, paths, i);
#endif
    status.z += HDS_PATH_ONE_PASS;
    path_store_status(paths, i, status);
    path_store_after(paths, i, passThrough_key(hit, surface));
    queue_append(nextQueue, &counters[HDS_COUNTER_ACTIVE], i);
    return true;
}
#endif

/* Writes the first hit of slot i, or appends it to what goes on or waits. */
void aov_store(constant const HdsFrameParams* frame, const HdsSceneView* scene, HdsPaths paths,
               uint i, global uint* waitQueue, global uint* nextQueue,
               volatile global uint* counters, global float* floats, global int* ints,
               HdsAovOffsets offsets, global const uint* primvarSlots) {
#if HDS_WAIT_LISTS
    if (path_loadWaits(paths, i) != 0u) {
        return;
    }
#endif
    HdsHit hit = path_loadHit(paths, i);
    const uint4 status = path_load_status(paths, i);
    global float* pixel = floats + (size_t)status.x * offsets.floatStride;
    global int* ids = ints + (size_t)status.x * offsets.intStride;
#if HDS_FEATURE_MEDIA_STACK
    if (hit.chunk == HDS_NONE && aov_isProbe(paths, i)) {
        aov_beginCamera(paths, i, nextQueue, counters);
        return;
    }
#endif
    if (hit.chunk == HDS_NONE) {
        aov_storeMiss(offsets, pixel, ids);
#if HDS_FEATURE_MEDIA_STACK
        aov_addMedia(frame, scene, paths, i, INFINITY, offsets, pixel);
#endif
#if HDS_FEATURE_VOLUMES
        aov_addVolumes(frame, scene, paths, i, INFINITY, offsets, pixel);
#endif
        return;
    }
    if (surfaceHit_waits(scene, &hit, waitQueue, counters, HDS_COUNTER_WAITING_HITS, i)) {
        return;
    }
    HdsSurfaceHit surface;
    HdsShadingPoint shading;
    HdsBsdf bsdf;
    surfaceHit_load(scene, &hit, path_time(paths, i), &surface);
#if HDS_FEATURE_SPLATS
    if (surface.splat.w > 0.0f) {
        surface.point.position =
            vec_mulAdd(hit.t, path_load_direction(paths, i).xyz, path_load_origin(paths, i).xyz);
    }
#endif
#if HDS_FEATURE_MEDIA_STACK
    if (aov_isProbe(paths, i)) {
        if (!aov_pass(scene, &hit, &surface, paths, i, nextQueue, counters)) {
            aov_beginCamera(paths, i, nextQueue, counters);
        }
        return;
    }
    const HdsMediaStack stack = mediaStack_load(paths, i);
    const bool isThere = meshMedia_meet(scene, &stack, path_load_direction(paths, i).xyz, &surface);
#elif HDS_FEATURE_CUTOUT
    const bool isThere = true;
#endif
#if HDS_FEATURE_TEXTURES
    HdsRayCones cones;
    cones.pair = path_load_cones(paths, i);
    surfaceHit_setFootprint(cones_atHit(cones, hit.t, true), -path_load_direction(paths, i).xyz,
                            &surface);
    surface.choice = (HdsTexelChoice){0.0f, 8u};
#endif
    if (!surfaceMaterial_shade(scene, &surface, -path_load_direction(paths, i).xyz, &shading,
                               &bsdf)) {
        surfaceMaterial_waitForTexels(scene, i);
        return;
    }
#if HDS_FEATURE_CUTOUT
    const bool isPassed = !isThere ||
                          vec_minComponent(bsdf_passThrough(&bsdf, shading.wo.z)) >= 1.0f ||
                          passThrough_isCulled(scene, &surface, path_load_direction(paths, i).xyz);
    if (isPassed && aov_pass(scene, &hit, &surface, paths, i, nextQueue, counters)) {
        return;
    }
#endif
    const float3 viewer = -path_load_direction(paths, i).xyz;
#if HDS_FEATURE_CLOSURES
    const float3 albedo = aov_albedo(scene, &surface, viewer);
#else
    const float3 albedo = bsdf_albedo(&bsdf, shading.wo);
#endif
    aov_storeHit(frame, scene, &surface, albedo, viewer, offsets, primvarSlots, pixel, ids);
    aov_storeMotion(frame, scene, &hit, offsets, pixel);
#if HDS_FEATURE_MEDIA_STACK
    aov_addMedia(frame, scene, paths, i, hit.t, offsets, pixel);
#endif
#if HDS_FEATURE_VOLUMES
    aov_addVolumes(frame, scene, paths, i, hit.t, offsets, pixel);
#endif
}

/* Global size: count items, HDS_ITEMS_PER_WORK_ITEM for each work-item. */
kernel void aov_firstHit(HDS_SCENE_ARGS, constant const HdsFrameParams* frame, global uchar* state,
                         uint numSlots, global const uint* restrict queue, uint count,
                         global uint* restrict waitQueue, global uint* restrict nextQueue,
                         volatile global uint* counters, global float* floats, global int* ints,
                         HdsAovOffsets offsets, global const uint* primvarSlots) {
    HdsPaths paths = {state, numSlots};
    HDS_SCENE_VIEW(scene);
    HDS_FOR_ITEMS(item, count) {
        aov_store(frame, &scene, paths, queue[item], waitQueue, nextQueue, counters, floats, ints,
                  offsets, primvarSlots);
    }
    HDS_SCENE_END(scene);
}
