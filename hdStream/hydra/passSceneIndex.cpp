// SPDX-License-Identifier: Apache-2.0
#include "hdStream/hydra/passSceneIndex.h"

#include "hdStream/hydra/lightParameters.h"

#include <pxr/base/vt/array.h>
#include <pxr/imaging/hd/instancerTopologySchema.h>
#include <pxr/imaging/hd/lightSchema.h>
#include <pxr/imaging/hd/overlayContainerDataSource.h>
#include <pxr/imaging/hd/primvarSchema.h>
#include <pxr/imaging/hd/primvarsSchema.h>
#include <pxr/imaging/hd/retainedDataSource.h>
#include <pxr/imaging/hd/sceneIndexPrimView.h>
#include <pxr/imaging/hd/tokens.h>
#include <pxr/imaging/hd/visibilitySchema.h>

#include <algorithm>
#include <functional>
#include <iterator>
#include <utility>
#include <vector>

PXR_NAMESPACE_OPEN_SCOPE

namespace {

const TfToken kSeenByCamera("hdstream:pass:camera");
const TfToken kHoldout("hdstream:pass:matte");

HdContainerDataSourceHandle Primvar(const HdSampledDataSourceHandle& value,
                                    const TfToken& interpolation) {
    return HdPrimvarSchema::Builder()
        .SetPrimvarValue(value)
        .SetInterpolation(HdPrimvarSchema::BuildInterpolationDataSource(interpolation))
        .Build();
}

HdContainerDataSourceHandle Constant(float value) {
    return Primvar(HdRetainedTypedSampledDataSource<float>::New(value),
                   HdPrimvarSchemaTokens->constant);
}

/// Members of a container; those that are null are left out.
HdContainerDataSourceHandle
Container(const std::vector<std::pair<TfToken, HdDataSourceBaseHandle>>& members) {
    std::vector<TfToken> names;
    std::vector<HdDataSourceBaseHandle> values;
    for (const auto& [name, value] : members) {
        if (value) {
            names.push_back(name);
            values.push_back(value);
        }
    }
    return names.empty()
               ? nullptr
               : HdRetainedContainerDataSource::New(names.size(), names.data(), values.data());
}

/// An instance-rate primvar of 0 and 1; null where none of them is `wanted`.
HdContainerDataSourceHandle
ByInstance(const std::vector<HdStreamPassOfInstance>& instances, bool wanted,
           const std::function<bool(const HdStreamPassOfInstance&)>& valueOf) {
    VtArray<float> values(instances.size());
    std::transform(instances.begin(), instances.end(), values.begin(),
                   [&](const auto& instance) { return valueOf(instance) ? 1.0F : 0.0F; });
    if (std::find(values.cbegin(), values.cend(), wanted ? 1.0F : 0.0F) == values.cend()) {
        return nullptr;
    }
    return Primvar(HdRetainedTypedSampledDataSource<VtArray<float>>::New(values),
                   HdPrimvarSchemaTokens->instance);
}

const HdDataSourceLocatorSet& LocatorsOfPasses() {
    static const HdDataSourceLocatorSet locators{
        HdVisibilitySchema::GetDefaultLocator(), HdPrimvarsSchema::GetDefaultLocator(),
        HdInstancerTopologySchema::GetDefaultLocator(), HdLightSchema::GetDefaultLocator()};
    return locators;
}

} // namespace

HdSceneIndexBaseRefPtr HdStreamPassSceneIndex::New(const HdSceneIndexBaseRefPtr& inputScene) {
    return TfCreateRefPtr(new HdStreamPassSceneIndex(inputScene));
}

HdStreamPassSceneIndex::HdStreamPassSceneIndex(const HdSceneIndexBaseRefPtr& inputScene)
    : HdSingleInputFilteringSceneIndexBase(inputScene),
      _pass(std::make_unique<HdStreamPassMembership>(inputScene)) {}

HdSceneIndexPrim HdStreamPassSceneIndex::GetPrim(const SdfPath& path) const {
    if (!_pass->IsActive()) {
        return _GetInputSceneIndex()->GetPrim(path);
    }
    if (_pass->IsPruned(path)) {
        return {};
    }
    HdSceneIndexPrim prim = _GetInputSceneIndex()->GetPrim(path);
    if (!prim.dataSource) {
        return prim;
    }
    HdContainerDataSourceHandle added;
    if (prim.primType == HdPrimTypeTokens->instancer) {
        added = OfInstancer(path, prim);
    } else if (HdStreamIsInPasses(prim.primType)) {
        added = OfGprim(path, prim);
    }
    if (added) {
        prim.dataSource = HdOverlayContainerDataSource::New(added, prim.dataSource);
    }
    return prim;
}

HdContainerDataSourceHandle HdStreamPassSceneIndex::OfGprim(const SdfPath& path,
                                                            const HdSceneIndexPrim& prim) const {
    static const HdContainerDataSourceHandle invisible =
        HdVisibilitySchema::Builder()
            .SetVisibility(HdRetainedTypedSampledDataSource<bool>::New(false))
            .Build();
    static const HdContainerDataSourceHandle no = Constant(0.0F);
    static const HdContainerDataSourceHandle yes = Constant(1.0F);
    static const HdContainerDataSourceHandle hiddenLight = Container(
        {{kHdStreamLightSeenByCamera, HdRetainedTypedSampledDataSource<bool>::New(false)}});
    const HdStreamPassFlags flags = _pass->FlagsOf(path);
    const bool isLight = HdPrimTypeIsLight(prim.primType);
    const bool isHidden = !flags.isSeenByCamera;
    return Container({
        {HdVisibilitySchema::GetSchemaToken(), flags.isRendered ? nullptr : invisible},
        {HdLightSchema::GetSchemaToken(), isLight && isHidden ? hiddenLight : nullptr},
        {HdPrimvarsSchema::GetSchemaToken(),
         isLight ? nullptr
                 : Container({{kSeenByCamera, isHidden ? no : nullptr},
                              {kHoldout, flags.isMatte ? yes : nullptr}})},
    });
}

HdContainerDataSourceHandle
HdStreamPassSceneIndex::OfInstancer(const SdfPath& path, const HdSceneIndexPrim& prim) const {
    const std::vector<HdStreamPassOfInstance> instances = _pass->FlagsOfInstances(path);
    if (instances.empty()) {
        return nullptr;
    }
    const HdBoolArrayDataSourceHandle source =
        HdInstancerTopologySchema::GetFromParent(prim.dataSource).GetMask();
    VtArray<bool> mask = source ? source->GetTypedValue(0.0F) : VtArray<bool>();
    const bool isMasked = std::any_of(instances.begin(), instances.end(), [](const auto& instance) {
        return instance.isPruned || !instance.flags.isRendered;
    });
    if (isMasked && mask.size() != instances.size()) {
        mask.assign(instances.size(), true);
    }
    for (std::size_t i = 0; isMasked && i < instances.size(); ++i) {
        mask[i] = mask[i] && !instances[i].isPruned && instances[i].flags.isRendered;
    }
    return Container({
        {HdInstancerTopologySchema::GetSchemaToken(),
         isMasked ? HdInstancerTopologySchema::Builder()
                        .SetMask(HdRetainedTypedSampledDataSource<VtArray<bool>>::New(mask))
                        .Build()
                  : nullptr},
        {HdPrimvarsSchema::GetSchemaToken(),
         Container(
             {{kSeenByCamera,
               ByInstance(instances, false,
                          [](const auto& found) { return found.flags.isSeenByCamera; })},
              {kHoldout, ByInstance(instances, true,
                                    [](const auto& found) { return found.flags.isMatte; })}})},
    });
}

SdfPathVector HdStreamPassSceneIndex::GetChildPrimPaths(const SdfPath& path) const {
    SdfPathVector children = _GetInputSceneIndex()->GetChildPrimPaths(path);
    if (_pass->IsActive()) {
        children.erase(
            std::remove_if(children.begin(), children.end(),
                           [this](const SdfPath& child) { return _pass->IsPruned(child); }),
            children.end());
    }
    return children;
}

template <typename Entries>
Entries HdStreamPassSceneIndex::WithoutPruned(const Entries& entries) const {
    Entries kept;
    std::copy_if(entries.begin(), entries.end(), std::back_inserter(kept),
                 [this](const auto& entry) { return !_pass->IsPruned(entry.primPath); });
    return kept;
}

template <typename Entries>
void HdStreamPassSceneIndex::UpdatePass(const Entries& entries) {
    const SdfPath path = _pass->Path();
    const bool isPossible = std::any_of(entries.begin(), entries.end(), [&path](const auto& entry) {
        return entry.primPath.IsAbsoluteRootPath() ||
               (!path.IsEmpty() && path.HasPrefix(entry.primPath));
    });
    if (isPossible) {
        auto before = std::make_unique<HdStreamPassMembership>(_GetInputSceneIndex());
        std::swap(_pass, before);
        if (!_pass->IsSame(*before)) {
            SendChanges(*before);
        }
    }
}

void HdStreamPassSceneIndex::SendChanges(const HdStreamPassMembership& before) {
    HdSceneIndexObserver::AddedPrimEntries added;
    HdSceneIndexObserver::RemovedPrimEntries removed;
    HdSceneIndexObserver::DirtiedPrimEntries dirtied;
    for (const SdfPath& path : HdSceneIndexPrimView(_GetInputSceneIndex())) {
        const TfToken type = _GetInputSceneIndex()->GetPrim(path).primType;
        const bool wasPruned = before.IsPruned(path);
        const bool isPruned = _pass->IsPruned(path);
        if (wasPruned && !isPruned) {
            added.push_back({path, type});
        } else if (isPruned && !wasPruned) {
            removed.push_back({path});
        } else if (!isPruned && (type == HdPrimTypeTokens->instancer || HdStreamIsInPasses(type))) {
            dirtied.push_back({path, LocatorsOfPasses()});
        }
    }
    _SendPrimsRemoved(removed);
    _SendPrimsAdded(added);
    _SendPrimsDirtied(dirtied);
}

void HdStreamPassSceneIndex::_PrimsAdded(const HdSceneIndexBase&,
                                         const HdSceneIndexObserver::AddedPrimEntries& entries) {
    _pass->Forget();
    _SendPrimsAdded(_pass->IsActive() ? WithoutPruned(entries) : entries);
    UpdatePass(entries);
}

void HdStreamPassSceneIndex::_PrimsRemoved(
    const HdSceneIndexBase&, const HdSceneIndexObserver::RemovedPrimEntries& entries) {
    _pass->Forget();
    _SendPrimsRemoved(entries);
    UpdatePass(entries);
}

void HdStreamPassSceneIndex::_PrimsDirtied(
    const HdSceneIndexBase&, const HdSceneIndexObserver::DirtiedPrimEntries& entries) {
    _pass->Forget();
    _SendPrimsDirtied(_pass->IsActive() ? WithoutPruned(entries) : entries);
    UpdatePass(entries);
}

PXR_NAMESPACE_CLOSE_SCOPE
