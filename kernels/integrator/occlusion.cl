/* SPDX-License-Identifier: Apache-2.0
 * Ambient occlusion: from what a camera ray meets one ray goes on, by the cosine to the shading
 * normal, and the path gathers 1 where that meets nothing. Surfaces let rays pass by chance in
 * proportion to their transparency. From: the active queue after intersect. To: path radiance, or
 * the next active queue. Explained in docs/film.md. */
#include "integrator/itemLoop.clh"
#include "integrator/passThrough.clh"
#include "integrator/pathState.clh"
#include "integrator/pixelSampler.clh"
#include "sample/warp.clh"

#if HDS_FEATURE_CUTOUT
/* Lets the ray of slot i go on behind a surface, by chance. \return whether it passes. */
bool occlusion_pass(const HdsSceneView* scene, const HdsHit* hit, const HdsSurfaceHit* surface,
                    HdsSampler sampler, float transparency, HdsPaths paths, uint i) {
    uint4 status = path_load_status(paths, i);
    const uint depth = status.z & HDS_PATH_DEPTH_MASK;
    if (!(sampler_get1(sampler, HDS_DIM_BOUNCE(depth, HDS_DIM_OPACITY)) < transparency) ||
        (status.z >> HDS_PATH_PASS_SHIFT) >= HDS_MAX_PASSES) {
        return false;
    }
    status.z += HDS_PATH_ONE_PASS;
    status.w = passThrough_id(status.w, hit, surface);
    path_store_status(paths, i, status);
    path_store_after(paths, i, passThrough_key(hit, surface));
    return true;
}
#endif

/* Sends the ray of slot i on from what it has met. \return false when it would go below the
 * surface: that is occluded. */
bool occlusion_start(const HdsSurfaceHit* surface, const HdsShadingPoint* shading,
                     HdsSampler sampler, float distance, HdsPaths paths, uint i) {
    const float2 u = sampler_get2(sampler, HDS_DIM_BOUNCE(0u, HDS_DIM_LOBE));
    const float3 direction =
        vec_normalize(frame_toWorld(&shading->frame, warp_cosineHemisphere(u)));
    if (!(vec_dot(direction, shading->geomNormal) > 0.0f)) {
        return false;
    }
    uint4 status = path_load_status(paths, i);
    status.z = 1u | (HDS_RAY_KIND_DIFFUSE << HDS_PATH_KIND_SHIFT);
    path_store_origin(paths, i,
                      (float4)(offset_origin(&surface->point, shading->geomNormal), 0.0f));
    path_store_direction(paths, i, (float4)(direction, distance));
    path_store_status(paths, i, status);
#if HDS_FEATURE_CUTOUT
    path_store_after(paths, i, (uint4)(0u));
#endif
    return true;
}

/* Takes slot i a step further, or appends it to what waits. \param distance beyond which nothing
 * occludes. */
void occlusion_step(constant const HdsFrameParams* frame, const HdsSceneView* scene, HdsPaths paths,
                    uint i, float distance, global uint* waitQueue, global uint* nextQueue,
                    volatile global uint* counters) {
#if HDS_WAIT_LISTS
    if (path_loadWaits(paths, i) != 0u) {
        return;
    }
#endif
    const HdsHit hit = path_loadHit(paths, i);
    const uint4 status = path_load_status(paths, i);
    const bool isCamera = (status.z & HDS_PATH_DEPTH_MASK) == 0u;
    if (hit.chunk == HDS_NONE) {
        if (!isCamera) {
            path_store_radiance(paths, i, (float4)(1.0f));
        }
        return;
    }
    if (surfaceHit_waits(scene, &hit, waitQueue, counters, HDS_COUNTER_WAITING_HITS, i)) {
        return;
    }
    const float3 viewer = -path_load_direction(paths, i).xyz;
    HdsSurfaceHit surface;
    HdsShadingPoint shading;
    HdsBsdf bsdf;
    surfaceHit_load(scene, &hit, path_time(paths, i), &surface);
    if (!isCamera && (surfaceMaterial_of(scene, &surface)->flags & HDS_MATERIAL_CUTOUT) == 0u) {
        return; /* occluded, whatever its textures */
    }
#if HDS_FEATURE_TEXTURES
    HdsRayCones cones;
    cones.pair = path_load_cones(paths, i);
    surfaceHit_setFootprint(cones_atHit(cones, hit.t, isCamera), viewer, &surface);
    surface.choice = (HdsTexelChoice){0.0f, 8u};
#endif
    if (!surfaceMaterial_shade(scene, &surface, viewer, &shading, &bsdf)) {
        surfaceMaterial_waitForTexels(scene, i);
        return;
    }
    HdsSampler sampler = pixel_sampler(frame, status.x, status.y);
    sampler = status.w != 0u ? sampler_fork(sampler, status.w) : sampler;
#if HDS_FEATURE_CUTOUT
    const bool isCulled = isCamera && passThrough_isCulled(scene, &surface, -viewer);
    const float transparency =
        isCulled ? 1.0f : vec_maxComponent(bsdf_passThrough(&bsdf, shading.wo.z));
    if (occlusion_pass(scene, &hit, &surface, sampler, transparency, paths, i)) {
        queue_append(nextQueue, &counters[HDS_COUNTER_ACTIVE], i);
        return;
    }
#endif
    if (isCamera && occlusion_start(&surface, &shading, sampler, distance, paths, i)) {
        queue_append(nextQueue, &counters[HDS_COUNTER_ACTIVE], i);
    }
}

/* Global size: count items, HDS_ITEMS_PER_WORK_ITEM for each work-item. */
kernel void occlusion_steps(HDS_SCENE_ARGS, constant const HdsFrameParams* frame,
                            global uchar* state, uint numSlots, global const uint* restrict queue,
                            uint count, global uint* restrict waitQueue,
                            global uint* restrict nextQueue, volatile global uint* counters,
                            float distance) {
    HdsPaths paths = {state, numSlots};
    HDS_SCENE_VIEW(scene);
    HDS_FOR_ITEMS(item, count) {
        occlusion_step(frame, &scene, paths, queue[item], distance, waitQueue, nextQueue, counters);
    }
    HDS_SCENE_END(scene);
}
