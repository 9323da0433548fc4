// SPDX-License-Identifier: Apache-2.0
// What is asked of the cache's folder without a session.
#include "hdStream/device/kernelCompilers.h"
#include "hdStream/integrator/generalKernels.h"
#include "hdStream/integrator/stageKernels.h"
#include "hdStream/persist/stagePages.h"
#include "hdStream/session/session.h"
#include "hdStream/texture/texturePool.h"

#include <algorithm>
#include <memory>

namespace hds {

namespace {

/// The folder's page store as files: its index is not read.
PageStore UnopenedPages(const std::string& directory) {
    return {{directory, false}, nullptr};
}

} // namespace

CacheState InspectCache(const std::string& directory) {
    Store store({directory, true}, nullptr);
    PageStoreOptions options{directory};
    options.isReadOnly = true;
    const PageStore pages(options, nullptr);
    CacheState state;
    state.directory = store.Directory();
    state.bytes = store.Size() + pages.Size();
    PageAmount rest;
    for (const StagePages& stage : ListStagePages(&store, pages, &rest)) {
        state.stages.push_back({stage.stage, stage.amount.pages, stage.amount.bytes});
    }
    state.otherPages = rest.pages;
    state.otherBytes = rest.bytes;
    return state;
}

std::uint64_t ClearCache(const std::string& directory) {
    return Store({directory, true}, nullptr).Clear() + UnopenedPages(directory).Clear();
}

std::vector<std::string> PrepareKernels(const std::string& device, const std::string& directory) {
    Warnings warnings;
    const std::shared_ptr<Device> chosen = Device::Create(device);
    Store store({directory, true}, &warnings);
    if (!chosen->Properties().hasSlowBinaries || !store.IsWriting()) {
        return warnings.Lines();
    }
    chosen->SetCompilers(
        std::make_unique<KernelCompilers>(chosen->Properties(), &store, &warnings));
    std::vector<KernelFeatures> sets = AllGeneralFeatures();
    sets.erase(std::remove_if(sets.begin(), sets.end(),
                              [&](const KernelFeatures& features) {
                                  return StageKernels::AreInStore(*chosen, store, features);
                              }),
               sets.end());
    const ProgramSource anyScenes = TexturePool::KernelSource(*chosen);
    Program::Announce(*chosen, {anyScenes}, &store);
    for (const KernelFeatures& features : sets) {
        StageKernels::Announce(*chosen, &store, features);
    }
    Program(chosen, anyScenes, &store).SaveBinary(&store);
    for (const KernelFeatures& features : sets) {
        StageKernels(chosen, &store, features).SaveBinaries(&store);
    }
    chosen->SetCompilers(nullptr); // they write to the store
    return warnings.Lines();
}

} // namespace hds
