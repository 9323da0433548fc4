/* SPDX-License-Identifier: Apache-2.0
 * Starts the paths of a wave. From: nothing. To: the active queue (slot i is item i).
 * Explained in docs/wavefront.md. */
#include "integrator/camera.clh"
#include "integrator/pathState.clh"
#include "integrator/pixelSampler.clh"
#include "sample/filter.clh"
#include "texture/rayCone.clh"

/* Writes a camera ray and a fresh state to slot i. */
void generate_start(HdsPaths paths, uint i, constant const HdsFrameParams* frame, HdsCameraRay ray,
                    float time, uint pixel, uint sample) {
    path_store_origin(paths, i, (float4)(ray.origin, ray.tMin));
    path_store_direction(paths, i, (float4)(ray.direction, ray.tMax));
    path_store_throughput(paths, i, (float4)((float3)(frame->exposureScale), 0.0f));
    path_store_radiance(paths, i, (float4)(0.0f));
    path_store_sourceNormal(paths, i, (float4)(0.0f));
    path_store_status(paths, i, (uint4)(pixel, sample, 0u, 0u));
#if HDS_FEATURE_MOTION
    path_store_motion(paths, i, (float4)(time, 0.0f, 0.0f, 0.0f));
#endif
#if HDS_FEATURE_TEXTURES
    path_store_cones(paths, i, cones_begin(ray.cone.x, ray.cone.y).pair);
#endif
#if HDS_FEATURE_CUTOUT
    path_store_after(paths, i, (uint4)(0u));
#endif
}

/* Global size: count, slots [first, first + count) of the wave. To: queue[queueFirst...]. */
kernel void generate_sample(constant const HdsFrameParams* frame, HdsWave wave, uint first,
                            uint count, global uchar* state, uint numSlots,
                            global const uint* pixels, global const float* filterTable,
                            global uint* queue, uint queueFirst) {
    uint item = (uint)get_global_id(0);
    if (item >= count) {
        return;
    }
    uint i = first + item;
    HdsPaths paths = {state, numSlots};
    uint pixel = pixels[wave.firstPixel + i / wave.numSamples];
    uint sample = wave.firstSample + i % wave.numSamples;
    int2 position = pixel_position(frame, pixel);
    HdsSampler sampler = pixel_sampler(frame, pixel, sample);
    float2 offset = filter_sample2(filterTable, sampler_get2(sampler, HDS_DIM_FILTER));
    float2 raster =
        (float2)((float)position.x + 0.5f + offset.x, (float)position.y + 0.5f + offset.y);
    float time = 0.0f;
#if HDS_FEATURE_MOTION
    time = sampler_get1(sampler, HDS_DIM_TIME);
#endif
    HdsCameraRay ray = camera_generate(frame, raster, sampler_get2(sampler, HDS_DIM_LENS), time);
    generate_start(paths, i, frame, ray, time, pixel, sample);
    queue[queueFirst + item] = i;
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
    uint i = first + item;
    HdsPaths paths = {state, numSlots};
    uint pixel = pixels[wave.firstPixel + i];
    int2 position = pixel_position(frame, pixel);
    float2 raster = (float2)((float)position.x + 0.5f, (float)position.y + 0.5f);
    HdsCameraRay ray = camera_generate(frame, raster, (float2)(0.5f), frame->frameTime);
    generate_start(paths, i, frame, ray, frame->frameTime, pixel, 0u);
    queue[queueFirst + item] = i;
}
