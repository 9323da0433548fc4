// SPDX-License-Identifier: Apache-2.0
#include "hdStream/integrator/sceneFeatures.h"

#include "hdStream/integrator/cameraFrame.h"
#include "hdStream/integrator/filmBuffers.h"
#include "hdStream/integrator/lightPathTable.h"
#include "hdStream/scene/motion.h"
#include "hdStream/shading/domeGuide.h"
#include "kernels/shared/dispersion.h"

#include <algorithm>
#include <cstdint>

namespace hds {

namespace {

/// More than pages take, bounds of what is not prepared yet included.
constexpr std::uint64_t kPageBytesATriangle = 256;

bool ChooseSimd8(const RenderOptions& options, const DeviceProperties& properties) {
    return options.traversal == TraversalForm::Auto ? properties.isCpu
                                                    : options.traversal != TraversalForm::Scalar;
}

/// Meshes that are placed several times are not looked at.
bool WillBeFlat(const CommittedScene& scene, const FlatLimits& limits) {
    return scene.counts.triangles <= MaxFlatTriangles(limits);
}

bool Moves(const CommittedScene& scene, const RenderOptions& options) {
    return scene.hasMotion || MovesOver(options.camera, options.shutter) ||
           LensChangesOver(options.camera, options.shutter);
}

bool HasDispersion(const CommittedScene& scene) {
    return std::any_of(scene.materials.begin(), scene.materials.end(),
                       [](const shared::HdsMaterial& one) {
                           return one.lobes != 0 && shared::dispersion_ofFlags(one.flags) > 0.0F;
                       });
}

/// \param budgetBytes of the pool, which holds `poolBytes`.
FlatLimits MakeFlatLimits(const RenderOptions& options, const DeviceProperties& properties,
                          std::uint64_t budgetBytes, std::uint64_t poolBytes) {
    FlatLimits limits;
    limits.raysATriangle = properties.isCpu ? kFlatRaysATriangleCpu : kFlatRaysATriangleGpu;
    limits.isForced = options.traversal == TraversalForm::Flat;
    limits.cameraRays = std::uint64_t{options.imageWidth} * options.imageHeight * options.samples;
    limits.bytes = budgetBytes - std::min(budgetBytes, poolBytes);
    if (properties.maxAllocationBytes > 0) { // it is one buffer, and bytes a triangle are a mean
        limits.bytes = std::min(limits.bytes, properties.maxAllocationBytes / 5 * 4);
    }
    return limits;
}

} // namespace

KernelFeatures SceneFeatures(const CommittedScene& scene, const RenderOptions& options,
                             const ResidencyOptions& residency, const SceneBuffers& buffers,
                             const DeviceProperties& properties, bool isStreaming) {
    KernelFeatures features;
    features.cutouts = scene.hasCutouts;
    features.programs = buffers.HasPrograms() || scene.hasPatterns;
    features.patterns = scene.hasPatterns || scene.hasClosures; // a factor alone computes nothing
    features.closures = scene.hasClosures;
    features.transforms = scene.hasTransforms;
    features.autobump = scene.hasAutobump;
    features.lobes = scene.lobes;
    // Ray cones say how far aside a displaced surface is looked at.
    features.textures = buffers.HasTextures() || scene.hasAutobump;
    features.instancePrimvars = buffers.HasInstancePrimvars();
    features.lightShaping = scene.lights->hasShaping;
    features.lightControls = scene.lights->hasControls;
    features.lightMotion = scene.lights->hasMotion;
    features.lightFilters = scene.lights->hasFilters;
    features.lightPortals = scene.lights->hasPortals;
    features.domeGuide = MayHaveGuide(*scene.lights);
    features.meshLights = scene.lights->hasMeshes;
    features.texturedEmission = scene.lights->hasTexturedEmission;
    features.lightTree = scene.lights->lights.size() > HDS_LIGHT_LOOP_MAX;
    features.numTexturePools = buffers.Textures().NumBuffers() > 1 ? kMaxPoolBuffers : 1;
    features.textureStreaming = buffers.Textures().Pool() != nullptr;
    features.groups = scene.hasGroups;
    features.instanceChunks = scene.hasInstanceChunks;
    features.curves = scene.hasCurves;
    features.splats = scene.hasSplats;
    features.motion = Moves(scene, options);
    features.cameraLens = NeedsLensKernels(options.camera, options.shutter);
    features.catchers = options.aovs.hasCatchers;
    features.flat =
        !isStreaming && MayBeFlat(scene, options, residency) &&
        (buffers.Flat().IsThere() ||
         (buffers.IsStreaming() &&
          WillBeFlat(scene, LimitsOfFlat(scene, options, residency, buffers, properties))));
    features.simd8 = features.flat || ChooseSimd8(options, properties);
    features.flatInstances = features.flat && buffers.Flat().HasInstances();
    features.flatCopies = features.flat && buffers.Flat().NumCopies() > 0;
    features.firstHits = NeedsFirstHits(options.aovs);
    features.occlusion = options.aovs.hasOcclusion;
    features.rayVisibility = scene.hasRayVisibility;
    features.deep = options.deep.has_value();
    features.mattes = options.aovs.hasMattes || features.deep;
    features.pathLimits = options.HasPathLimits();
    features.media = scene.hasMedia;
    features.hair = scene.hasHair;
    features.dispersion = HasDispersion(scene);
    features.workingSpace = scene.hasWorkingSpace;
    features.glassShadows = scene.hasGlassShadows;
    features.terminator = options.smoothTerminator;
    features.mediaStack = !scene.meshMedia.empty();
    features.volumes = !scene.volumes.volumes.empty();
    features.volumeMotion = scene.volumes.haveMotion;
    features.volumeTerms = !scene.volumes.terms.empty();
    features.volumePatterns = scene.volumes.havePatterns;
    features.lightPaths = NumLightPathSums(options.aovs.lightPaths.size());
    features.numPools = buffers.NumPoolBuffers() > 1 ? kMaxPoolBuffers : 1;
    features.streaming = isStreaming;
    features.requestsFirst = features.streaming && residency.requestsFirst;
    features.pageHash = features.streaming && buffers.Streaming().HasPageHash();
    return features;
}

TraversalForm FormOf(const KernelFeatures& features) {
    return features.flat    ? TraversalForm::Flat
           : features.simd8 ? TraversalForm::Simd8
                            : TraversalForm::Scalar;
}

bool MayBeFlat(const CommittedScene& scene, const RenderOptions& options,
               const ResidencyOptions& residency) {
    const bool isAsked = options.traversal == TraversalForm::Flat ||
                         (options.traversal == TraversalForm::Auto && !options.interactive);
    // What instance chunks hold is not walked to find out that it is most of the scene.
    const bool isMostFlat = options.traversal == TraversalForm::Flat || !scene.hasInstanceChunks ||
                            double{scene.flatPart} >= FlatAmount().minShare;
    // Scenes with catchers are drawn twice, with other instances.
    return isAsked && isMostFlat && !scene.hasCatchers && residency.mode != ResidencyMode::Mapped;
}

FlatLimits LimitsOfFlat(const CommittedScene& scene, const RenderOptions& options,
                        const ResidencyOptions& residency, const SceneBuffers& buffers,
                        const DeviceProperties& properties) {
    return MakeFlatLimits(options, properties, buffers.Plan(scene, residency).budgetBytes,
                          buffers.PoolBytes());
}

bool RaysPayForAllPages(const CommittedScene& scene, const RenderOptions& options,
                        const ResidencyOptions& residency, const DeviceProperties& properties) {
    const std::uint64_t totalBytes = scene.pages->TotalBytes();
    const std::uint64_t budgetBytes =
        PlanResidency(residency, totalBytes, properties.memoryBytes).budgetBytes;
    const FlatLimits limits = MakeFlatLimits(options, properties, budgetBytes, totalBytes);
    // Curves and points are not flattened: they count by their bytes. How many samples a limit of
    // time leaves is not known yet.
    return residency.mode == ResidencyMode::Auto && options.timeLimit == 0.0 &&
           totalBytes <= std::min(budgetBytes, MaxFlatTriangles(limits) * kPageBytesATriangle) &&
           MayBeFlat(scene, options, residency) && WillBeFlat(scene, limits);
}

} // namespace hds
