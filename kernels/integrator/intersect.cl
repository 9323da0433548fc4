/* SPDX-License-Identifier: Apache-2.0
 * Finds the closest hit of each active ray. From: the active queue. To: the same (shade or aov
 * reads it). While geometry streams: from the active queue, then from the rays that wait, until
 * none does. Divergence: the traversal loop. Explained in docs/wavefront.md. */
#include "accel/traverse.clh"
#include "integrator/pathState.clh"

/* Global size: count. Appends rays that wait for a chunk (only while geometry streams).
 * \param isResumed the rays have waited: hits are those found so far. */
kernel void intersect_closest(global uchar* state, uint numSlots, global const uint* restrict queue,
                              uint count, uint isResumed, global uint* restrict waitQueue,
                              volatile global uint* counters, HDS_GEOMETRY_ARGS) {
    uint item = (uint)get_global_id(0);
    if (item >= count) {
        return;
    }
    uint i = queue[item];
    HdsPaths paths = {state, numSlots};
    HDS_GEOMETRY_VIEW(view);
    float4 origin = path_load_origin(paths, i);
    float4 direction = path_load_direction(paths, i);
    HdsTraversalRay ray;
    ray.origin = origin.xyz;
    ray.direction = direction.xyz;
    ray.tMin = origin.w;
    ray.tMax = direction.w;
    /* The first ray of a path is the camera's. */
    uint mask =
        (path_load_status(paths, i).z & HDS_PATH_DEPTH_MASK) == 0u ? HDS_INSTANCE_CAMERA : 0u;
    HdsHit hit;
#if HDS_FEATURE_STREAMING
    uint4 after = (uint4)(0u);
    /* Holds what the slot's shadow ray needs too. */
    uint4 pending = path_load_pending(paths, i);
    hit = isResumed != 0u ? path_loadHit(paths, i) : hit_none();
#if HDS_FEATURE_CUTOUT
    after = path_load_after(paths, i);
#endif
    uint primId = pending.x; /* of no meaning without a hit */
    if (traverse_iterateClosest(&view, ray, mask, after, &hit, &primId) == HDS_RAY_WAITS) {
        pending.x = primId;
        path_store_pending(paths, i, pending);
        queue_append(waitQueue, &counters[HDS_COUNTER_WAITING], i);
    }
#elif HDS_FEATURE_CUTOUT
    traverse_closestAfter(&view, ray, mask, path_load_after(paths, i), &hit);
#else
    traverse_closest(&view, ray, mask, &hit);
#endif
    path_storeHit(paths, i, &hit);
}
