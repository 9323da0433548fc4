// SPDX-License-Identifier: Apache-2.0
#include "hdStream/hydra/editSceneIndex.h"

#include <pxr/imaging/hd/collectionsSchema.h>
#include <pxr/imaging/hd/instancerTopologySchema.h>
#include <pxr/imaging/hd/lightSchema.h>
#include <pxr/imaging/hd/materialBindingsSchema.h>
#include <pxr/imaging/hd/sceneIndexPrimView.h>
#include <pxr/imaging/hd/tokens.h>
#include <pxr/imaging/hd/visibilitySchema.h>

#include <algorithm>

PXR_NAMESPACE_OPEN_SCOPE

namespace {

VtValue LightValue(const HdContainerDataSourceHandle& prim, const TfToken& name) {
    const HdContainerDataSourceHandle light = HdLightSchema::GetFromParent(prim).GetContainer();
    const auto source = light ? HdSampledDataSource::Cast(light->Get(name)) : nullptr;
    return source ? source->GetValue(0.0F) : VtValue();
}

SdfPathVector FiltersOf(const HdContainerDataSourceHandle& prim) {
    const VtValue value = LightValue(prim, HdTokens->filters);
    if (value.IsHolding<VtArray<SdfPath>>()) { // of scene indices
        const VtArray<SdfPath>& paths = value.UncheckedGet<VtArray<SdfPath>>();
        return SdfPathVector(paths.cbegin(), paths.cend());
    }
    return value.GetWithDefault(SdfPathVector());
}

/// True for a light of a legacy delegate that does not light, or shadow, all there is.
bool Links(const HdContainerDataSourceHandle& prim) {
    const auto isNamed = [&prim](const TfToken& name) {
        return !LightValue(prim, name).GetWithDefault(TfToken()).IsEmpty();
    };
    return prim && prim->Get(HdSceneIndexEmulationTokens->sceneDelegate) &&
           (isNamed(HdTokens->lightLink) || isNamed(HdTokens->shadowLink));
}

} // namespace

HdSceneIndexBaseRefPtr HdStreamEditSceneIndex::New(const HdSceneIndexBaseRefPtr& inputScene) {
    return TfCreateRefPtr(new HdStreamEditSceneIndex(inputScene));
}

HdStreamEditSceneIndex::HdStreamEditSceneIndex(const HdSceneIndexBaseRefPtr& inputScene)
    : HdSingleInputFilteringSceneIndexBase(inputScene) {
    for (const SdfPath& path : HdSceneIndexPrimView(inputScene)) {
        Learn(path, inputScene->GetPrim(path).primType);
    }
}

HdSceneIndexPrim HdStreamEditSceneIndex::GetPrim(const SdfPath& path) const {
    return _GetInputSceneIndex()->GetPrim(path);
}

SdfPathVector HdStreamEditSceneIndex::GetChildPrimPaths(const SdfPath& path) const {
    return _GetInputSceneIndex()->GetChildPrimPaths(path);
}

void HdStreamEditSceneIndex::Learn(const SdfPath& path, const TfToken& primType) {
    if (primType == HdPrimTypeTokens->instancer) {
        _instancers.insert(path);
    } else {
        _instancers.erase(path);
    }
    const bool isLight = HdPrimTypeIsLight(primType);
    const HdContainerDataSourceHandle prim = isLight ? GetPrim(path).dataSource : nullptr;
    SetFilters(path, prim ? FiltersOf(prim) : SdfPathVector());
    if (Links(prim)) {
        _linkingLights.insert(path);
    } else {
        _linkingLights.erase(path);
    }
}

void HdStreamEditSceneIndex::SetFilters(const SdfPath& light, const SdfPathVector& filters) {
    if (const auto known = _filtersByLight.find(light); known != _filtersByLight.end()) {
        for (const SdfPath& filter : known->second) {
            _lightsByFilter[filter].erase(light);
            if (_lightsByFilter[filter].empty()) {
                _lightsByFilter.erase(filter);
            }
        }
        _filtersByLight.erase(known);
    }
    for (const SdfPath& filter : filters) {
        _lightsByFilter[filter].insert(light);
    }
    if (!filters.empty()) {
        _filtersByLight[light] = filters;
    }
}

void HdStreamEditSceneIndex::Forget(const SdfPath& path) {
    const auto isBelow = [&path](const SdfPath& other) { return other.HasPrefix(path); };
    for (auto it = _filtersByLight.lower_bound(path);
         it != _filtersByLight.end() && isBelow(it->first);
         it = _filtersByLight.lower_bound(path)) {
        SetFilters(SdfPath(it->first), {});
    }
    for (SdfPathSet* paths : {&_linkingLights, &_instancers}) {
        const auto begin = paths->lower_bound(path);
        paths->erase(begin, std::find_if_not(begin, paths->end(), isBelow));
    }
}

void HdStreamEditSceneIndex::AddLightsOf(const SdfPath& filter,
                                         HdSceneIndexObserver::DirtiedPrimEntries* entries) {
    if (const auto found = _lightsByFilter.find(filter); found != _lightsByFilter.end()) {
        for (const SdfPath& light : found->second) {
            entries->push_back({light, HdLightSchema::GetDefaultLocator()});
        }
    }
}

void HdStreamEditSceneIndex::AddInstancers(HdSceneIndexObserver::DirtiedPrimEntries* entries) {
    for (const SdfPath& instancer : _instancers) {
        entries->push_back({instancer, HdInstancerTopologySchema::GetDefaultLocator()});
    }
}

void HdStreamEditSceneIndex::_PrimsAdded(const HdSceneIndexBase&,
                                         const HdSceneIndexObserver::AddedPrimEntries& entries) {
    _SendPrimsAdded(entries);
    HdSceneIndexObserver::DirtiedPrimEntries dirtied;
    bool hasLinks = false;
    for (const HdSceneIndexObserver::AddedPrimEntry& entry : entries) {
        Learn(entry.primPath, entry.primType);
        hasLinks |= _linkingLights.count(entry.primPath) > 0;
    }
    for (const HdSceneIndexObserver::AddedPrimEntry& entry : entries) {
        AddLightsOf(entry.primPath, &dirtied);
    }
    if (hasLinks) {
        AddInstancers(&dirtied);
    }
    if (!dirtied.empty()) {
        _SendPrimsDirtied(dirtied);
    }
}

void HdStreamEditSceneIndex::_PrimsRemoved(
    const HdSceneIndexBase&, const HdSceneIndexObserver::RemovedPrimEntries& entries) {
    _SendPrimsRemoved(entries);
    for (const HdSceneIndexObserver::RemovedPrimEntry& entry : entries) {
        Forget(entry.primPath);
    }
    HdSceneIndexObserver::DirtiedPrimEntries dirtied;
    for (const HdSceneIndexObserver::RemovedPrimEntry& entry : entries) {
        for (auto it = _lightsByFilter.lower_bound(entry.primPath);
             it != _lightsByFilter.end() && it->first.HasPrefix(entry.primPath); ++it) {
            AddLightsOf(it->first, &dirtied);
        }
    }
    if (!dirtied.empty()) {
        _SendPrimsDirtied(dirtied);
    }
}

void HdStreamEditSceneIndex::_PrimsDirtied(
    const HdSceneIndexBase&, const HdSceneIndexObserver::DirtiedPrimEntries& entries) {
    const auto forward = [this](const TfToken& primType, const HdDataSourceLocator& from,
                                const HdDataSourceLocator& to,
                                HdSceneIndexObserver::DirtiedPrimEntry* entry) {
        if (entry->dirtyLocators.Intersects(from) && !entry->dirtyLocators.Intersects(to) &&
            GetPrim(entry->primPath).primType == primType) {
            entry->dirtyLocators.insert(to);
        }
    };
    HdSceneIndexObserver::DirtiedPrimEntries result = entries;
    bool hasLinks = false;
    for (std::size_t i = 0; i < entries.size(); ++i) {
        forward(HdPrimTypeTokens->instancer, HdVisibilitySchema::GetDefaultLocator(),
                HdInstancerTopologySchema::GetDefaultLocator(), &result[i]);
        forward(HdPrimTypeTokens->mesh, HdLightSchema::GetDefaultLocator(),
                HdMaterialBindingsSchema::GetDefaultLocator(), &result[i]);
        const auto& [path, locators] = entries[i];
        if (locators.Intersects(HdLightSchema::GetDefaultLocator()) ||
            locators.Intersects(HdCollectionsSchema::GetDefaultLocator())) {
            // Links may have been there before, or be there now; which of a light's values changed
            // legacy delegates do not say.
            hasLinks |= _linkingLights.count(path) > 0;
            Learn(path, GetPrim(path).primType);
            hasLinks |= _linkingLights.count(path) > 0;
        }
        AddLightsOf(path, &result);
    }
    if (hasLinks) {
        AddInstancers(&result);
    }
    _SendPrimsDirtied(result);
}

PXR_NAMESPACE_CLOSE_SCOPE
