/* SPDX-License-Identifier: Apache-2.0
 * Finds the closest hit of each active ray. From: the active queue. To: the same (shade or aov
 * reads it). While geometry streams also: to the queue of rays that wait for chunks, and from there
 * to the slots that are ready. Divergence: the traversal loop. Explained in docs/wavefront.md. */
#include "accel/traverse.clh"
#include "integrator/pathState.clh"
#include "integrator/run.clh"

HdsTraversalRay intersect_loadRay(HdsPaths paths, uint i) {
    float4 origin = path_load_origin(paths, i);
    float4 direction = path_load_direction(paths, i);
    HdsTraversalRay ray;
    ray.origin = origin.xyz;
    ray.direction = direction.xyz;
    ray.tMin = origin.w;
    ray.tMax = direction.w;
#if HDS_FEATURE_MOTION
    ray.time = path_time(paths, i);
#endif
    return ray;
}

/* The first ray of a path is the camera's. */
uint intersect_flagMask(HdsPaths paths, uint i) {
    uint depth = path_load_status(paths, i).z & HDS_PATH_DEPTH_MASK;
    return depth == 0u ? HDS_INSTANCE_CAMERA : 0u;
}

uint4 intersect_after(HdsPaths paths, uint i) {
#if HDS_FEATURE_CUTOUT
    return path_load_after(paths, i);
#else
    return (uint4)(0u);
#endif
}

#if HDS_WAIT_LISTS
/* Keeps what a ray that waits goes on with. The slot's shadow ray has its own part of `pending`. */
void intersect_storeWait(HdsPaths paths, uint i, uint primId, const HdsWaitList* list,
                         global uint* waitQueue, volatile global uint* counters) {
    uint4 pending = path_load_pending(paths, i);
    pending.x = primId;
    pending.z = (pending.z & ~HDS_PATH_LIST_MASK) | list->size;
    path_store_pending(paths, i, pending);
    path_storeList(paths, i, pathField_waitBound, list);
    path_storeWaits(paths, i, path_loadWaits(paths, i) | HDS_PATH_RAY_WAITS);
    queue_append(waitQueue, &counters[HDS_COUNTER_WAITING_RAYS], i);
}
#endif

/* Global size: runs of count. Appends rays that wait for a chunk (only while geometry streams).
 * \param isResumed the rays have waited: hits are those found so far (only without lists). */
kernel void intersect_closest(HDS_GEOMETRY_ARGS, global uchar* state, uint numSlots,
                              global const uint* restrict queue, uint count, uint isResumed,
                              global uint* restrict waitQueue, volatile global uint* counters) {
    HdsPaths paths = {state, numSlots};
    HDS_GEOMETRY_VIEW(view);
    HDS_FOR_RUN(item, count) {
        uint i = queue[item];
        HdsTraversalRay ray = intersect_loadRay(paths, i);
        uint mask = intersect_flagMask(paths, i);
        HdsHit hit;
#if HDS_WAIT_LISTS
        HdsWaitList list;
        uint primId;
        bool waits = streamed_beginClosest(&view, ray, mask, intersect_after(paths, i), &hit,
                                           &primId, &list) == HDS_RAY_WAITS;
        path_storeHit(paths, i, &hit);
        path_storeWaits(paths, i, 0u);
        if (waits) {
            intersect_storeWait(paths, i, primId, &list, waitQueue, counters);
        }
#else
#if HDS_FEATURE_STREAMING
        /* Holds what the slot's shadow ray needs too. */
        uint4 pending = path_load_pending(paths, i);
        hit = isResumed != 0u ? path_loadHit(paths, i) : hit_none();
        uint primId = pending.x; /* of no meaning without a hit */
        if (streamed_iterateClosest(&view, ray, mask, intersect_after(paths, i), &hit, &primId) ==
            HDS_RAY_WAITS) {
            pending.x = primId;
            path_store_pending(paths, i, pending);
            queue_append(waitQueue, &counters[HDS_COUNTER_WAITING_RAYS], i);
        }
#elif HDS_FEATURE_CUTOUT
        traverse_closestAfter(&view, ray, mask, path_load_after(paths, i), &hit);
#else
        traverse_closest(&view, ray, mask, &hit);
#endif
        path_storeHit(paths, i, &hit);
#endif
    }
}

#if HDS_WAIT_LISTS
/* Global size: runs of count. Goes on with rays that have waited. Appends those that wait again,
 * and slots that are ready to be shaded. */
kernel void intersect_resume(HDS_GEOMETRY_ARGS, global uchar* state, uint numSlots,
                             global const uint* restrict queue, uint count,
                             global uint* restrict waitQueue, global uint* restrict readyQueue,
                             volatile global uint* counters) {
    HdsPaths paths = {state, numSlots};
    HDS_GEOMETRY_VIEW(view);
    HDS_FOR_RUN(item, count) {
        uint i = queue[item];
        uint4 pending = path_load_pending(paths, i);
        uint primId = pending.x;
        HdsWaitList list =
            path_loadList(paths, i, pathField_waitBound, pending.z & HDS_PATH_LIST_MASK);
        HdsHit hit = path_loadHit(paths, i);
        bool goesOnWaiting = streamed_resumeClosest(
                                 &view, intersect_loadRay(paths, i), intersect_flagMask(paths, i),
                                 intersect_after(paths, i), &hit, &primId, &list) == HDS_RAY_WAITS;
        path_storeHit(paths, i, &hit);
        if (goesOnWaiting) {
            intersect_storeWait(paths, i, primId, &list, waitQueue, counters);
        } else {
            path_endWait(paths, i, HDS_PATH_RAY_WAITS, readyQueue, counters);
        }
    }
}
#endif
