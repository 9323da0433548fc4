// SPDX-License-Identifier: Apache-2.0
#include "hdStream/integrator/kernelSets.h"

#include "hdStream/base/hash.h"
#include "hdStream/device/kernelCompilers.h"
#include "hdStream/integrator/generalKernels.h"

#include <algorithm>
#include <cstring>
#include <iterator>
#include <utility>

namespace hds {

namespace {

/// Of the features that a render has asked for, in the store.
const char* const kFeaturesKind = "features";

/// Of the seconds that renders have spent in general kernels, in the store.
const char* const kSecondsKind = "generalSeconds";

/// Another one for other features, or another device.
std::string SecondsKey(const Device& device, const KernelFeatures& features) {
    Hasher hasher;
    hasher.Append(std::string_view(device.Properties().name));
    for (const auto& [name, value] : features.Defines()) {
        hasher.Append(std::string_view(name));
        hasher.Append(std::string_view(value));
    }
    return hasher.Hex();
}

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
    HDS_VERIFY(!_warmed.valid(), "kernels are asked for while they are still loaded");
    const auto known = std::find_if(_sets.begin(), _sets.end(), [&](const Set& set) {
        return set.kernels->Features() == features;
    });
    if (known != _sets.end()) {
        std::rotate(known, std::next(known), _sets.end());
    } else {
        *buildSeconds +=
            Add(std::make_unique<StageKernels>(_device, _store, features)).BuildSeconds();
    }
    Set& set = _sets.back();
    if (set.boundScene != sceneNumber) {
        set.kernels->Bind(scene);
        set.boundScene = sceneNumber;
    }
    return *set.kernels;
}

StageKernels& KernelSets::Add(std::unique_ptr<StageKernels> kernels) {
    _lacking.erase(SecondsKey(*_device, kernels->Features()));
    if (_sets.size() == _mostSets) {
        _sets.front().kernels->SaveBinaries(_store);
        _sets.erase(_sets.begin());
    }
    _sets.push_back({std::move(kernels)});
    return *_sets.back().kernels;
}

void KernelSets::Remember(const KernelFeatures& features) {
    const bool isKnown = _remembered && *_remembered == features;
    if (_store != nullptr && _store->IsWriting() && !isKnown) {
        _store->Save(kFeaturesKind, FeaturesKey(*_device), &features, sizeof(features));
        _remembered = features;
    }
}

std::optional<KernelFeatures> KernelSets::LoadRemembered() const {
    static_assert(std::is_trivially_copyable_v<KernelFeatures>);
    const auto bytes = _store != nullptr ? _store->Load(kFeaturesKind, FeaturesKey(*_device))
                                         : std::optional<std::vector<std::uint8_t>>();
    if (!bytes || bytes->size() != sizeof(KernelFeatures)) {
        return std::nullopt;
    }
    KernelFeatures features;
    std::memcpy(&features, bytes->data(), sizeof(features));
    return features;
}

void KernelSets::Warm() {
    EndWarm();
    _remembered = LoadRemembered();
    if (!_remembered || Has(*_remembered) || !(*_remembered == _remembered->WithNeeds())) {
        return;
    }
    _warmed = std::async(std::launch::async, [this, features = *_remembered] {
        return StageKernels::FromStore(_device, _store, features);
    });
}

void KernelSets::EndWarm() {
    if (!_warmed.valid()) {
        return;
    }
    try {
        if (std::unique_ptr<StageKernels> kernels = _warmed.get()) {
            Add(std::move(kernels));
        }
    } catch (const Error&) {
        // Who asks for them makes them again, and is told.
    }
}

KernelFeatures KernelSets::Choose(const KernelFeatures& features, KernelChoice choice,
                                  bool mayWait) {
    // Others compile fast enough.
    if (choice == KernelChoice::Own || !_device->Properties().hasSlowBinaries) {
        return features;
    }
    const std::vector<KernelFeatures> sets = GeneralFeatures(features);
    if (choice == KernelChoice::General) {
        return sets.empty() ? features : sets.front();
    }
    const Lack* lack = Has(features) ? nullptr : FindLack(features);
    if (lack == nullptr) {
        return features;
    }
    const auto set = std::find_if(sets.begin(), sets.end(), [this](const KernelFeatures& general) {
        return Has(general) || AreInStore(general);
    });
    const bool hasPaid = mayWait && PayForOwnKernels(lack->generalSeconds);
    return set == sets.end() || hasPaid ? features : *set;
}

bool KernelSets::HaveOwnCome(const KernelFeatures& features, double secondsLeft) {
    if (EndsBeforeOwnKernels(secondsLeft)) {
        return false;
    }
    Lack* lack = FindLack(features);
    if (lack == nullptr) {
        return true;
    }
    if (!lack->awaited.empty()) {
        const bool haveCome =
            std::all_of(lack->awaited.begin(), lack->awaited.end(),
                        [this](const auto& source) { return Program::IsInStore(source, *_store); });
        if (haveCome) {
            _lacking.erase(SecondsKey(*_device, features));
        }
        return haveCome;
    }
    const bool canCompile = _device->Compilers() != nullptr && _device->Compilers()->CanCompile();
    if (canCompile && PayForOwnKernels(lack->generalSeconds + secondsLeft)) {
        lack->awaited = StageKernels::Announce(*_device, _store, features);
    }
    return false;
}

/// Null: they are in the store.
KernelSets::Lack* KernelSets::FindLack(const KernelFeatures& features) {
    const std::string key = SecondsKey(*_device, features);
    const auto known = _lacking.find(key);
    if (known != _lacking.end()) {
        return &known->second;
    }
    if (AreInStore(features)) {
        return nullptr;
    }
    Lack& lack = _lacking[key];
    const auto bytes = _store != nullptr ? _store->Load(kSecondsKind, key)
                                         : std::optional<std::vector<std::uint8_t>>();
    if (bytes && bytes->size() == sizeof(lack.generalSeconds)) {
        std::memcpy(&lack.generalSeconds, bytes->data(), sizeof(lack.generalSeconds));
    }
    return &lack;
}

void KernelSets::AddGeneralSeconds(const KernelFeatures& features, double seconds) {
    Lack* lack = FindLack(features);
    if (lack != nullptr && _store != nullptr && _store->IsWriting()) {
        lack->generalSeconds += seconds;
        _store->Save(kSecondsKind, SecondsKey(*_device, features), &lack->generalSeconds,
                     sizeof(lack->generalSeconds));
    }
}

bool KernelSets::Has(const KernelFeatures& features) const {
    return std::any_of(_sets.begin(), _sets.end(),
                       [&](const Set& set) { return set.kernels->Features() == features; });
}

bool KernelSets::AreInStore(const KernelFeatures& features) const {
    return _store != nullptr && StageKernels::AreInStore(*_device, *_store, features);
}

KernelPlace KernelSets::PlaceOf(const KernelFeatures& features) const {
    return Has(features)          ? KernelPlace::Bound
           : AreInStore(features) ? KernelPlace::Cached
                                  : KernelPlace::Nowhere;
}

void KernelSets::SaveBinaries() {
    for (const Set& set : _sets) {
        set.kernels->SaveBinaries(_store);
    }
}

} // namespace hds
