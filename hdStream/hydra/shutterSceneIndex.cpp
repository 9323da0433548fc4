// SPDX-License-Identifier: Apache-2.0
#include "hdStream/hydra/shutterSceneIndex.h"

#include <pxr/imaging/hd/cameraSchema.h>
#include <pxr/imaging/hd/primvarsSchema.h>
#include <pxr/imaging/hd/sceneIndexPrimView.h>
#include <pxr/imaging/hd/tokens.h>
#include <pxr/imaging/hd/xformSchema.h>

PXR_NAMESPACE_OPEN_SCOPE

namespace {

double ValueOf(const HdSampledDataSourceHandle& source) {
    const VtValue value = source ? source->GetValue(0.0F) : VtValue();
    return VtValue::Cast<double>(value).GetWithDefault(0.0);
}

} // namespace

HdSceneIndexBaseRefPtr HdStreamShutterSceneIndex::New(const HdSceneIndexBaseRefPtr& inputScene) {
    return TfCreateRefPtr(new HdStreamShutterSceneIndex(inputScene));
}

HdStreamShutterSceneIndex::HdStreamShutterSceneIndex(const HdSceneIndexBaseRefPtr& inputScene)
    : HdSingleInputFilteringSceneIndexBase(inputScene) {
    for (const SdfPath& path : HdSceneIndexPrimView(inputScene)) {
        Update(path);
    }
}

HdSceneIndexPrim HdStreamShutterSceneIndex::GetPrim(const SdfPath& path) const {
    return _GetInputSceneIndex()->GetPrim(path);
}

SdfPathVector HdStreamShutterSceneIndex::GetChildPrimPaths(const SdfPath& path) const {
    return _GetInputSceneIndex()->GetChildPrimPaths(path);
}

bool HdStreamShutterSceneIndex::Update(const SdfPath& camera) {
    const HdSceneIndexPrim prim = GetPrim(camera);
    std::pair<double, double> shutter(0.0, 0.0);
    if (prim.primType == HdPrimTypeTokens->camera) {
        const HdCameraSchema schema = HdCameraSchema::GetFromParent(prim.dataSource);
        if (schema) {
            shutter = {ValueOf(schema.GetShutterOpen()), ValueOf(schema.GetShutterClose())};
        }
    }
    const auto known = _shutters.find(camera);
    const bool isOpen = shutter.first < shutter.second;
    if (known == _shutters.end()) {
        if (isOpen) {
            _shutters[camera] = shutter;
        }
        return isOpen;
    }
    if (known->second == shutter) {
        return false;
    }
    if (isOpen) {
        known->second = shutter;
    } else {
        _shutters.erase(known);
    }
    return true;
}

void HdStreamShutterSceneIndex::DirtyWhatMoves() {
    static const HdDataSourceLocatorSet ofGprims{HdXformSchema::GetDefaultLocator(),
                                                 HdPrimvarsSchema::GetPointsLocator()};
    static const HdDataSourceLocatorSet ofInstancers{HdXformSchema::GetDefaultLocator(),
                                                     HdPrimvarsSchema::GetDefaultLocator()};
    static const HdDataSourceLocatorSet ofLights{HdXformSchema::GetDefaultLocator()};
    HdSceneIndexObserver::DirtiedPrimEntries entries;
    for (const SdfPath& path : HdSceneIndexPrimView(_GetInputSceneIndex())) {
        const TfToken type = GetPrim(path).primType;
        if (type == HdPrimTypeTokens->instancer) {
            entries.emplace_back(path, ofInstancers);
        } else if (HdPrimTypeIsGprim(type)) {
            entries.emplace_back(path, ofGprims);
        } else if (HdPrimTypeIsLight(type)) {
            entries.emplace_back(path, ofLights);
        }
    }
    _SendPrimsDirtied(entries);
}

void HdStreamShutterSceneIndex::_PrimsAdded(const HdSceneIndexBase&,
                                            const HdSceneIndexObserver::AddedPrimEntries& entries) {
    _SendPrimsAdded(entries);
    bool isChanged = false;
    for (const HdSceneIndexObserver::AddedPrimEntry& entry : entries) {
        if (entry.primType == HdPrimTypeTokens->camera) {
            isChanged = Update(entry.primPath) || isChanged;
        }
    }
    if (isChanged) {
        DirtyWhatMoves();
    }
}

void HdStreamShutterSceneIndex::_PrimsRemoved(
    const HdSceneIndexBase&, const HdSceneIndexObserver::RemovedPrimEntries& entries) {
    for (const HdSceneIndexObserver::RemovedPrimEntry& entry : entries) {
        auto camera = _shutters.lower_bound(entry.primPath);
        while (camera != _shutters.end() && camera->first.HasPrefix(entry.primPath)) {
            camera = _shutters.erase(camera);
        }
    }
    _SendPrimsRemoved(entries);
}

void HdStreamShutterSceneIndex::_PrimsDirtied(
    const HdSceneIndexBase&, const HdSceneIndexObserver::DirtiedPrimEntries& entries) {
    static const HdDataSourceLocatorSet shutter{HdCameraSchema::GetShutterOpenLocator(),
                                                HdCameraSchema::GetShutterCloseLocator()};
    _SendPrimsDirtied(entries);
    bool isChanged = false;
    for (const HdSceneIndexObserver::DirtiedPrimEntry& entry : entries) {
        if (entry.dirtyLocators.Intersects(shutter) &&
            GetPrim(entry.primPath).primType == HdPrimTypeTokens->camera) {
            isChanged = Update(entry.primPath) || isChanged;
        }
    }
    if (isChanged) {
        DirtyWhatMoves();
    }
}

PXR_NAMESPACE_CLOSE_SCOPE
