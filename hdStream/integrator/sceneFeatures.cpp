// SPDX-License-Identifier: Apache-2.0
#include "hdStream/integrator/sceneFeatures.h"

#include "hdStream/integrator/cameraFrame.h"
#include "hdStream/integrator/filmBuffers.h"
#include "hdStream/integrator/lightPathTable.h"
#include "hdStream/scene/motion.h"

#include <algorithm>
#include <cstdint>

namespace hds {

namespace {

bool ChooseSimd8(const RenderOptions& options, const DeviceProperties& properties) {
    return options.traversal == TraversalForm::Auto ? properties.isCpu
                                                    : options.traversal != TraversalForm::Scalar;
}

/// While geometry streams: whether it would be flat, once it is resident; meshes that are placed
/// several times are not looked at.
bool WillBeFlat(const CommittedScene& scene, const RenderOptions& options,
                const ResidencyOptions& residency, const SceneBuffers& buffers) {
    return scene.counts.triangles <=
           MaxFlatTriangles(LimitsOfFlat(scene, options, residency, buffers));
}

} // namespace

KernelFeatures SceneFeatures(const CommittedScene& scene, const RenderOptions& options,
                             const ResidencyOptions& residency, const SceneBuffers& buffers,
                             const DeviceProperties& properties, bool isStreaming) {
    KernelFeatures features;
    features.cutouts = scene.hasCutouts;
    features.programs = buffers.HasPrograms();
    features.patterns = scene.hasPatterns;
    features.closures = scene.hasClosures;
    features.lobes = scene.lobes;
    features.textures = buffers.HasTextures();
    features.instancePrimvars = buffers.HasInstancePrimvars();
    features.lightShaping = scene.lights->hasShaping;
    features.lightControls = scene.lights->hasControls;
    features.lightMotion = scene.lights->hasMotion;
    features.lightPortals = scene.lights->hasPortals;
    features.meshLights = scene.lights->hasMeshes;
    features.texturedEmission = scene.lights->hasTexturedEmission;
    features.lightTree = scene.lights->lights.size() > HDS_LIGHT_LOOP_MAX;
    features.numTexturePools = buffers.Textures().NumBuffers() > 1 ? kMaxPoolBuffers : 1;
    features.textureStreaming = buffers.Textures().Pool() != nullptr;
    features.groups = scene.hasGroups;
    features.instanceChunks = scene.hasInstanceChunks;
    features.curves = scene.hasCurves;
    features.motion = scene.hasMotion || MovesOver(options.camera, options.shutter) ||
                      LensChangesOver(options.camera, options.shutter);
    features.cameraLens = NeedsLensKernels(options.camera, options.shutter);
    features.catchers = options.aovs.hasCatchers;
    features.simd8 = ChooseSimd8(options, properties);
    features.flat = !isStreaming && MayBeFlat(options, features, buffers) &&
                    (buffers.Flat().IsThere() ||
                     (buffers.IsStreaming() && WillBeFlat(scene, options, residency, buffers)));
    features.flatInstances = features.flat && buffers.Flat().HasInstances();
    features.firstHits = NeedsFirstHits(options.aovs);
    features.occlusion = options.aovs.hasOcclusion;
    features.rayVisibility = scene.hasRayVisibility;
    features.mattes = options.aovs.hasMattes;
    features.pathLimits = options.HasPathLimits();
    features.media = scene.hasMedia;
    features.hair = scene.hasHair;
    features.glassShadows = scene.hasGlassShadows;
    features.terminator = options.smoothTerminator;
    features.mediaStack = !scene.meshMedia.empty();
    features.volumes = !scene.volumes.volumes.empty();
    features.lightPaths = NumLightPathSums(options.aovs.lightPaths.size());
    features.numPools = buffers.NumPoolBuffers() > 1 ? kMaxPoolBuffers : 1;
    features.streaming = isStreaming;
    features.requestsFirst = features.streaming && residency.requestsFirst;
    return features;
}

bool MayBeFlat(const RenderOptions& options, const KernelFeatures& features,
               const SceneBuffers& buffers) {
    const bool isAsked = options.traversal == TraversalForm::Flat ||
                         (options.traversal == TraversalForm::Auto && !options.interactive);
    // Scenes with catchers are drawn twice, with other instances.
    return isAsked && features.simd8 && !features.motion && !features.instanceChunks &&
           !features.catchers && !buffers.IsMapped();
}

FlatLimits LimitsOfFlat(const CommittedScene& scene, const RenderOptions& options,
                        const ResidencyOptions& residency, const SceneBuffers& buffers) {
    FlatLimits limits;
    limits.isForced = options.traversal == TraversalForm::Flat;
    limits.cameraRays = std::uint64_t{options.imageWidth} * options.imageHeight * options.samples;
    const std::uint64_t budgetBytes = buffers.Plan(scene, residency).budgetBytes;
    limits.bytes = budgetBytes - std::min(budgetBytes, buffers.PoolBytes());
    return limits;
}

} // namespace hds
