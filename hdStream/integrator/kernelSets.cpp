// SPDX-License-Identifier: Apache-2.0
#include "hdStream/integrator/kernelSets.h"

#include "hdStream/base/hash.h"

#include <algorithm>
#include <cstring>
#include <iterator>
#include <utility>

namespace hds {

namespace {

/// Of the features that a render has asked for, in the store.
const char* const kFeaturesKind = "features";

/// Another one for another device or table of features.
std::string FeaturesKey(const Device& device) {
    Hasher hasher;
    hasher.Append(std::string_view(device.Properties().name));
    for (const auto& [name, value] : KernelFeatures().Defines()) {
        hasher.Append(std::string_view(name));
    }
    hasher.Append(std::uint64_t{sizeof(KernelFeatures)});
    return hasher.Hex();
}

} // namespace

KernelSets::KernelSets(std::shared_ptr<Device> device, Store* store, std::size_t mostSets)
    : _device(std::move(device)), _store(store), _mostSets(mostSets) {}

StageKernels& KernelSets::Get(const KernelFeatures& features, const SceneBuffers& scene,
                              std::uint64_t sceneNumber, double* buildSeconds) {
    const auto known = std::find_if(_sets.begin(), _sets.end(), [&](const Set& set) {
        return set.kernels->Features() == features;
    });
    if (known != _sets.end()) {
        std::rotate(known, std::next(known), _sets.end());
    } else {
        *buildSeconds += Add(features).BuildSeconds();
    }
    Set& set = _sets.back();
    if (set.boundScene != sceneNumber) {
        set.kernels->Bind(scene);
        set.boundScene = sceneNumber;
    }
    return *set.kernels;
}

StageKernels& KernelSets::Add(const KernelFeatures& features) {
    auto kernels = std::make_unique<StageKernels>(_device, _store, features);
    if (_sets.size() == _mostSets) {
        _sets.front().kernels->SaveBinaries(_store);
        _sets.erase(_sets.begin());
    }
    _sets.push_back({std::move(kernels)});
    return *_sets.back().kernels;
}

void KernelSets::Remember(const KernelFeatures& features) {
    const bool isKnown = _remembered && *_remembered == features;
    if (_store != nullptr && _store->IsEnabled() && !isKnown) {
        _store->Save(kFeaturesKind, FeaturesKey(*_device), &features, sizeof(features));
        _remembered = features;
    }
}

void KernelSets::Warm() {
    static_assert(std::is_trivially_copyable_v<KernelFeatures>);
    const auto bytes = _store != nullptr ? _store->Load(kFeaturesKind, FeaturesKey(*_device))
                                         : std::optional<std::vector<std::uint8_t>>();
    if (!bytes || bytes->size() != sizeof(KernelFeatures)) {
        return;
    }
    KernelFeatures features;
    std::memcpy(&features, bytes->data(), sizeof(features));
    _remembered = features;
    if (!Has(features) && features == features.WithNeeds() && AreInStore(features)) {
        Add(features);
    }
}

bool KernelSets::Has(const KernelFeatures& features) const {
    return std::any_of(_sets.begin(), _sets.end(),
                       [&](const Set& set) { return set.kernels->Features() == features; });
}

bool KernelSets::AreInStore(const KernelFeatures& features) const {
    return _store != nullptr && StageKernels::AreInStore(*_device, *_store, features);
}

void KernelSets::SaveBinaries() {
    for (const Set& set : _sets) {
        set.kernels->SaveBinaries(_store);
    }
}

} // namespace hds
