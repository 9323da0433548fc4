/* SPDX-License-Identifier: Apache-2.0
 * Shades the hits of a ray batch: lights seen along the ray, emission, one light sample (a shadow
 * ray) and one BSDF sample (the next ray). From: the active queue after intersect. To: the next
 * active queue and the shadow queue. Source: path tracing with next-event estimation and multiple
 * importance sampling by the power heuristic, Veach 1997, sections 9.2 and 10.3. Explained in
 * docs/wavefront.md. */
#include "integrator/itemLoop.clh"
#include "integrator/pathState.clh"
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
#include "math/power.clh"
#include "sample/ggxStretched.clh"
#include "shading/layeredLobes.clh"
#include "shading/albedo.clh"
#include "shading/layeredFresnel.clh"
#include "shading/layeredFrost.clh"
#include "shading/layeredSchlick.clh"
#include "shading/layeredSetup.clh"
#include "shading/layeredSurface.clh"
#include "shading/layeredSample.clh"
#endif
#include "shading/bsdf.clh"
#include "shading/materialPoint.clh"
#include "light/place.clh"
#include "light/rect.clh"
#include "light/sphere.clh"
#if HDS_FEATURE_MESH_LIGHTS
#include "sample/sphericalTriangle.clh"
#include "light/panel.clh"
#endif
#include "light/image.clh"
#include "light/domeImage.clh"
#include "light/dome.clh"
#include "light/domeGuide.clh"
#include "light/far.clh"
#include "light/estimate.clh"
#include "light/select.clh"
#if HDS_FEATURE_TEXTURES
#include "texture/rayCone.clh"
#endif
#include "integrator/placement.clh"
#include "integrator/trianglePoint.clh"
#include "integrator/pixelSampler.clh"
#include "integrator/choices.clh"
#include "integrator/scatter.clh"
#include "math/wideEnd.clh"
/* clang-format on */
#endif
#include "integrator/shadeHits.clh"
#include "integrator/shadeSurface.clh"
#if HDS_SHADE_WIDE
#include "integrator/shadeBatch.clh"
#endif

#if HDS_SHADE_WIDE
/* Reads the material of a hit and puts it into its lane. \return HDS_SHADE_SCATTERS where the
 * surface is to be set up with the others; HDS_SHADE_WALKS where shade_lightSurface does that;
 * HDS_SHADE_ENDS where the path has been shaded. */
uint shade_putSurface(constant const HdsFrameParams* frame, const HdsSceneView* scene,
                      HdsShadeHits* hits, uint lane, HdsPaths paths, volatile global uint* counters,
                      HdsShadeBatch* batch, HdsShadeLists* lists) {
    HdsShadeHit* at = &hits->at[lane];
    HdsShadePath* path = &hits->path[lane];
    const uint i = hits->slots[lane];
    if (shade_onTheWay(frame, scene, at, path, i, paths, counters, lists)) {
        return HDS_SHADE_ENDS;
    }
#if HDS_FEATURE_MEDIA
    if (path->medium.medium.kind == HDS_MEDIUM_WALK) {
        return HDS_SHADE_WALKS;
    }
#endif
    HdsMaterialPoint material;
    const uint step = shade_readSurface(frame, scene, at, path, &material);
    if (step == HDS_SHADE_ENDS) {
        const HdsLitPath lit = shade_litPath(at, path, 0u, i);
        shade_leave(scene, &lit, step, paths, lists);
        return step;
    }
#if HDS_FEATURE_HAIR
    if (surfaceMaterial_isHair(&material)) {
        shade_alone(frame, scene, at, path, &material, i, paths, counters, lists);
        return HDS_SHADE_ENDS;
    }
#endif
    shadeBatch_putMaterial(batch, lane, &material);
    return step;
}

/* Decides about a surface that has been set up: its lane is lit, or its path has been shaded.
 * \param seen surfaces of all lanes. */
void shade_lightSurface(constant const HdsFrameParams* frame, const HdsSceneView* scene,
                        HdsShadeHits* hits, uint lane, uint step, const HdsWideSeenSurface* seen,
                        HdsPaths paths, volatile global uint* counters, HdsShadeBatch* batch,
                        HdsShadeLists* lists) {
    HdsShadeHit* at = &hits->at[lane];
    HdsShadePath* path = &hits->path[lane];
    const uint i = hits->slots[lane];
#if HDS_FEATURE_MEDIA
    if (step == HDS_SHADE_WALKS) {
        HdsScatter scatter;
        step = shadeMedium_meet(scene, at, path, &scatter, paths, i, counters);
        if (step == HDS_SHADE_SCATTERS) {
            shadeBatch_putSurface(batch, lane, &scatter);
        }
    } else
#endif
    {
        HdsSeenSurface one;
        one.emission = lanes_get3(&seen->emission, lane);
#if HDS_FEATURE_CUTOUT
        one.passed = lanes_get3(&seen->passed, lane);
#endif
#if HDS_BSDF_TRANSMITS
        one.absorption = lanes_get3(&seen->absorption, lane);
#endif
        step = shade_meetSurface(frame, scene, at, path, &one, paths, i, counters);
    }
    HdsLitPath* lit = &batch->paths[lane];
    *lit = shade_litPath(at, path, 0u, i);
    if (step != HDS_SHADE_SCATTERS) {
        shade_leave(scene, lit, step, paths, lists);
        return;
    }
    shadeBatch_light(scene, at, path, batch, lane);
}

/* Shades all paths of a batch, which is empty then. Each has hit a surface. */
void shade_hits(constant const HdsFrameParams* frame, const HdsSceneView* scene, HdsShadeHits* hits,
                HdsPaths paths, volatile global uint* counters, HdsShadeBatch* batch,
                HdsShadeLists* lists) {
    shadeHits_place(scene, hits, &batch->surfaces, &batch->materials);
    shadeHits_setSamplers(frame, hits, &batch->surfaces);
    shadeHits_addLights(frame, scene, hits);
    uint steps[HDS_LANES];
    bool isAny = false;
    for (uint lane = 0u; lane < hits->count; ++lane) {
        steps[lane] = shade_putSurface(frame, scene, hits, lane, paths, counters, batch, lists);
        isAny = isAny || steps[lane] != HDS_SHADE_ENDS;
    }
    if (isAny) {
        HdsWideSeenSurface seen;
        shadeBatch_setup(batch, &seen);
        batch->isLit = 0;
        for (uint lane = 0u; lane < hits->count; ++lane) {
            if (steps[lane] != HDS_SHADE_ENDS) {
                shade_lightSurface(frame, scene, hits, lane, steps[lane], &seen, paths, counters,
                                   batch, lists);
            }
        }
        shadeBatch_scatter(frame, scene, batch, paths, lists);
    }
    hits->count = 0u;
}

/* The same of paths that have met nothing, or that end at what they have hit. */
void shade_ends(constant const HdsFrameParams* frame, const HdsSceneView* scene, HdsShadeHits* ends,
                HdsPaths paths, volatile global uint* counters, HdsShadeLists* lists) {
    shadeHits_addLights(frame, scene, ends);
    for (uint lane = 0u; lane < ends->count; ++lane) {
        HdsShadeHit* at = &ends->at[lane];
        HdsShadePath* path = &ends->path[lane];
        const uint i = ends->slots[lane];
        if (!shade_onTheWay(frame, scene, at, path, i, paths, counters, lists)) {
            shade_learnDomes(at, path, counters);
            at->isHit = false; /* nothing of a surface is known */
            const HdsLitPath lit = shade_litPath(at, path, 0u, i);
            shade_leave(scene, &lit, HDS_SHADE_ENDS, paths, lists);
        }
    }
    ends->count = 0u;
}
#else
/* Shades a path. */
void shade_path(constant const HdsFrameParams* frame, const HdsSceneView* scene, HdsShadeHits* hits,
                HdsPaths paths, volatile global uint* counters, HdsShadeLists* lists) {
    HdsShadeHit* at = &hits->at[0];
    HdsShadePath* path = &hits->path[0];
    const uint i = hits->slots[0];
    if (at->isHit) {
        shadeHits_place(scene, hits);
    }
    shadeHits_addLights(frame, scene, hits);
    hits->count = 0u;
    if (shade_onTheWay(frame, scene, at, path, i, paths, counters, lists)) {
        return;
    }
    uint step = HDS_SHADE_ENDS;
#if HDS_FEATURE_MEDIA
    if (path->medium.medium.kind == HDS_MEDIUM_WALK) {
        HdsScatter scatter;
        step = shadeMedium_meet(scene, at, path, &scatter, paths, i, counters);
        shade_scatterAlone(frame, scene, at, path, step, &scatter, i, paths, lists);
        return;
    }
#endif
    shade_learnDomes(at, path, counters);
    HdsMaterialPoint material;
    if (at->isHit) {
        step = shade_readSurface(frame, scene, at, path, &material);
    }
    if (step == HDS_SHADE_ENDS) {
        const HdsLitPath lit = shade_litPath(at, path, 0u, i);
        shade_leave(scene, &lit, step, paths, lists);
        return;
    }
    shade_alone(frame, scene, at, path, &material, i, paths, counters, lists);
}
#endif

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
#if HDS_FEATURE_DOME_GUIDE
    lists.numEnded = 0u;
#endif
    HdsShadeHits hits;
    hits.count = 0u;
#if HDS_SHADE_WIDE
    HDS_LANES_CLEAR(&hits.triangles);
    HdsShadeHits* smooth = &hits;
#if HDS_LOBES
    HdsShadeHits smoothHits;
    smoothHits.count = 0u;
    HDS_LANES_CLEAR(&smoothHits.triangles);
    smooth = &smoothHits;
#endif
    HdsShadeHits ends;
    ends.count = 0u;
    HdsShadeBatch batch;
    shadeBatch_begin(&batch);
    HDS_FOR_ITEMS(item, count) {
        if (item + HDS_HITS_AHEAD < count) {
            shadeHits_fetch(&scene, paths, queue[item + HDS_HITS_AHEAD]);
        }
        shadeHits_read(frame, &scene, paths, queue[item], waitQueue, counters, &hits, smooth,
                       &ends);
        if (hits.count == HDS_HIT_LANES) {
            shade_hits(frame, &scene, &hits, paths, counters, &batch, &lists);
        }
#if HDS_LOBES
        if (smoothHits.count == HDS_HIT_LANES) {
            shade_hits(frame, &scene, &smoothHits, paths, counters, &batch, &lists);
        }
#endif
        if (ends.count == HDS_HIT_LANES) {
            shade_ends(frame, &scene, &ends, paths, counters, &lists);
        }
    }
    if (ends.count > 0u) {
        shade_ends(frame, &scene, &ends, paths, counters, &lists);
    }
#if HDS_LOBES
    if (smoothHits.count > 0u) {
        shade_hits(frame, &scene, &smoothHits, paths, counters, &batch, &lists);
    }
#endif
    if (hits.count > 0u) {
        shade_hits(frame, &scene, &hits, paths, counters, &batch, &lists);
    }
#else
    HDS_FOR_ITEMS(item, count) {
        shadeHits_read(frame, &scene, paths, queue[item], waitQueue, counters, &hits, &hits, &hits);
        if (hits.count > 0u) {
            shade_path(frame, &scene, &hits, paths, counters, &lists);
#if HDS_FEATURE_PATH_LIMITS
            if (hits.path[0].limits.hasClamped && !hits.path[0].isMissing) {
                atomic_inc(&counters[HDS_COUNTER_CLAMPED]);
            }
#endif
        }
    }
#endif
    HDS_SCENE_END(scene);
    items_flush(&lists.next, nextQueue, &counters[HDS_COUNTER_ACTIVE]);
    items_flush(&lists.shadows, shadowQueue, &counters[HDS_COUNTER_SHADOW]);
#if HDS_FEATURE_DOME_GUIDE
    if (lists.numEnded > 0u && as_float(counters[HDS_GUIDE_SCALE]) > 0.0f) {
        atomic_add(&counters[HDS_GUIDE_ENDED], lists.numEnded);
    }
#endif
}
