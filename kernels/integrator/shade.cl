/* SPDX-License-Identifier: Apache-2.0
 * Shades the hits of a ray batch: lights seen along the ray, emission, one light sample (a shadow
 * ray) and one BSDF sample (the next ray). From: the active queue after intersect. To: the next
 * active queue and the shadow queue. Source: path tracing with next-event estimation and multiple
 * importance sampling by the power heuristic, Veach 1997, sections 9.2 and 10.3. Explained in
 * docs/wavefront.md. */
#include "integrator/itemLoop.clh"
#include "integrator/passThrough.clh"
#include "integrator/pathState.clh"
#include "integrator/pixelSampler.clh"
#include "integrator/shadeScatter.clh"
#if HDS_SHADE_WIDE
/* The order counts. */
/* clang-format off */
#include "math/wideBegin.clh"
#include "math/vector.clh"
#include "math/trig.clh"
#include "math/inverse.clh"
#include "math/offset.clh"
#include "sample/warp.clh"
#include "sample/sampler.clh"
#include "sample/ggx.clh"
#include "sample/sphericalRect.clh"
#include "shading/previewSurface.clh"
#include "shading/material.clh"
#if HDS_LOBES
#include "sample/ggxStretched.clh"
#include "shading/layeredLobes.clh"
#include "shading/layeredSetup.clh"
#include "shading/layeredSurface.clh"
#endif
#include "shading/bsdf.clh"
#include "light/place.clh"
#include "light/rect.clh"
#include "light/image.clh"
#include "light/domeImage.clh"
#include "light/dome.clh"
#include "light/far.clh"
#include "light/estimate.clh"
#include "light/select.clh"
#if HDS_FEATURE_TEXTURES
#include "texture/rayCone.clh"
#endif
#include "integrator/placement.clh"
#include "integrator/pixelSampler.clh"
#include "integrator/choices.clh"
#include "integrator/scatter.clh"
#include "math/wideEnd.clh"
/* clang-format on */
#include "integrator/shadeBatch.clh"
#endif
#include "integrator/shadeHair.clh"
#include "integrator/shadeHits.clh"
#if HDS_FEATURE_DEEP
#include "integrator/deepPath.clh"
#endif
#if HDS_FEATURE_MEDIA
#include "integrator/shadeMedium.clh"
#endif
#if HDS_FEATURE_MEDIA_STACK
#include "integrator/shadeMeshMedium.clh"
#endif

#if HDS_FEATURE_CUTOUT || HDS_FEATURE_CLOSURES
/* The sampler of a hit behind others that the ray has passed. */
HdsSampler shade_sampler(const HdsShadePath* path) {
    return path->status.w != 0u ? sampler_fork(path->sampler, path->status.w) : path->sampler;
}
#endif

#if HDS_FEATURE_CLOSURES
/* The number by which a hit takes one of several closures. Materials that have them take none for
 * their texels (HDS_MATERIAL_COMPUTES). */
float shade_chance(const HdsShadePath* path) {
    return sampler_get2(shade_sampler(path), HDS_DIM_BOUNCE(path->depth, HDS_DIM_OPACITY)).y;
}
#endif

#if HDS_FEATURE_CUTOUT
/* Lets the ray go on behind a surface, by chance in proportion to the transparency; the throughput
 * of either outcome is divided by its probability. \return true when it passed and slot i holds the
 * rest of the ray; the hit is not shaded then. */
bool shade_passThrough(const HdsSceneView* scene, const HdsHit* hit, const HdsSurfaceHit* surface,
                       float3 transparency, HdsShadePath* path, HdsPaths paths, uint i) {
    float probability = vec_maxComponent(transparency);
    if (!(probability > 0.0f)) {
        return false;
    }
    const HdsSampler sampler = shade_sampler(path);
    if (sampler_get1(sampler, HDS_DIM_BOUNCE(path->depth, HDS_DIM_OPACITY)) >= probability) {
        path->throughput /= 1.0f - probability;
        return false;
    }
    if (path_isFresh(path->status)) {
        path_store_sourceNormal(paths, i, (float4)(0.0f));
    }
    path->throughput *= transparency / probability;
    path->status.z += HDS_PATH_ONE_PASS;
    path->status.w = passThrough_id(path->status.w, hit, surface);
#if HDS_FEATURE_MEDIA_STACK
    const uint number = meshMedia_number(scene, surface);
    if (number != 0u) {
        shadeMeshMedium_cross(scene, number, meshMedia_enters(surface, path->direction), hit->t,
                              path, paths, i);
    }
#endif
    path_store_throughput(paths, i, (float4)(path->throughput, path->bsdfPdf));
    path_store_status(paths, i, path->status);
    path_store_after(paths, i, passThrough_key(hit, surface));
#if HDS_FEATURE_VOLUMES
    path_beginVolumes(paths, i, hit->t);
#endif
    return true;
}
#endif

#if HDS_FEATURE_TEXTURES
/* How the textures of a hit are read. An opacity may be compared with a threshold, and a program
 * may do more than add and multiply: these need the filter's own value. */
HdsTexelChoice shade_chooseTexels(const HdsSceneView* scene, const HdsSurfaceHit* surface,
                                  const HdsShadePath* path) {
    HdsTexelChoice choice = {0.0f, 8u};
    if ((surfaceMaterial_of(scene, surface)->flags &
         (HDS_MATERIAL_CUTOUT | HDS_MATERIAL_COMPUTES)) == 0u) {
#if HDS_SHADE_WIDE
        choice.number = surface->choice.number; /* shadeHits_setSamplers */
#else
        choice.number = sampler_get2(path->sampler, HDS_DIM_BOUNCE(path->depth, HDS_DIM_OPACITY)).y;
#endif
        choice.numTexels = path->depth == 0u ? 4u : 1u;
    }
    return choice;
}
#endif

/* Evaluates the material of a hit, lets the ray pass or adds what the surface emits. Sets
 * path->isMissing. \return HDS_SHADE_ENDS and so on. */
uint shade_surface(constant const HdsFrameParams* frame, const HdsSceneView* scene, HdsShadeHit* at,
                   HdsShadePath* path, HdsScatter* scatter, HdsPaths paths, uint i,
                   volatile global uint* counters) {
    scatter->linkSet = surfaceHit_linkSet(scene, &at->surface);
    if (path->isLast && surfaceMaterial_isDark(scene, &at->surface)) {
        return HDS_SHADE_ENDS;
    }
#if HDS_FEATURE_CLOSURES
    at->surface.chance = shade_chance(path);
#endif
#if HDS_FEATURE_MEDIA_STACK
    const bool isThere = meshMedia_meet(scene, &path->medium.stack, path->direction, &at->surface);
#endif
#if HDS_FEATURE_TEXTURES
    at->surface.choice = shade_chooseTexels(scene, &at->surface, path);
#endif
#if HDS_FEATURE_PATH_LIMITS
    at->surface.leastRoughness = pathLimits_roughness(frame, &path->limits);
#endif
    path->isMissing |= !surfaceMaterial_shade(scene, &at->surface, -path->direction,
                                              &scatter->shading, &scatter->bsdf);
    if (path->isMissing) {
        return HDS_SHADE_ENDS;
    }
#if HDS_FEATURE_MEDIA
    bool mayAbsorb = path->medium.medium.kind == HDS_MEDIUM_NONE;
#if HDS_FEATURE_MEDIA_STACK
    mayAbsorb = mayAbsorb && meshMedia_number(scene, &at->surface) == 0u;
#endif
    if (mayAbsorb) {
        path->throughput *= bsdf_transmittance(&scatter->bsdf, at->hit.t);
    }
#elif HDS_BSDF_TRANSMITS
    path->throughput *= bsdf_transmittance(&scatter->bsdf, at->hit.t);
#endif
#if HDS_FEATURE_CUTOUT
    float3 transparency = bsdf_passThrough(&scatter->bsdf, scatter->shading.wo.z);
    if (path->depth == 0u && passThrough_isCulled(scene, &at->surface, path->direction)) {
        transparency = (float3)(1.0f);
    }
#if HDS_FEATURE_MEDIA_STACK
    transparency = isThere ? transparency : (float3)(1.0f);
#endif
    if (shade_passThrough(scene, &at->hit, &at->surface, transparency, path, paths, i)) {
        if ((path->status.z >> HDS_PATH_PASS_SHIFT) < HDS_MAX_PASSES) {
            return HDS_SHADE_PASSES;
        }
        atomic_inc(&counters[HDS_COUNTER_PASSES]);
        return HDS_SHADE_ENDS;
    }
#endif
#if HDS_FEATURE_MEDIA
    path->throughput *= mediumPath_weightAt(&path->medium, at->hit.t);
#endif
#if HDS_FEATURE_RAY_VISIBILITY
    if (path->depth == 0u &&
        (scene_instance(&scene->geometry, at->surface.leaf)->flags & HDS_INSTANCE_HOLDOUT) != 0u) {
        return HDS_SHADE_ENDS;
    }
#endif
#if HDS_FEATURE_CATCHERS
    const bool isCaught =
        path->depth == 0u &&
        (scene_instance(&scene->geometry, at->surface.leaf)->flags & HDS_INSTANCE_CATCHER) != 0u;
#else
    const bool isCaught = false;
#endif
    if (isCaught) {
        path->alpha = HDS_CAUGHT_ALPHA;
    } else if (path->depth == 0u) {
        path->alpha = 1.0f;
#if HDS_FEATURE_MATTES
        const uint entry = scene->prims[at->surface.prim].materialBase + at->surface.materialEntry;
#if HDS_FEATURE_DEEP
        path_store_matte(paths, i,
                         (uint4)(at->surface.prim, entry, (uint)at->surface.instanceId,
                                 as_uint(deepPath_depth(frame, path, at->hit.t))));
#else
        path_store_matte(paths, i,
                         (uint4)(at->surface.prim, entry, (uint)at->surface.instanceId, 0u));
#endif
#endif
    }
    shade_addEmission(scene, &at->hit, &at->surface, bsdf_emission(&scatter->bsdf), path);
    if (path->isLast) {
        return HDS_SHADE_ENDS;
    }
#if HDS_FEATURE_SPLATS
    if (at->surface.splat.w > 0.0f) { /* it reflects nothing */
        return HDS_SHADE_ENDS;
    }
#endif
    scatter->point = at->surface.point;
#if HDS_FEATURE_TERMINATOR
    scatter->lift = at->surface.lift;
#endif
    scatter->throughput = path->throughput;
    scatter->sampler = path->sampler;
    scatter->depth = path->depth;
    return HDS_SHADE_SCATTERS;
}

/* Shades a hit, or ends a path that has met nothing. */
void shade_path(constant const HdsFrameParams* frame, const HdsSceneView* scene, HdsShadeHit* at,
                HdsShadePath* path, uint i, HdsPaths paths, volatile global uint* counters,
                HdsShadeBatch* batch, HdsShadeLists* lists) {
    HdsScatter scatter;
    scatter.linkSet = 0u;
    uint step = HDS_SHADE_ENDS;
#if HDS_FEATURE_DEEP
    deepPath_keepLight(frame, path, paths, i);
#endif
#if HDS_FEATURE_MEDIA
    const uint kind = path->medium.medium.kind;
#if HDS_FEATURE_MEDIA_STACK
    if (kind == HDS_MEDIUM_PROBE) {
        shadeMeshMedium_probe(frame, scene, at, path, paths, i);
        const HdsLitPath probe = shade_litPath(at, path, 0u, i);
        shade_end(scene, &probe, HDS_SHADE_GOES_ON, paths, lists);
        return;
    }
    shadeMeshMedium_addLight(frame, scene, paths, i, at->isHit ? at->hit.t : path->tEnd, path);
#endif
#if HDS_FEATURE_VOLUMES
    const bool isEvent = kind != HDS_MEDIUM_NONE || path->volume != HDS_NONE;
#else
    const bool isEvent = kind != HDS_MEDIUM_NONE;
#endif
    if (!at->isHit && isEvent) {
        shadeMedium_scatter(frame, scene, at, path, i, paths, lists);
        return;
    }
    if (kind == HDS_MEDIUM_WALK) {
        step = shadeMedium_meet(scene, at, path, &scatter, paths, i, counters);
    } else
#endif
        if (at->isHit) {
        step = shade_surface(frame, scene, at, path, &scatter, paths, i, counters);
    }
#if HDS_SHADE_WIDE
    HdsLitPath* lit = shadeBatch_next(batch); /* in its place, where it stays if it is lit */
#else
    HdsLitPath one;
    HdsLitPath* lit = &one;
#endif
    *lit = shade_litPath(at, path, scatter.linkSet, i);
    if (step != HDS_SHADE_SCATTERS) {
        const uint result = step == HDS_SHADE_PASSES ? HDS_SHADE_GOES_ON : 0u;
        shade_end(scene, lit, result, paths, lists);
        return;
    }
#if HDS_FEATURE_HAIR
    if (scatter.bsdf.isHair != 0u) {
        shadeHair_scatter(frame, scene, &scatter, lit, paths, lists);
#if HDS_FEATURE_PATH_LIMITS
        path->limits.hasClamped = lit->limits.hasClamped && !lit->isMissing;
#endif
        return;
    }
#endif
#if HDS_FEATURE_MEDIA
    shade_setMedia(scene, at, path->direction, &scatter, lit);
#endif
#if HDS_FEATURE_GLASS_SHADOWS
    lit->isGlass = at->isHit && path->depth > 0u &&
                   bsdf_isGlass(&scatter.bsdf, surfaceMaterial_of(scene, &at->surface)->flags);
#endif
#if HDS_SHADE_WIDE
    shadeBatch_add(batch, &scatter);
    if (batch->count == HDS_LANES) {
        shadeBatch_scatter(frame, scene, batch, paths, lists);
    }
#else
    shade_scatter(frame, scene, &scatter, lit, paths, lists);
#if HDS_FEATURE_PATH_LIMITS
    path->limits.hasClamped = lit->limits.hasClamped && !lit->isMissing;
#endif
#endif
}

/* Shades all paths of a batch, which is empty then; either all have hit something or none has. */
void shade_hits(constant const HdsFrameParams* frame, const HdsSceneView* scene, HdsShadeHits* hits,
                HdsPaths paths, volatile global uint* counters, HdsShadeBatch* batch,
                HdsShadeLists* lists) {
    if (hits->at[0].isHit) {
        shadeHits_place(scene, hits);
#if HDS_SHADE_WIDE
        shadeHits_setSamplers(frame, hits);
#endif
    }
    shadeHits_addLights(scene, hits);
    for (uint lane = 0u; lane < hits->count; ++lane) {
        shade_path(frame, scene, &hits->at[lane], &hits->path[lane], hits->slots[lane], paths,
                   counters, batch, lists);
#if HDS_FEATURE_PATH_LIMITS
        if (hits->path[lane].limits.hasClamped && !hits->path[lane].isMissing) {
            atomic_inc(&counters[HDS_COUNTER_CLAMPED]);
        }
#endif
    }
    hits->count = 0u;
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
#if HDS_FEATURE_GLASS_SHADOWS
    scene.hasGlassShadows = (frame->flags & HDS_FRAME_GLASS_SHADOWS) != 0u;
#endif
    HdsShadeLists lists;
    lists.next.count = 0u;
    lists.shadows.count = 0u;
    HdsShadeHits hits;
    hits.count = 0u;
    HdsShadeBatch batch;
    batch.count = 0u;
#if HDS_SHADE_WIDE
    HdsShadeHits misses;
    misses.count = 0u;
    HDS_FOR_ITEMS(item, count) {
        if (item + HDS_HITS_AHEAD < count) {
            shadeHits_fetch(&scene, paths, queue[item + HDS_HITS_AHEAD]);
        }
        shadeHits_read(frame, &scene, paths, queue[item], waitQueue, counters, &hits, &misses);
        HdsShadeHits* full = hits.count == HDS_HIT_LANES ? &hits : &misses;
        if (full->count == HDS_HIT_LANES) {
            shade_hits(frame, &scene, full, paths, counters, &batch, &lists);
        }
    }
    if (misses.count > 0u) {
        shade_hits(frame, &scene, &misses, paths, counters, &batch, &lists);
    }
    if (hits.count > 0u) {
        shade_hits(frame, &scene, &hits, paths, counters, &batch, &lists);
    }
    if (batch.count > 0u) {
        shadeBatch_scatter(frame, &scene, &batch, paths, &lists);
    }
#else
    HDS_FOR_ITEMS(item, count) {
        shadeHits_read(frame, &scene, paths, queue[item], waitQueue, counters, &hits, &hits);
        if (hits.count > 0u) {
            shade_hits(frame, &scene, &hits, paths, counters, &batch, &lists);
        }
    }
#endif
    items_flush(&lists.next, nextQueue, &counters[HDS_COUNTER_ACTIVE]);
    items_flush(&lists.shadows, shadowQueue, &counters[HDS_COUNTER_SHADOW]);
}
