/* SPDX-License-Identifier: Apache-2.0
 * Shadow rays. shadow_cast adds what arrives unhindered; a ray that meets a cut-out surface becomes
 * a candidate, which shadow_pass, or where nothing streams shadow_cast itself, dims by the
 * transparency there and sends on. From: the shadow queue. To: path radiance, or the candidate
 * queue and back; while geometry streams also to the queues of what waits. Explained in
 * docs/wavefront.md. */
#include "integrator/itemLoop.clh"
#include "integrator/lightPaths.clh"
#include "integrator/sceneArgs.clh"
#include "integrator/trace.clh"
#include "shared/launchConditions.h"
/* Drivers compile all functions of a program, also those that no kernel calls. */
#if HDS_FEATURE_CUTOUT
#include "integrator/passThrough.clh"
#endif
#if HDS_FEATURE_VOLUMES
#include "integrator/volumeShadow.clh"
#endif
#if HDS_FEATURE_MEDIA_STACK
#include "integrator/meshMedia.clh"
#endif

#if HDS_FEATURE_GLASS_SHADOWS
#include "shading/medium.clh"
#endif

/* What media leave of the light of the shadow ray of slot i behind the last boundary that it has
 * crossed, up to t. */
float3 shadow_leftOfMedia(const HdsSceneView* scene, HdsPaths paths, uint i, float t) {
    float3 left = (float3)(1.0f);
#if HDS_FEATURE_MEDIA_STACK
    const HdsMediaStack stack = mediaStack_loadShadow(paths, i);
    left *= mediaStack_shadowLeft(scene->meshMedia, &stack, t);
#endif
#if HDS_FEATURE_GLASS_SHADOWS
    const float4 glass = path_load_shadowGlass(paths, i);
    left *= medium_transmittance(glass.xyz, fmax(t - glass.w, 0.0f));
#endif
    return left;
}

/* Adds light that arrives to what the path has gathered. */
void shadow_addLight(HdsPaths paths, uint i, float3 light) {
    float4 radiance = path_load_radiance(paths, i);
    radiance.xyz += light;
    path_store_radiance(paths, i, radiance);
#if HDS_LIGHT_PATH_STATE
    lightPaths_addShadow(paths, i, light);
#endif
}

void shadow_addRadiance(const HdsSceneView* scene, HdsPaths paths, uint i) {
    const float3 left = shadow_leftOfMedia(scene, paths, i, path_load_shadowOrigin(paths, i).w);
    shadow_addLight(paths, i, path_load_shadowRadiance(paths, i).xyz * left);
}

/* Adds what arrives though it is blocked: a share of the shadow ray's radiance. \param t distance
 * of what blocks it; only candidates have one, and all that casts fading shadows is one. */
void shadow_addBlocked(const HdsSceneView* scene, HdsPaths paths, uint i, float3 share, float t) {
#if HDS_FEATURE_LIGHT_CONTROLS
    global const HdsLightControls* controls =
        light_controls(&scene->lights, path_load_shadowLight(paths, i).x);
    if (controls != 0) {
        shadow_addLight(
            paths, i,
            path_load_shadowRadiance(paths, i).xyz * share * light_throughShadow(controls, t) *
                shadow_leftOfMedia(scene, paths, i, path_load_shadowOrigin(paths, i).w));
    }
#endif
}

/* Whether what arrives is known only where the ray meets its light (HDS_LIGHT_TEXTURED_EMISSION).
 */
bool shadow_needsLight(const HdsSceneView* scene, HdsPaths paths, uint i) {
#if HDS_FEATURE_TEXTURED_EMISSION
    const uint light = path_load_shadowLight(paths, i).x;
    return (scene->lights.lights[light].flags & HDS_LIGHT_TEXTURED_EMISSION) != 0u;
#else
    return false;
#endif
}

/* A shadow ray is over: its slot may be shaded when it has waited for that. Shadow rays of a first
 * launch have not, but for those that passed cut-out surfaces. */
void shadow_end(HdsPaths paths, uint i, global uint* readyQueue, volatile global uint* counters) {
#if HDS_WAIT_LISTS
    if ((path_loadWaits(paths, i) & HDS_PATH_SHADOW_WAITS) != 0u) {
        path_endWait(paths, i, HDS_PATH_SHADOW_WAITS, readyQueue, counters);
    }
#endif
}

/* A ray that nothing opaque blocks arrives, or has a candidate, which is kept. One that passes its
 * light, which happens at edges by rounding, brings nothing. \return whether it has one. */
bool shadow_arrive(const HdsSceneView* scene, HdsPaths paths, uint i, const HdsHit* candidate,
                   global uint* readyQueue, volatile global uint* counters) {
#if HDS_FEATURE_CUTOUT
    bool passes = candidate->chunk != HDS_NONE;
#if HDS_FEATURE_MEDIA_STACK
    const float bound = as_float(path_load_shadowMediaHigh(paths, i).w);
    if (!passes && bound > 0.0f && bound < path_load_shadowOrigin(paths, i).w) {
        shadow_end(paths, i, readyQueue, counters); /* it ends in the medium that it begins in */
        return false;
    }
#endif
#if HDS_FEATURE_VOLUMES
    passes =
        passes || (!shadow_needsLight(scene, paths, i) && volumeShadow_isAhead(scene, paths, i));
#endif
    if (passes) {
        path_storeCandidate(paths, i, candidate);
        return true;
    }
#endif
    if (!shadow_needsLight(scene, paths, i)) {
        shadow_addRadiance(scene, paths, i);
    }
    shadow_end(paths, i, readyQueue, counters);
    return false;
}

#if HDS_FEATURE_VOLUMES && HDS_FEATURE_LIGHT_CONTROLS
/* t of the candidate of a ray that something opaque blocks, of whose light volumes have to leave
 * what arrives all the same. */
#define HDS_SHADOW_BLOCKED_T (-1.0f)

/* Whether light of the shadow ray of slot i arrives though it is blocked: all of it is dimmed by
 * the volumes on the whole way before anything is taken of it. */
bool shadow_isSeenThrough(const HdsSceneView* scene, HdsPaths paths, uint i) {
    global const HdsLightControls* controls =
        light_controls(&scene->lights, path_load_shadowLight(paths, i).x);
    return controls != 0 && light_isSeenThroughShadow(controls);
}
#endif

/* A ray that something opaque blocks. \return whether it has a candidate: it goes on to volumes. */
bool shadow_block(const HdsSceneView* scene, HdsPaths paths, uint i, global uint* readyQueue,
                  volatile global uint* counters) {
#if HDS_FEATURE_VOLUMES && HDS_FEATURE_LIGHT_CONTROLS
    if (shadow_isSeenThrough(scene, paths, i) && volumeShadow_isAhead(scene, paths, i)) {
        HdsHit blocked = hit_none();
        blocked.t = HDS_SHADOW_BLOCKED_T;
        path_storeCandidate(paths, i, &blocked);
        return true;
    }
#endif
    shadow_addBlocked(scene, paths, i, (float3)(1.0f), 0.0f);
    shadow_end(paths, i, readyQueue, counters);
    return false;
}

/* Ends a shadow ray of which it is known whether something opaque blocks it. \param found
 * HDS_RAY_*. \return whether it has a candidate. */
bool shadow_decide(const HdsSceneView* scene, HdsPaths paths, uint i, uint found,
                   const HdsHit* candidate, global uint* readyQueue,
                   volatile global uint* counters) {
    if (found == HDS_RAY_DECIDED) {
        return shadow_arrive(scene, paths, i, candidate, readyQueue, counters);
    }
    return found == HDS_RAY_BLOCKED && shadow_block(scene, paths, i, readyQueue, counters);
}

#if HDS_FEATURE_CUTOUT
#if HDS_FEATURE_GLASS_SHADOWS
/* The share that passes glass straight, dimmed by what is before it. \return as
 * surfaceMaterial_shade.
 */
bool shadow_passGlass(const HdsSceneView* scene, HdsPaths paths, uint i,
                      const HdsSurfaceHit* surface, float3 viewer, float t, float3* share) {
    HdsShadingPoint shading;
    HdsBsdf bsdf;
    if (!surfaceMaterial_shade(scene, surface, viewer, &shading, &bsdf)) {
        return false;
    }
    global const HdsMaterial* material = surfaceMaterial_of(scene, surface);
    *share = bsdf_passThrough(&bsdf, shading.wo.z);
    if (!bsdf_isGlass(&bsdf, material->flags)) {
        return true;
    }
    *share += layered_straight(&bsdf.layered, shading.wo);
    float4 glass = path_load_shadowGlass(paths, i);
#if HDS_FEATURE_MEDIA_STACK
    bsdf.extinction = material->meshMedium != 0u ? (float3)(0.0f) : bsdf.extinction;
#endif
    const bool isBack = vec_dot(surface->point.normal, viewer) < 0.0f;
    /* Who begins inside of what only absorbs learns of it here. */
    const float3 before = isBack ? bsdf.extinction : glass.xyz;
    *share *= medium_transmittance(before, fmax(t - glass.w, 0.0f));
    glass.xyz = isBack ? (float3)(0.0f) : bsdf.extinction;
    glass.w = t;
    path_store_shadowGlass(paths, i, glass);
    return true;
}
#endif

/* What a candidate at t lets pass: all where it casts no shadow of the light. \return false when
 * texels are missing. */
bool shadow_share(const HdsSceneView* scene, HdsPaths paths, uint i, HdsSurfaceHit* surface,
                  float3 viewer, float t, float3* share) {
#if HDS_FEATURE_LIGHT_CONTROLS
    const uint light = path_load_shadowLight(paths, i).x;
    if (!light_isLinked(&scene->lights, scene->lights.lights[light].shadowLink,
                        surfaceHit_linkSet(scene, surface))) {
        *share = (float3)(1.0f);
        return true;
    }
#endif
#if HDS_FEATURE_MEDIA_STACK
    const HdsMediaStack stack = mediaStack_loadShadow(paths, i);
    if (!meshMedia_meet(scene, &stack, -viewer, surface)) {
        *share = (float3)(1.0f);
        return true;
    }
#endif
#if HDS_FEATURE_GLASS_SHADOWS
    if ((surfaceMaterial_of(scene, surface)->flags & HDS_MATERIAL_GLASS) != 0u) {
        return shadow_passGlass(scene, paths, i, surface, viewer, t, share);
    }
#endif
    return passThrough_share(scene, surface, viewer, share);
}

#if HDS_FEATURE_MEDIA_STACK
/* The shadow ray of slot i goes on behind the surface at t, which may be the boundary of a medium.
 * \return what the medium before that has left of its light. */
float3 shadow_crossMedium(const HdsSceneView* scene, HdsPaths paths, uint i,
                          const HdsSurfaceHit* surface, float3 direction, float t) {
    const uint number = meshMedia_number(scene, surface);
    if (number == 0u) {
        return (float3)(1.0f);
    }
    HdsMediaStack stack = mediaStack_loadShadow(paths, i);
    const float3 left = mediaStack_shadowLeft(scene->meshMedia, &stack, t);
    mediaStack_cross(&stack, number, meshMedia_enters(surface, direction));
    stack.begin = t;
    stack.end = INFINITY;
    mediaStack_storeShadow(&stack, paths, i);
    return left;
}
#endif

#if HDS_FEATURE_TEXTURED_EMISSION
/* Whether the candidate is the triangle that the shadow ray goes to. */
bool shadow_isTarget(const HdsSceneView* scene, HdsPaths paths, uint i,
                     const HdsSurfaceHit* surface) {
    const uint4 target = path_load_shadowLight(paths, i);
    float pdfArea;
    return (scene->lights.lights[target.x].flags & HDS_LIGHT_TEXTURED_EMISSION) != 0u &&
           surface->primId == target.y &&
           surfaceHit_light(scene, surface, path_time(paths, i), &pdfArea) == target.x;
}

/* Adds what the light at the end of the shadow ray emits. \param t of the candidate. \return false
 * when texels are missing. */
bool shadow_addTarget(const HdsSceneView* scene, HdsPaths paths, uint i,
                      const HdsSurfaceHit* surface, float3 viewer, float t) {
#if HDS_FEATURE_VOLUMES
    if (!volumeShadow_dim(scene, paths, i, t)) {
        return false;
    }
#endif
    HdsShadingPoint shading;
    HdsBsdf bsdf;
    if (!surfaceMaterial_shade(scene, surface, viewer, &shading, &bsdf)) {
        return false;
    }
    const float3 left = shadow_leftOfMedia(scene, paths, i, t);
    shadow_addLight(paths, i, path_load_shadowRadiance(paths, i).xyz * bsdf_emission(&bsdf) * left);
    return true;
}
#endif

#if HDS_FEATURE_VOLUMES
/* Ends a shadow ray that nothing but volumes is in the way of, or that is blocked for good.
 * \param t of the candidate. */
void shadow_passVolumes(const HdsSceneView* scene, HdsPaths paths, uint i, float t,
                        global uint* readyQueue, volatile global uint* counters) {
    if (!volumeShadow_dim(scene, paths, i, path_load_shadowOrigin(paths, i).w)) {
        surfaceMaterial_waitForTexels(scene, i);
        return;
    }
#if HDS_FEATURE_LIGHT_CONTROLS
    if (t == HDS_SHADOW_BLOCKED_T) {
        shadow_addBlocked(scene, paths, i, (float3)(1.0f), 0.0f);
        shadow_end(paths, i, readyQueue, counters);
        return;
    }
#endif
    shadow_addRadiance(scene, paths, i);
    shadow_end(paths, i, readyQueue, counters);
}
#endif

/* Dims the shadow ray of slot i by its candidate. \return whether it goes on behind that. */
bool shadow_passCandidate(const HdsSceneView* scene, HdsPaths paths, uint i, global uint* waitQueue,
                          global uint* readyQueue, volatile global uint* counters) {
    HdsHit hit = path_loadCandidate(paths, i);
#if HDS_FEATURE_VOLUMES
    if (hit.chunk == HDS_NONE) {
        shadow_passVolumes(scene, paths, i, hit.t, readyQueue, counters);
        return false;
    }
#endif
    if (surfaceHit_waits(scene, &hit, waitQueue, counters, HDS_COUNTER_WAITING_CANDIDATES, i)) {
#if HDS_WAIT_LISTS
        path_storeWaits(paths, i, path_loadWaits(paths, i) | HDS_PATH_SHADOW_WAITS);
#endif
        return false;
    }
#if HDS_FEATURE_VOLUMES && HDS_FEATURE_LIGHT_CONTROLS
    if (shadow_isSeenThrough(scene, paths, i) &&
        !volumeShadow_dim(scene, paths, i, path_load_shadowOrigin(paths, i).w)) {
        surfaceMaterial_waitForTexels(scene, i);
        return false;
    }
#endif
    float4 direction = path_load_shadowDirection(paths, i);
    HdsSurfaceHit surface;
    surfaceHit_load(scene, &hit, path_time(paths, i), &surface);
    float4 radiance = path_load_shadowRadiance(paths, i);
#if HDS_FEATURE_TEXTURES
    surfaceHit_setFootprint(cones_atHit(cones_unpack(radiance.w), hit.t, false), -direction.xyz,
                            &surface);
    surface.choice = (HdsTexelChoice){0.0f, 8u};
#endif
#if HDS_FEATURE_TEXTURED_EMISSION
    if (shadow_isTarget(scene, paths, i, &surface)) {
        if (shadow_addTarget(scene, paths, i, &surface, -direction.xyz, hit.t)) {
            shadow_end(paths, i, readyQueue, counters);
        } else {
            surfaceMaterial_waitForTexels(scene, i);
        }
        return false;
    }
#endif
    float3 share;
    if (!shadow_share(scene, paths, i, &surface, -direction.xyz, hit.t, &share)) {
        surfaceMaterial_waitForTexels(scene, i);
        return false;
    }
    shadow_addBlocked(scene, paths, i, (float3)(1.0f) - share, hit.t);
    float3 left = radiance.xyz * share;
#if HDS_FEATURE_MEDIA_STACK
    left *= shadow_crossMedium(scene, paths, i, &surface, direction.xyz, hit.t);
#endif
    if (!(vec_maxComponent(left) > 0.0f)) {
        shadow_end(paths, i, readyQueue, counters);
        return false;
    }
    direction.w += 1.0f;
    if (direction.w >= (float)HDS_MAX_PASSES) {
        atomic_inc(&counters[HDS_COUNTER_PASSES]);
        shadow_end(paths, i, readyQueue, counters);
        return false;
    }
    path_store_shadowRadiance(paths, i, (float4)(left, radiance.w));
    path_store_shadowDirection(paths, i, direction);
    path_store_shadowAfter(paths, i, passThrough_key(&hit, &surface));
    return true;
}
#endif

/* Global size: count items, HDS_ITEMS_PER_WORK_ITEM for each work-item. Appends candidates (only
 * with cut-outs) and, while geometry streams, rays that wait for a chunk and slots that are ready.
 * Where candidates are passed at once it counts the rays that go on behind them. */
kernel void shadow_cast(HDS_SCENE_ARGS, global uchar* state, uint numSlots,
                        global const uint* restrict queue, uint count,
                        global uint* restrict waitQueue, global uint* restrict candidateQueue,
                        global uint* restrict readyQueue, volatile global uint* counters) {
    HdsPaths paths = {state, numSlots};
    HDS_SCENE_VIEW(scene);
#if HDS_PASSES_SHADOWS_AT_ONCE
    uint numPasses = 0u;
#else
    HdsItemList candidates;
    candidates.count = 0u;
#endif
    HDS_FOR_ITEMS(item, count) {
        uint i = queue[item];
        HdsHit candidate;
#if HDS_PASSES_SHADOWS_AT_ONCE
        while (shadow_decide(
                   &scene, paths, i,
                   trace_occluded(&scene.geometry, paths, i, waitQueue, counters, &candidate),
                   &candidate, readyQueue, counters) &&
               shadow_passCandidate(&scene, paths, i, waitQueue, readyQueue, counters)) {
            ++numPasses;
        }
#else
        const uint found =
            trace_occluded(&scene.geometry, paths, i, waitQueue, counters, &candidate);
        if (shadow_decide(&scene, paths, i, found, &candidate, readyQueue, counters)) {
            items_append(&candidates, i);
        }
#endif
    }
    HDS_SCENE_END(scene);
#if HDS_PASSES_SHADOWS_AT_ONCE
    if (numPasses > 0u) {
        atomic_add(&counters[HDS_COUNTER_PASSED], numPasses);
    }
#else
    items_flush(&candidates, candidateQueue, &counters[HDS_COUNTER_SHADOW]);
#endif
}

#if HDS_FEATURE_STREAMING
/* Global size: count items, HDS_ITEMS_PER_WORK_ITEM for each work-item. Goes on with shadow rays
 * that have waited. Appends as shadow_cast. */
kernel void shadow_resume(HDS_SCENE_ARGS, global uchar* state, uint numSlots,
                          global const uint* restrict queue, uint count,
                          global uint* restrict waitQueue, global uint* restrict candidateQueue,
                          global uint* restrict readyQueue, volatile global uint* counters) {
    HdsPaths paths = {state, numSlots};
    HDS_SCENE_VIEW(scene);
    HdsItemList candidates;
    candidates.count = 0u;
    HDS_FOR_ITEMS(item, count) {
#if HDS_WAIT_LISTS
        if (item + HDS_FETCH_AHEAD < itemsEnd) {
            trace_fetchOccluded(paths, queue[item + HDS_FETCH_AHEAD]);
        }
#endif
        uint i = queue[item];
        HdsHit candidate;
        const uint found =
            trace_resumeOccluded(&scene.geometry, paths, i, waitQueue, counters, &candidate);
        if (shadow_decide(&scene, paths, i, found, &candidate, readyQueue, counters)) {
            items_append(&candidates, i);
        }
    }
    items_flush(&candidates, candidateQueue, &counters[HDS_COUNTER_SHADOW]);
}
#endif

#if HDS_FEATURE_CUTOUT && !HDS_PASSES_SHADOWS_AT_ONCE
/* Global size: count items, HDS_ITEMS_PER_WORK_ITEM for each work-item. Appends rays of which
 * something is left and, while geometry streams, candidates that wait for their pages and slots
 * that are ready. */
kernel void shadow_pass(HDS_SCENE_ARGS, global uchar* state, uint numSlots,
                        global const uint* restrict candidateQueue, uint count,
                        global uint* restrict waitQueue, global uint* restrict queue,
                        global uint* restrict readyQueue, volatile global uint* counters) {
    HdsPaths paths = {state, numSlots};
    HDS_SCENE_VIEW(scene);
    HdsItemList passed;
    passed.count = 0u;
    HDS_FOR_ITEMS(item, count) {
        const uint i = candidateQueue[item];
        if (shadow_passCandidate(&scene, paths, i, waitQueue, readyQueue, counters)) {
            items_append(&passed, i);
        }
    }
    HDS_SCENE_END(scene);
    items_flush(&passed, queue, &counters[HDS_COUNTER_SHADOW]);
}
#endif
