/* SPDX-License-Identifier: Apache-2.0
 * Starts the paths of a wave. From: nothing. To: the active queue. Path i gets slot i; while rays
 * keep lists the slot that the queue says, whose own path has ended.
 * Explained in docs/wavefront.md. */
#include "integrator/generateRay.clh"
#include "integrator/itemLoop.clh"
#include "integrator/lightPaths.clh"
#include "integrator/pathLimits.clh"
#include "integrator/pathState.clh"
#include "sample/filter.clh"
#include "shared/material.h"
#include "texture/rayCone.clh"
#if HDS_WIDE
/* The order counts. */
/* clang-format off */
#include "math/wideBegin.clh"
#include "math/vector.clh"
#include "math/trig.clh"
#include "sample/warp.clh"
#include "sample/sampler.clh"
#include "sample/filter.clh"
#include "integrator/pixelSampler.clh"
#include "integrator/camera.clh"
#include "integrator/generateRay.clh"
#include "math/wideEnd.clh"
/* clang-format on */
#endif

/* The slot of path `number` of the wave, item `item` of the queue. */
uint generate_slot(global uint* queue, uint item, uint number) {
#if HDS_WAIT_LISTS
    return queue[item];
#else
    queue[item] = number;
    return number;
#endif
}

/* Writes a camera ray and a fresh state of path `number` to slot i. */
void generate_start(HdsPaths paths, uint i, uint number, constant const HdsFrameParams* frame,
                    HdsCameraRay ray, float time, uint pixel, uint sample) {
#if HDS_WAIT_LISTS
    path_beginNumber(paths, i, number);
#endif
    path_store_origin(paths, i, (float4)(ray.origin, ray.tMin));
    path_store_direction(paths, i, (float4)(ray.direction, ray.tMax));
    path_store_status(paths, i, (uint4)(pixel, sample, 0u, 0u));
#if !HDS_CAMERA_RAYS_ARE_ALIKE
    float4 throughput = path_cameraThroughput(frame);
#if HDS_FEATURE_CAMERA_LENS
    throughput.xyz *= ray.weight;
#endif
    path_store_throughput(paths, i, throughput);
    path_store_radiance(paths, i, (float4)(0.0f));
    path_store_sourceNormal(paths, i, (float4)(0.0f));
#endif
#if HDS_FEATURE_MOTION
    path_store_motion(paths, i, (float4)(time, 0.0f, 0.0f, 0.0f));
#endif
#if HDS_FEATURE_TEXTURES
    path_store_cones(paths, i, cones_begin(ray.cone.x, ray.cone.y).pair);
#endif
#if HDS_FEATURE_CUTOUT
    path_store_after(paths, i, (uint4)(0u));
#endif
#if HDS_FEATURE_MEDIA
    path_store_medium(paths, i, (uint4)(0u));
#endif
#if HDS_FEATURE_GLASS_SHADOWS
    path_store_glassSource(paths, i, (float4)(0.0f));
#endif
#if HDS_FEATURE_MEDIA_STACK
    path_store_mediaLow(paths, i, (uint4)(0u));
    path_store_mediaHigh(paths, i, (uint4)(0u, 0u, 0u, as_uint(ray.tMax)));
#endif
#if HDS_MEDIA_LINKS
    path_store_mediaSetsLow(paths, i, (uint4)(0u));
    path_store_mediaSetsHigh(paths, i, (uint4)(0u));
#endif
#if HDS_FEATURE_VOLUMES
    path_beginVolumes(paths, i, ray.tMin);
#endif
#if HDS_FEATURE_MATTES
#if HDS_FEATURE_DEEP
    path_store_matte(paths, i, (uint4)(HDS_NONE, 0u, 0u, as_uint(INFINITY)));
#else
    path_store_matte(paths, i, (uint4)(HDS_NONE, 0u, 0u, 0u));
#endif
#endif
#if HDS_FEATURE_PATH_LIMITS
    pathLimits_begin(paths, i);
#endif
#if HDS_LIGHT_PATH_STATE
    lightPaths_begin(paths, i);
#endif
}

#if HDS_FEATURE_MEDIA_STACK
/* Any direction; along the axes rays would lie in the faces of boxes. */
#define HDS_PROBE_DIRECTION (float3)(0.5883484f, 0.6276382f, 0.5098039f)

#endif

/* Where the camera may be in media of meshes, puts a ray before the camera ray of slot i that ends
 * where that begins, and finds which they are (integrator/shadeMeshMedium.clh). */
void generate_findMedia(constant const HdsFrameParams* frame, HdsPaths paths, uint i) {
#if HDS_FEATURE_MEDIA_STACK
    const float length = frame->probeLength;
    if (length > 0.0f) {
        const float4 origin = path_load_origin(paths, i);
        path_store_shadowOrigin(paths, i, origin);
        path_store_shadowDirection(paths, i, path_load_direction(paths, i));
        const float3 direction = vec_normalize(HDS_PROBE_DIRECTION);
        path_store_origin(paths, i, (float4)(vec_mulAdd(-length, direction, origin.xyz), 0.0f));
        path_store_direction(paths, i, (float4)(direction, length));
        path_store_medium(paths, i, (uint4)(HDS_MEDIUM_PROBE, 0u, 0u, 0u));
    }
#endif
}

/* Whether 8 camera rays are made at once. A camera may move, and has a pose for each path then;
 * lenses of more than one kind are written for one path. */
#define HDS_GENERATE_WIDE (HDS_WIDE && !HDS_FEATURE_MOTION && !HDS_FEATURE_CAMERA_LENS)

#if HDS_GENERATE_WIDE
/* Starts paths [i, i + count) of the wave, count <= HDS_LANES. \param item of path i in the queue.
 */
void generate_wide(constant const HdsFrameParams* frame, HdsWave wave, uint i, uint count,
                   HdsPaths paths, global const uint* pixels, global const float* filterTable,
                   global uint* queue, uint item) {
    /* Spelt out: what is stored lane by lane and read at once makes the processor wait. */
    const uint8 lanes = (uint8)(0u, 1u, 2u, 3u, 4u, 5u, 6u, 7u);
    const uint8 number = i + min(lanes, (uint8)(count - 1u)); /* else the last one again */
    const uint8 pixel = number / wave.numSamples;
    const uint8 lanePixel = lanes_loadUint(pixels + wave.firstPixel, pixel);
    const uint8 laneSample = wave.firstSample + (number - pixel * wave.numSamples);
    const HdsTransform pose = camera_pose(frame, 0.0f);
    const HdsWideSampler sampler = pixel_sampler(frame, lanePixel, laneSample);
    const HdsLens lens = camera_lens(frame, 0.0f);
    const HdsWideCameraRay wide =
        generate_ray(frame, &pose, &lens, lanePixel, sampler, filterTable);
    for (uint lane = 0u; lane < count; ++lane) {
        HdsOneCameraRay ray;
        ray.origin = lanes_get3(&wide.origin, lane);
        ray.direction = lanes_get3(&wide.direction, lane);
        ray.tMin = lanes_get(&wide.tMin, lane);
        ray.tMax = lanes_get(&wide.tMax, lane);
        ray.cone = (float2)(lanes_get(&wide.cone.x, lane), lanes_get(&wide.cone.y, lane));
        const uint slot = generate_slot(queue, item + lane, i + lane);
        generate_start(paths, slot, i + lane, frame, ray, 0.0f, lanes_getUint(&lanePixel, lane),
                       lanes_getUint(&laneSample, lane));
        generate_findMedia(frame, paths, slot);
    }
}
#else
/* Starts path i of the wave. \param item of it in the queue. */
void generate_one(constant const HdsFrameParams* frame, HdsWave wave, uint i, HdsPaths paths,
                  global const uint* pixels, global const float* filterTable, global uint* queue,
                  uint item) {
    const uint pixel = pixels[wave.firstPixel + i / wave.numSamples];
    const uint sample = wave.firstSample + i % wave.numSamples;
    const HdsSampler sampler = pixel_sampler(frame, pixel, sample);
    float time = 0.0f;
#if HDS_FEATURE_MOTION
    time = sampler_get1(sampler, HDS_DIM_TIME);
#endif
    const HdsTransform pose = camera_pose(frame, time);
    const HdsLens lens = camera_lens(frame, time);
    const HdsCameraRay ray = generate_ray(frame, &pose, &lens, pixel, sampler, filterTable);
    const uint slot = generate_slot(queue, item, i);
    generate_start(paths, slot, i, frame, ray, time, pixel, sample);
    generate_findMedia(frame, paths, slot);
}
#endif

/* Global size: count items, HDS_ITEMS_PER_WORK_ITEM for each work-item; paths [first, first +
 * count) of the wave. To: queue[queueFirst...]; while rays keep lists it has their slots. */
kernel void generate_sample(constant const HdsFrameParams* frame, HdsWave wave, uint first,
                            uint count, global uchar* state, uint numSlots,
                            global const uint* pixels, global const float* filterTable,
                            global uint* queue, uint queueFirst) {
    const HdsPaths paths = {state, numSlots};
    const uint begin = (uint)get_global_id(0) * HDS_ITEMS_PER_WORK_ITEM;
    const uint end = min(begin + HDS_ITEMS_PER_WORK_ITEM, count);
#if HDS_GENERATE_WIDE
    for (uint item = begin; item < end; item += HDS_LANES) {
        generate_wide(frame, wave, first + item, min(end - item, (uint)HDS_LANES), paths, pixels,
                      filterTable, queue, queueFirst + item);
    }
#else
    for (uint item = begin; item < end; ++item) {
        generate_one(frame, wave, first + item, paths, pixels, filterTable, queue,
                     queueFirst + item);
    }
#endif
}

/* One ray through each pixel's centre and the lens' centre, at the frame's own time, for the AOVs
 * of the first hit. */
kernel void generate_centre(constant const HdsFrameParams* frame, HdsWave wave, uint first,
                            uint count, global uchar* state, uint numSlots,
                            global const uint* pixels, global uint* queue, uint queueFirst) {
    uint item = (uint)get_global_id(0);
    if (item >= count) {
        return;
    }
    const uint i = first + item;
    const HdsPaths paths = {state, numSlots};
    const uint pixel = pixels[wave.firstPixel + i];
    const float2 raster =
        (float2)((float)pixel_column(frame, pixel) + 0.5f, (float)pixel_row(frame, pixel) + 0.5f);
    const HdsTransform pose = camera_pose(frame, frame->frameTime);
    const HdsLens lens = camera_lens(frame, frame->frameTime);
    const HdsCameraRay ray = camera_generate(frame, &pose, &lens, raster, (float2)(0.0f));
    const uint slot = generate_slot(queue, queueFirst + item, i);
    generate_start(paths, slot, i, frame, ray, frame->frameTime, pixel, 0u);
    generate_findMedia(frame, paths, slot);
}
