/* SPDX-License-Identifier: Apache-2.0
 * Finds the closest hit of each active ray. From: the active queue. To: the same (shade or aov
 * reads it). Divergence: the traversal loop. Explained in docs/wavefront.md. */
#include "accel/traverse.clh"
#include "integrator/pathState.clh"

/* Global size: count. */
kernel void intersect_closest(global uchar* state, uint numSlots, global const uint* restrict queue,
                              uint count, HDS_GEOMETRY_ARGS) {
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
#if HDS_FEATURE_CUTOUT
    traverse_closestAfter(&view, ray, mask, path_load_after(paths, i), &hit);
#else
    traverse_closest(&view, ray, mask, &hit);
#endif
    path_storeHit(paths, i, &hit);
}
