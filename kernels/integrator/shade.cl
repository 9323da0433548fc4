/* SPDX-License-Identifier: Apache-2.0
 * Shades the hits of a ray batch: lights seen along the ray, emission, one light sample (a shadow
 * ray) and one BSDF sample (the next ray). From: the active queue after intersect. To: the next
 * active queue and the shadow queue. Source: path tracing with next-event estimation and multiple
 * importance sampling by the power heuristic, Veach 1997, sections 9.2 and 10.3. Explained in
 * docs/wavefront.md. */
#include "integrator/choices.clh"
#include "integrator/itemLoop.clh"
#include "integrator/passThrough.clh"
#include "integrator/pathState.clh"
#include "integrator/pixelSampler.clh"
#include "integrator/shadeLight.clh"

/* Samples the BSDF; true when the next ray was written to slot i. */
bool shade_sampleBsdf(constant const HdsFrameParams* frame, const HdsShadeHit* at,
                      HdsSampler sampler, const HdsShadePath* path, HdsPaths paths, uint i) {
    const HdsShadingPoint* shading = &at->shading;
    float3 wi;
    float pdf;
    float3 weight =
        bsdf_sample(&at->bsdf, at->lobes, shading->wo,
                    sampler_get2(sampler, HDS_DIM_BOUNCE(path->depth, HDS_DIM_LOBE)), &wi, &pdf);
    float3 throughput = path->throughput * weight;
    bool isLast = path->depth == frame->maxDepth;
    if (!(pdf > 0.0f) || !(vec_maxComponent(throughput) > 0.0f) ||
        !choices_survives(frame, sampler, path->depth, &throughput)) {
        return false;
    }
    float3 direction = vec_normalize(frame_toWorld(&shading->frame, wi));
    float3 geomNormal = shading->geomNormal;
    float3 normal = shading->frame.z;
    float lightPdf = pdf; /* what light samples are weighed against */
#if HDS_BSDF_TRANSMITS
    const float side = wi.z > 0.0f ? 1.0f : -1.0f;
    const float sideShare = bsdf_lightShare(&at->bsdf, side);
    lightPdf = sideShare > 0.0f ? pdf / sideShare : 0.0f;
    geomNormal *= side;
    normal *= side;
#endif
    path_store_origin(paths, i, (float4)(offset_origin(&at->surface.point, geomNormal), 0.0f));
    path_store_direction(paths, i, (float4)(direction, INFINITY));
    path_store_throughput(paths, i, (float4)(throughput, lightPdf));
    path_store_sourceNormal(paths, i,
                            (float4)(normal, (float)(2u * at->linkSet + (isLast ? 1u : 0u))));
    path_store_status(paths, i, (uint4)(path->status.xy, path->depth + 1u, 0u));
#if HDS_FEATURE_TEXTURES
    path_store_cones(paths, i, shade_leavingCones(at, path, pdf).pair);
#endif
#if HDS_FEATURE_LIGHT_CONTROLS
    path_store_diffuseShare(paths, i, (float4)(shade_diffuseShare(at, wi, weight * pdf), 0.0f));
#endif
#if HDS_FEATURE_CUTOUT
    path_store_after(paths, i, (uint4)(0u));
#endif
    return true;
}

HdsShadePath shade_loadPath(HdsPaths paths, uint i) {
    HdsShadePath path;
    float4 throughput = path_load_throughput(paths, i);
    float4 radiance = path_load_radiance(paths, i);
    float4 sourceNormal = path_load_sourceNormal(paths, i);
    path.origin = path_load_origin(paths, i).xyz;
    path.direction = path_load_direction(paths, i).xyz;
    path.throughput = throughput.xyz;
    path.bsdfPdf = throughput.w;
    const uint source = (uint)sourceNormal.w;
    path.source.position = path.origin;
    path.source.normal = sourceNormal.xyz;
    path.source.linkSet = source >> 1;
    path.isLast = (source & 1u) != 0u;
    path.radiance = radiance.xyz;
    path.alpha = radiance.w;
    path.status = path_load_status(paths, i);
    path.depth = path.status.z & HDS_PATH_DEPTH_MASK;
    path.time = path_time(paths, i);
    path.tBegin = 0.0f;
#if HDS_FEATURE_CUTOUT
    path.tBegin = as_float(path_load_after(paths, i).x);
#endif
    path.isMissing = false;
#if HDS_FEATURE_TEXTURES
    path.cones.pair = path_load_cones(paths, i);
#endif
#if HDS_FEATURE_LIGHT_CONTROLS
    path.diffuseShare = path_load_diffuseShare(paths, i).xyz;
#endif
    return path;
}

#if HDS_FEATURE_CUTOUT
/* Lets the ray go on behind a surface, by chance in proportion to the transparency; the throughput
 * of either outcome is divided by its probability. \return true when it passed and slot i holds the
 * rest of the ray; the hit is not shaded then. */
bool shade_passThrough(const HdsHit* hit, const HdsSurfaceHit* surface, float3 transparency,
                       HdsSampler sampler, HdsShadePath* path, HdsPaths paths, uint i) {
    float probability = vec_maxComponent(transparency);
    if (!(probability > 0.0f)) {
        return false;
    }
    if (path->status.w != 0u) {
        sampler = sampler_fork(sampler, path->status.w);
    }
    if (sampler_get1(sampler, HDS_DIM_BOUNCE(path->depth, HDS_DIM_OPACITY)) >= probability) {
        path->throughput /= 1.0f - probability;
        return false;
    }
    path->throughput *= transparency / probability;
    path->status.z += HDS_PATH_ONE_PASS;
    path->status.w = passThrough_id(path->status.w, hit, surface);
    path_store_throughput(paths, i, (float4)(path->throughput, path->bsdfPdf));
    path_store_status(paths, i, path->status);
    path_store_after(paths, i, passThrough_key(hit, surface));
    return true;
}
#endif

#if HDS_FEATURE_TEXTURES
/* How the textures of a hit are read. An opacity may be compared with a threshold, and a program
 * may do more than add and multiply: these need the filter's own value. */
HdsTexelChoice shade_chooseTexels(constant const HdsFrameParams* frame, const HdsSceneView* scene,
                                  const HdsSurfaceHit* surface, const HdsShadePath* path) {
    HdsTexelChoice choice = {0.0f, 8u};
    if ((surfaceHit_material(scene, surface)->flags &
         (HDS_MATERIAL_CUTOUT | HDS_MATERIAL_COMPUTES)) == 0u) {
        const HdsSampler sampler = pixel_sampler(frame, path->status.x, path->status.y);
        choice.number = sampler_get2(sampler, HDS_DIM_BOUNCE(path->depth, HDS_DIM_OPACITY)).y;
        choice.numTexels = path->depth == 0u ? 4u : 1u;
    }
    return choice;
}
#endif

/* Reads a hit and evaluates its material. Sets path->isMissing. */
void shade_loadHit(constant const HdsFrameParams* frame, const HdsSceneView* scene,
                   HdsShadePath* path, HdsShadeHit* at) {
    surfaceHit_load(scene, &at->hit, path->time, &at->surface);
    at->linkSet = surfaceHit_linkSet(scene, &at->surface);
#if HDS_FEATURE_TEXTURES
    path->hitCones = cones_atHit(path->cones, at->hit.t, path->depth == 0u);
    at->surface.coneWidth = cones_width(path->hitCones);
    at->surface.choice = shade_chooseTexels(frame, scene, &at->surface, path);
#endif
    at->isEnd = path->isLast && surfaceHit_isDark(scene, &at->surface);
    if (!at->isEnd) {
        path->isMissing =
            !surfaceHit_shade(scene, &at->surface, -path->direction, &at->shading, &at->bsdf);
    }
}

/* Shades a hit; true when slot i holds a ray that goes on. Sets path->isMissing, and has written
 * nothing then. \param[out] hasShadow a shadow ray was written. */
bool shade_surface(constant const HdsFrameParams* frame, const HdsSceneView* scene, HdsShadeHit* at,
                   HdsShadePath* path, HdsPaths paths, uint i, volatile global uint* counters,
                   bool* hasShadow) {
    if (at->isEnd) {
        return false;
    }
    HdsSampler sampler = pixel_sampler(frame, path->status.x, path->status.y);
#if HDS_BSDF_TRANSMITS
    path->throughput *= bsdf_transmittance(&at->bsdf, at->hit.t);
#endif
#if HDS_FEATURE_CUTOUT
    float3 transparency = bsdf_passThrough(&at->bsdf, at->shading.wo.z);
    if (path->depth == 0u && passThrough_isCulled(scene, &at->surface, path->direction)) {
        transparency = (float3)(1.0f);
    }
    if (shade_passThrough(&at->hit, &at->surface, transparency, sampler, path, paths, i)) {
        bool mayGoOn = (path->status.z >> HDS_PATH_PASS_SHIFT) < HDS_MAX_PASSES;
        if (!mayGoOn) {
            atomic_inc(&counters[HDS_COUNTER_PASSES]);
        }
        return mayGoOn;
    }
#endif
    if (path->depth == 0u) {
        path->alpha = 1.0f;
    }
    shade_addEmission(scene, &at->hit, &at->surface, bsdf_emission(&at->bsdf), path);
    if (path->isLast) {
        return false;
    }
    at->lobes = bsdf_lobeProbabilities(&at->bsdf, at->shading.wo.z);
    *hasShadow = shade_sampleLight(scene, at, sampler, path, paths, i);
    return !path->isMissing && shade_sampleBsdf(frame, at, sampler, path, paths, i);
}

/* What shading a path has led to. */
#define HDS_SHADE_GOES_ON 1u /* slot i holds the next ray */
#define HDS_SHADE_SHADOW 2u  /* slot i holds a shadow ray */

/* Shades the hit of slot i. Appends paths that wait for their hit's pages or texels.
 * \return HDS_SHADE_* bits. */
uint shade_path(constant const HdsFrameParams* frame, const HdsSceneView* scene, HdsPaths paths,
                uint i, global uint* waitQueue, volatile global uint* counters) {
#if HDS_WAIT_LISTS
    if (path_loadWaits(paths, i) != 0u) {
        return 0u;
    }
#endif
    HdsShadeHit at;
    at.hit = path_loadHit(paths, i);
    bool isHit = at.hit.chunk != HDS_NONE;
    if (isHit &&
        surfaceHit_waits(scene, &at.hit, waitQueue, counters, HDS_COUNTER_WAITING_HITS, i)) {
        return 0u;
    }
    HdsShadePath path = shade_loadPath(paths, i);
    if (isHit) {
        shade_loadHit(frame, scene, &path, &at);
    }
    bool hasShadow = false;
    bool goesOn = false;
    shade_addLights(scene, isHit ? at.hit.t : INFINITY, &path);
    if (isHit && !path.isMissing) {
        goesOn = shade_surface(frame, scene, &at, &path, paths, i, counters, &hasShadow);
    }
    if (path.isMissing) {
        surfaceHit_waitForTexels(scene, i);
        return 0u;
    }
    path_store_radiance(paths, i, (float4)(path.radiance, path.alpha));
#if HDS_WAIT_LISTS
    if (hasShadow && !goesOn) {
        path_storeWaits(paths, i, HDS_PATH_ENDED);
    }
#endif
    return (goesOn ? HDS_SHADE_GOES_ON : 0u) | (hasShadow ? HDS_SHADE_SHADOW : 0u);
}

/* Global size: count items, HDS_ITEMS_PER_WORK_ITEM for each work-item. Appends paths that go on,
 * shadow rays, and paths that wait for their hit's pages or texels. Paths whose rays wait are left
 * out. */
kernel void shade_paths(HDS_SCENE_ARGS, constant const HdsFrameParams* frame, global uchar* state,
                        uint numSlots, global const uint* restrict queue, uint count,
                        global uint* restrict waitQueue, global uint* restrict nextQueue,
                        global uint* restrict shadowQueue, volatile global uint* counters) {
    HdsPaths paths = {state, numSlots};
    HDS_SCENE_VIEW(scene);
    HdsItemList next = {0u};
    HdsItemList shadows = {0u};
    HDS_FOR_ITEMS(item, count) {
        const uint i = queue[item];
        const uint result = shade_path(frame, &scene, paths, i, waitQueue, counters);
        if ((result & HDS_SHADE_GOES_ON) != 0u) {
            items_append(&next, i);
        }
        if ((result & HDS_SHADE_SHADOW) != 0u) {
            items_append(&shadows, i);
        }
    }
    items_flush(&next, nextQueue, &counters[HDS_COUNTER_ACTIVE]);
    items_flush(&shadows, shadowQueue, &counters[HDS_COUNTER_SHADOW]);
}
