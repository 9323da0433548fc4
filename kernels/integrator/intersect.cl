/* SPDX-License-Identifier: Apache-2.0
 * Finds the closest hit of each active ray. From: the active queue. To: the same (shade or aov
 * reads it). While geometry streams also: to the queue of rays that wait for chunks, and from there
 * to the slots that are ready. Divergence: the traversal loop. Explained in docs/wavefront.md. */
#include "integrator/itemLoop.clh"
#include "integrator/trace.clh"

/* Whether 8 camera rays are traced together. */
#define HDS_INTERSECT_PACKETS (HDS_FEATURE_FLAT && HDS_WIDE)
#if HDS_INTERSECT_PACKETS
#include "math/wideBegin.clh"

#include "math/vector.clh"
#include "math/wideEnd.clh"

#include "integrator/tracePacket.clh"
#endif

/* Global size: count items, HDS_ITEMS_PER_WORK_ITEM for each work-item. Appends rays that wait for
 * a chunk (only while geometry streams). */
kernel void intersect_closest(HDS_GEOMETRY_ARGS, global uchar* state, uint numSlots,
                              global const uint* restrict queue, uint count,
                              global uint* restrict waitQueue, volatile global uint* counters) {
    HdsPaths paths = {state, numSlots};
    HDS_GEOMETRY_VIEW(view);
#if HDS_INTERSECT_PACKETS
    const uint first = (uint)get_global_id(0) * HDS_ITEMS_PER_WORK_ITEM;
    if (first < count) {
        trace_closestRun(&view, paths, queue + first,
                         min(count - first, (uint)HDS_ITEMS_PER_WORK_ITEM), waitQueue, counters);
    }
#else
    HDS_FOR_ITEMS(item, count) {
        trace_closest(&view, paths, queue[item], waitQueue, counters);
    }
#endif
}

#if HDS_FEATURE_STREAMING
/* Global size: count items, HDS_ITEMS_PER_WORK_ITEM for each work-item. Goes on with rays that have
 * waited. Appends those that wait again, and slots that are ready to be shaded. */
kernel void intersect_resume(HDS_GEOMETRY_ARGS, global uchar* state, uint numSlots,
                             global const uint* restrict queue, uint count,
                             global uint* restrict waitQueue, global uint* restrict readyQueue,
                             volatile global uint* counters) {
    HdsPaths paths = {state, numSlots};
    HDS_GEOMETRY_VIEW(view);
    HDS_FOR_ITEMS(item, count) {
#if HDS_WAIT_LISTS
        if (item + HDS_FETCH_AHEAD < itemsEnd) {
            trace_fetchClosest(paths, queue[item + HDS_FETCH_AHEAD]);
        }
#endif
        trace_resumeClosest(&view, paths, queue[item], waitQueue, readyQueue, counters);
    }
}
#endif
