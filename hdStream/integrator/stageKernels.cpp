// SPDX-License-Identifier: Apache-2.0
#include "hdStream/integrator/stageKernels.h"

#include "hdStream/integrator/shadowLaunches.h"

#include <algorithm>
#include <string>

namespace hds {

namespace {

/// Every field of the path state takes 16 bytes a path (kernels/shared/pathState.def).
constexpr std::uint64_t kFieldBytes = 16;

/// How many fields a path has before the one of that name, or in all.
std::uint64_t NumPathFields(const KernelFeatures& features, const std::string& before = "") {
    // The conditions of fields, spelt as in the kernels.
#define HDS_FEATURE(type, member, macro, off, on, needs, doc) \
    [[maybe_unused]] const bool macro = features.member != off;
#define HDS_VARIANT(member, macro, needs, doc) [[maybe_unused]] const bool macro = features.member;
#include "kernels/shared/features.def"
    const bool HDS_WAIT_LISTS = HDS_KEEPS_WAIT_LISTS;
    const bool HDS_OUTER_WAITS = HDS_KEEPS_OUTER_WAITS;
    const bool HDS_SHADOW_LIGHT = HDS_KEEPS_SHADOW_LIGHT;
    const bool HDS_COLLISION_STATE = HDS_KEEPS_COLLISIONS;
    const bool HDS_MEDIA_LINKS = HDS_KEEPS_MEDIA_LINKS;
    const bool HDS_LIGHT_PATH_STATE = HDS_FOLLOWS_LIGHT_PATHS;
    std::uint64_t count = 0;
#define HDS_PATH_FIELD(condition, type, name, doc) \
    if (before == #name) {                         \
        return count;                              \
    }                                              \
    count += (condition) ? 1 : 0;
#include "kernels/shared/pathState.def"
#undef HDS_PATH_FIELD
    return count + features.lightPaths;
}

/// Items that a work-item of the kernels of queues takes (kernels/integrator/itemLoop.clh).
std::uint32_t ItemsPerWorkItem(const Device& device) {
    return device.Properties().isCpu ? 32 : 1;
}

ProgramDefines MakeDefines(const Device& device, const KernelFeatures& features) {
    ProgramDefines defines = features.Defines();
    defines["HDS_ITEMS_PER_WORK_ITEM"] = std::to_string(ItemsPerWorkItem(device));
    return defines;
}

/// Of all programs, in the order of the table.
std::vector<ProgramSource> MakeSources(const Device& device, const KernelFeatures& features) {
    const ProgramDefines defines = MakeDefines(device, features);
    const KernelFeatures& f = features;
    std::vector<ProgramSource> sources;
#define HDS_PROGRAM(name, root, condition)                                        \
    if (condition) {                                                              \
        sources.push_back(MakeProgramSource(device.Properties(), root, defines)); \
    }
#include "kernels/shared/features.def"
    return sources;
}

bool AreAllInStore(const std::vector<ProgramSource>& sources, const Store& store) {
    return std::all_of(sources.begin(), sources.end(), [&](const ProgramSource& source) {
        return Program::IsInStore(source, store);
    });
}

} // namespace

bool StageKernels::AreInStore(const Device& device, const Store& store,
                              const KernelFeatures& features) {
    return AreAllInStore(MakeSources(device, features), store);
}

std::unique_ptr<StageKernels> StageKernels::FromStore(const std::shared_ptr<Device>& device,
                                                      Store* store,
                                                      const KernelFeatures& features) {
    const std::vector<ProgramSource> sources = MakeSources(*device, features);
    if (!AreAllInStore(sources, *store)) {
        return nullptr;
    }
    return std::unique_ptr<StageKernels>(new StageKernels(device, store, features, sources));
}

std::vector<ProgramSource> StageKernels::Announce(const Device& device, const Store* store,
                                                  const KernelFeatures& features) {
    std::vector<ProgramSource> sources = MakeSources(device, features);
    Program::Announce(device, sources, store);
    return sources;
}

std::uint64_t StageKernels::PathStateBytes(const KernelFeatures& features) {
    return kFieldBytes * NumPathFields(features);
}

std::uint64_t StageKernels::FieldOffset(const KernelFeatures& features, const std::string& field) {
    return kFieldBytes * NumPathFields(features, field);
}

StageKernels::StageKernels(const std::shared_ptr<Device>& device, Store* store,
                           const KernelFeatures& features)
    : StageKernels(device, store, features, MakeSources(*device, features)) {}

StageKernels::StageKernels(const std::shared_ptr<Device>& device, Store* store,
                           const KernelFeatures& features,
                           const std::vector<ProgramSource>& sources)
    : _features(features) {
    HDS_VERIFY(features == features.WithNeeds(),
               "a feature is on without what it needs (kernels/shared/features.def)");
    Program::Announce(*device, sources, store);
    const auto build = [&] {
        _unsaved.push_back(std::make_unique<Program>(device, sources[_unsaved.size()], store));
        _buildSeconds += _unsaved.back()->BuildSeconds();
        return _unsaved.back().get();
    };
    const KernelFeatures& f = features;
#define HDS_PROGRAM(name, root, condition) \
    const Program* name##Program = (condition) ? build() : nullptr;
#include "kernels/shared/features.def"
    generateSample = frameProgram->GetKernel("generate_sample");
    generateCentre = frameProgram->GetKernel("generate_centre");
    resolve = frameProgram->GetKernel("resolve_addSamples");
    develop = frameProgram->GetKernel("film_develop");
    relativeVariance = frameProgram->GetKernel("film_relativeVariance");
    relativeError = frameProgram->GetKernel("film_relativeError");
    addBlock = frameProgram->GetKernel("film_addBlock");
    if (features.lightPaths > 0) {
        addLightPaths = frameProgram->GetKernel("resolve_addLightPaths");
        developLightPath = frameProgram->GetKernel("film_developLightPath");
    }
    const bool tracesMore = features.catchers || features.occlusion;
    if (features.lightPaths > 0 || tracesMore) {
        addLightPathBlock = frameProgram->GetKernel("film_addLightPathBlock");
    }
    if (tracesMore) {
        keepSamples = frameProgram->GetKernel("resolve_keepSamples");
    }
    if (features.occlusion) {
        occlusion = occlusionProgram->GetKernel("occlusion_steps");
        addOcclusion = frameProgram->GetKernel("resolve_addOcclusion");
        developOcclusion = frameProgram->GetKernel("film_developOcclusion");
    }
    if (features.catchers) {
        addCatchers = frameProgram->GetKernel("resolve_addCatchers");
        developCatchers = frameProgram->GetKernel("film_developCatchers");
        addCaughtVariance = frameProgram->GetKernel("film_addCaughtVariance");
    }
    intersect = intersectProgram->GetKernel("intersect_closest");
    shade = shadeProgram->GetKernel("shade_paths");
    shadowCast = shadowProgram->GetKernel("shadow_cast");
    if (features.firstHits) {
        aov = aovProgram->GetKernel("aov_firstHit");
    }
    if (features.cutouts && !PassesShadowsAtOnce(features)) {
        shadowPass = shadowProgram->GetKernel("shadow_pass");
    }
    if (features.HasLists()) {
        keepSums = frameProgram->GetKernel("resolve_keepSums");
    }
    if (features.streaming) {
        intersectResume = intersectProgram->GetKernel("intersect_resume");
        shadowResume = shadowProgram->GetKernel("shadow_resume");
    }
    for (Kernel* kernel : {&generateSample, &intersect, &intersectResume, &shade, &shadowCast,
                           &shadowPass, &shadowResume, &aov, &occlusion}) {
        kernel->SetItemsPerWorkItem(ItemsPerWorkItem(*device));
    }
}

void StageKernels::SaveBinaries(Store* store) {
    for (const std::unique_ptr<Program>& program : _unsaved) {
        program->SaveBinary(store);
    }
    _unsaved.clear();
}

void StageKernels::Bind(const SceneBuffers& scene) {
    const auto bindGeometry = [&](Kernel* kernel) {
        kernel->KeepFirst(scene.BindGeometry(kernel, 0, _features));
    };
    const auto bindScene = [&](Kernel* kernel) {
        kernel->KeepFirst(scene.BindScene(kernel, 0, _features));
    };
    bindGeometry(&intersect);
    bindScene(&shade);
    bindScene(&shadowCast);
    if (_features.firstHits) {
        bindScene(&aov);
    }
    if (_features.occlusion) {
        bindScene(&occlusion);
    }
    if (_features.cutouts && !PassesShadowsAtOnce(_features)) {
        bindScene(&shadowPass);
    }
    if (_features.streaming) {
        bindGeometry(&intersectResume);
        bindScene(&shadowResume);
    }
}

} // namespace hds
