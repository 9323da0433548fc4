// SPDX-License-Identifier: Apache-2.0
#include "hdStream/integrator/stageKernels.h"

#include <string>

namespace hds {

namespace {

/// Every field of the path state takes 16 bytes a path (kernels/shared/pathState.def).
constexpr std::uint64_t kFieldBytes = 16;

std::uint64_t NumPathFields(const KernelFeatures& features) {
    std::uint64_t count = 0;
#define HDS_FIELD(type, name, doc) ++count;
#define HDS_MOTION_FIELD(type, name, doc) count += features.motion ? 1 : 0;
#define HDS_TEXTURE_FIELD(type, name, doc) count += features.textures ? 1 : 0;
#define HDS_CONTROLS_FIELD(type, name, doc) count += features.lightControls ? 1 : 0;
#define HDS_SHADOW_LIGHT_FIELD(type, name, doc) \
    count += features.lightControls || features.lightGlow ? 1 : 0;
#define HDS_CUTOUT_FIELD(type, name, doc) count += features.cutouts ? 1 : 0;
#define HDS_STREAMING_FIELD(type, name, doc) count += features.streaming ? 1 : 0;
#define HDS_LIST_FIELD(type, name, doc) count += features.HasLists() ? 1 : 0;
#include "kernels/shared/pathState.def"
#undef HDS_FIELD
#undef HDS_MOTION_FIELD
#undef HDS_TEXTURE_FIELD
#undef HDS_CONTROLS_FIELD
#undef HDS_SHADOW_LIGHT_FIELD
#undef HDS_CUTOUT_FIELD
#undef HDS_STREAMING_FIELD
#undef HDS_LIST_FIELD
    return count;
}

/// Index of the first scene argument of each kernel: what comes before changes with each launch.
constexpr unsigned kIntersectArgs = 6;
constexpr unsigned kIntersectResumeArgs = 7;
constexpr unsigned kShadeArgs = 9;
constexpr unsigned kShadowCastArgs = 8;
constexpr unsigned kShadowResumeArgs = 8;
constexpr unsigned kShadowPassArgs = 8;
constexpr unsigned kAovArgs = 12;

/// Items that a work-item of the kernels of queues takes (kernels/integrator/run.clh).
std::uint32_t RunLength(const Device& device) {
    return device.Properties().isCpu ? 32 : 1;
}

ProgramDefines MakeDefines(const Device& device, const KernelFeatures& features) {
    return {
        {"HDS_RUN_LENGTH", std::to_string(RunLength(device)) + "u"},
        {"HDS_FEATURE_CUTOUT", features.cutouts ? "1" : "0"},
        {"HDS_FEATURE_PROGRAMS", features.programs ? "1" : "0"},
        {"HDS_FEATURE_PATTERNS", features.patterns ? "1" : "0"},
        {"HDS_LOBES", std::to_string(features.lobes) + "u"},
        {"HDS_FEATURE_TEXTURES", features.textures ? "1" : "0"},
        {"HDS_FEATURE_LIGHT_SHAPING", features.lightShaping ? "1" : "0"},
        {"HDS_FEATURE_LIGHT_CONTROLS", features.lightControls ? "1" : "0"},
        {"HDS_FEATURE_LIGHT_PORTALS", features.lightPortals ? "1" : "0"},
        {"HDS_FEATURE_MESH_LIGHTS", features.meshLights ? "1" : "0"},
        {"HDS_FEATURE_LIGHT_GLOW", features.lightGlow ? "1" : "0"},
        {"HDS_FEATURE_LIGHT_TREE", features.lightTree ? "1" : "0"},
        {"HDS_NUM_TEXTURE_POOLS", std::to_string(features.manyTexturePools ? kMaxPoolBuffers : 1)},
        {"HDS_FEATURE_TEXTURE_STREAMING", features.textureStreaming ? "1" : "0"},
        {"HDS_TEXTURE_PLAIN", features.plainTextures ? "1" : "0"},
        {"HDS_FEATURE_GROUPS", features.groups ? "1" : "0"},
        {"HDS_FEATURE_CURVES", features.curves ? "1" : "0"},
        {"HDS_FEATURE_MOTION", features.motion ? "1" : "0"},
        {"HDS_NUM_POOLS", std::to_string(features.manyPools ? kMaxPoolBuffers : 1)},
        {"HDS_FEATURE_STREAMING", features.streaming ? "1" : "0"},
        {"HDS_REQUEST_FIRST", features.requestsFirst ? "1" : "0"},
        {"HDS_TRAVERSAL_WIDE", features.wide ? "1" : "0"}};
}

constexpr const char* kFrame = "integrator/frame.cl";
constexpr const char* kIntersect = "integrator/intersect.cl";
constexpr const char* kShade = "integrator/shade.cl";
constexpr const char* kShadow = "integrator/shadow.cl";
constexpr const char* kAov = "integrator/aov.cl"; ///< only with first-hit AOVs

} // namespace

bool StageKernels::AreInStore(const Device& device, const Store& store,
                              const KernelFeatures& features) {
    const ProgramDefines defines = MakeDefines(device, features);
    for (const char* root : {kFrame, kIntersect, kShade, kShadow, kAov}) {
        const bool isUsed = root != kAov || features.firstHits;
        if (isUsed && !Program::IsInStore(device, root, defines, store)) {
            return false;
        }
    }
    return true;
}

std::uint64_t StageKernels::PathStateBytes(const KernelFeatures& features) {
    return kFieldBytes * NumPathFields(features);
}

StageKernels::StageKernels(const std::shared_ptr<Device>& device, Store* store,
                           const KernelFeatures& features)
    : _features(features) {
    const ProgramDefines defines = MakeDefines(*device, features);
    const auto build = [&](const char* root) {
        _unsaved.push_back(std::make_unique<Program>(device, root, defines, store));
        _buildSeconds += _unsaved.back()->BuildSeconds();
        return _unsaved.back().get();
    };
    const Program* frameProgram = build(kFrame);
    generateSample = frameProgram->GetKernel("generate_sample");
    generateCentre = frameProgram->GetKernel("generate_centre");
    resolve = frameProgram->GetKernel("resolve_addSamples");
    develop = frameProgram->GetKernel("film_develop");
    relativeError = frameProgram->GetKernel("film_relativeError");
    addBlock = frameProgram->GetKernel("film_addBlock");
    const Program* intersectProgram = build(kIntersect);
    intersect = intersectProgram->GetKernel("intersect_closest");
    shade = build(kShade)->GetKernel("shade_paths");
    const Program* shadowProgram = build(kShadow);
    shadowCast = shadowProgram->GetKernel("shadow_cast");
    if (features.firstHits) {
        aov = build(kAov)->GetKernel("aov_firstHit");
    }
    if (features.cutouts) {
        shadowPass = shadowProgram->GetKernel("shadow_pass");
    }
    if (features.streaming) {
        intersectResume = intersectProgram->GetKernel("intersect_resume");
        shadowResume = shadowProgram->GetKernel("shadow_resume");
    }
    for (Kernel* kernel :
         {&intersect, &intersectResume, &shade, &shadowCast, &shadowPass, &shadowResume, &aov}) {
        kernel->SetRunLength(RunLength(*device));
    }
}

void StageKernels::SaveBinaries(Store* store) {
    for (const std::unique_ptr<Program>& program : _unsaved) {
        program->SaveBinary(store);
    }
    _unsaved.clear();
}

void StageKernels::Bind(const SceneBuffers& scene) {
    scene.BindGeometry(&intersect, kIntersectArgs, _features.motion);
    scene.BindScene(&shade, kShadeArgs, _features.motion);
    scene.BindScene(&shadowCast, kShadowCastArgs, _features.motion);
    if (_features.firstHits) {
        scene.BindScene(&aov, kAovArgs, _features.motion);
    }
    if (_features.cutouts) {
        scene.BindScene(&shadowPass, kShadowPassArgs, _features.motion);
    }
    if (_features.streaming) {
        scene.BindGeometry(&intersectResume, kIntersectResumeArgs, _features.motion);
        scene.BindScene(&shadowResume, kShadowResumeArgs, _features.motion);
    }
}

} // namespace hds
