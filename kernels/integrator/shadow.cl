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

#if HDS_FEATURE_STREAMING
/* One iteration of a shadow ray. \return true when it arrives, or has met a candidate; false when
 * it is blocked or waits. */
bool shadow_iterate(const HdsGeometryView* view, HdsTraversalRay ray, HdsPaths paths, uint i,
                    uint isResumed, global uint* waitQueue, volatile global uint* counters,
                    HdsHit* candidate) {
    uint4 after = (uint4)(0u);
    uint primId = 0u;
    *candidate = hit_none();
#if HDS_FEATURE_CUTOUT
    uint4 pending = path_load_pending(paths, i);
    after = path_load_shadowAfter(paths, i);
    primId = pending.y;
    if (isResumed != 0u) {
        *candidate = path_loadCandidate(paths, i);
    }
#endif
    const uint state = traverse_iterateOccluded(view, ray, after, candidate, &primId);
    if (state == HDS_RAY_WAITS) {
#if HDS_FEATURE_CUTOUT
        pending.y = primId;
        path_storeCandidate(paths, i, candidate);
        path_store_pending(paths, i, pending);
#endif
        queue_append(waitQueue, &counters[HDS_COUNTER_WAITING], i);
    }
    return state == HDS_RAY_DECIDED;
}
#endif

/* Global size: count. Appends candidates (only with cut-outs), and rays that wait for a chunk (only
 * while geometry streams). \param isResumed the rays have waited: candidates are those found so
 * far. */
kernel void shadow_cast(global uchar* state, uint numSlots, global const uint* restrict queue,
                        uint count, uint isResumed, global uint* restrict waitQueue,
                        global uint* restrict candidateQueue, volatile global uint* counters,
                        HDS_SCENE_ARGS) {
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
#if HDS_FEATURE_CUTOUT || HDS_FEATURE_STREAMING
    HdsHit candidate;
#endif
#if HDS_FEATURE_STREAMING
    if (!shadow_iterate(&scene.geometry, ray, paths, i, isResumed, waitQueue, counters,
                        &candidate)) {
        return;
    }
#elif HDS_FEATURE_CUTOUT
    if (traverse_occludedAfter(&scene.geometry, ray, path_load_shadowAfter(paths, i), &candidate)) {
        return;
    }
#else
    if (traverse_occluded(&scene.geometry, ray)) {
        return;
    }
#endif
#if HDS_FEATURE_CUTOUT
    if (candidate.chunk != HDS_NONE) {
        path_storeCandidate(paths, i, &candidate);
        queue_append(candidateQueue, &counters[HDS_COUNTER_SHADOW], i);
        return;
    }
#endif
    shadow_addRadiance(paths, i);
}

#if HDS_FEATURE_CUTOUT
/* Global size: count. Appends rays of which something is left, and candidates that wait for their
 * pages. */
kernel void shadow_pass(global uchar* state, uint numSlots,
                        global const uint* restrict candidateQueue, uint count,
                        global uint* restrict waitQueue, global uint* restrict queue,
                        volatile global uint* counters, HDS_SCENE_ARGS) {
    uint item = (uint)get_global_id(0);
    if (item >= count) {
        return;
    }
    uint i = candidateQueue[item];
    HdsPaths paths = {state, numSlots};
    HDS_SCENE_VIEW(scene);
    HdsHit hit = path_loadCandidate(paths, i);
    if (surfaceHit_waits(&scene, &hit, waitQueue, counters, i)) {
        return;
    }
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
