// SPDX-License-Identifier: Apache-2.0
#include "hdStream/integrator/kernelSets.h"

#include <algorithm>
#include <iterator>
#include <utility>

namespace hds {

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
        auto kernels = std::make_unique<StageKernels>(_device, _store, features);
        *buildSeconds += kernels->BuildSeconds();
        if (_sets.size() == _mostSets) {
            _sets.front().kernels->SaveBinaries(_store);
            _sets.erase(_sets.begin());
        }
        _sets.push_back({std::move(kernels)});
    }
    Set& set = _sets.back();
    if (set.boundScene != sceneNumber) {
        set.kernels->Bind(scene);
        set.boundScene = sceneNumber;
    }
    return *set.kernels;
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
