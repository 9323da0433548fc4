/* SPDX-License-Identifier: Apache-2.0
 * Shadow rays. shadow_cast adds what arrives unhindered; a ray that meets a cut-out surface becomes
 * a candidate, which shadow_pass dims by the transparency there and sends on. From: the shadow
 * queue. To: path radiance, or the candidate queue and back. Explained in docs/wavefront.md. */
#include "accel/traverse.clh"
#include "integrator/passThrough.clh"
#include "integrator/pathState.clh"

void shadow_addRadiance(HdsPaths paths, uint i) {
    float4 radiance = path_load_radiance(paths, i);
    radiance.xyz += path_load_shadowRadiance(paths, i).xyz;
    path_store_radiance(paths, i, radiance);
}

/* Global size: count. Appends candidates (only with cut-outs). */
kernel void shadow_cast(global uchar* state, uint numSlots, global const uint* restrict queue,
                        uint count, global uint* restrict candidateQueue,
                        volatile global uint* counters, HDS_SCENE_ARGS) {
    uint item = (uint)get_global_id(0);
    if (item >= count) {
        return;
    }
    uint i = queue[item];
    HdsPaths paths = {state, numSlots};
    HDS_SCENE_VIEW(scene);
    float4 origin = path_load_shadowOrigin(paths, i);
    HdsTraversalRay ray;
    ray.origin = origin.xyz;
    ray.direction = path_load_shadowDirection(paths, i).xyz;
    ray.tMin = 0.0f;
    ray.tMax = origin.w;
#if HDS_FEATURE_CUTOUT
    HdsHit candidate;
    if (traverse_occludedAfter(&scene.geometry, ray, path_load_shadowAfter(paths, i), &candidate)) {
        return;
    }
    if (candidate.chunk != HDS_NONE) {
        path_storeCandidate(paths, i, &candidate);
        queue_append(candidateQueue, &counters[HDS_COUNTER_SHADOW], i);
        return;
    }
#else
    if (traverse_occluded(&scene.geometry, ray)) {
        return;
    }
#endif
    shadow_addRadiance(paths, i);
}

#if HDS_FEATURE_CUTOUT
/* Global size: count. Appends rays of which something is left. */
kernel void shadow_pass(global uchar* state, uint numSlots,
                        global const uint* restrict candidateQueue, uint count,
                        global uint* restrict queue, volatile global uint* counters,
                        HDS_SCENE_ARGS) {
    uint item = (uint)get_global_id(0);
    if (item >= count) {
        return;
    }
    uint i = candidateQueue[item];
    HdsPaths paths = {state, numSlots};
    HDS_SCENE_VIEW(scene);
    HdsHit hit = path_loadCandidate(paths, i);
    float4 direction = path_load_shadowDirection(paths, i);
    HdsSurfaceHit surface;
    HdsShadingPoint shading;
    HdsSurface bsdf;
    surfaceHit_load(&scene, &hit, &surface);
    surfaceHit_shade(&scene, &surface, -direction.xyz, &shading, &bsdf);
    float3 left = path_load_shadowRadiance(paths, i).xyz * surface_passThrough(&bsdf, shading.wo.z);
    if (!(vec_maxComponent(left) > 0.0f)) {
        return;
    }
    direction.w += 1.0f;
    if (direction.w >= (float)HDS_MAX_PASSES) {
        atomic_inc(&counters[HDS_COUNTER_PASSES]);
        return;
    }
    path_store_shadowRadiance(paths, i, (float4)(left, 0.0f));
    path_store_shadowDirection(paths, i, direction);
    path_store_shadowAfter(paths, i, passThrough_key(&hit, &surface));
    queue_append(queue, &counters[HDS_COUNTER_SHADOW], i);
}
#endif
