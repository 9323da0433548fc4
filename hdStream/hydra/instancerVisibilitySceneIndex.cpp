// SPDX-License-Identifier: Apache-2.0
#include "hdStream/hydra/instancerVisibilitySceneIndex.h"

#include <pxr/imaging/hd/instancerTopologySchema.h>
#include <pxr/imaging/hd/tokens.h>
#include <pxr/imaging/hd/visibilitySchema.h>

PXR_NAMESPACE_OPEN_SCOPE

HdSceneIndexBaseRefPtr
HdStreamInstancerVisibilitySceneIndex::New(const HdSceneIndexBaseRefPtr& inputScene) {
    return TfCreateRefPtr(new HdStreamInstancerVisibilitySceneIndex(inputScene));
}

HdStreamInstancerVisibilitySceneIndex::HdStreamInstancerVisibilitySceneIndex(
    const HdSceneIndexBaseRefPtr& inputScene)
    : HdSingleInputFilteringSceneIndexBase(inputScene) {}

HdSceneIndexPrim HdStreamInstancerVisibilitySceneIndex::GetPrim(const SdfPath& path) const {
    return _GetInputSceneIndex()->GetPrim(path);
}

SdfPathVector HdStreamInstancerVisibilitySceneIndex::GetChildPrimPaths(const SdfPath& path) const {
    return _GetInputSceneIndex()->GetChildPrimPaths(path);
}

void HdStreamInstancerVisibilitySceneIndex::_PrimsAdded(
    const HdSceneIndexBase&, const HdSceneIndexObserver::AddedPrimEntries& entries) {
    _SendPrimsAdded(entries);
}

void HdStreamInstancerVisibilitySceneIndex::_PrimsRemoved(
    const HdSceneIndexBase&, const HdSceneIndexObserver::RemovedPrimEntries& entries) {
    _SendPrimsRemoved(entries);
}

void HdStreamInstancerVisibilitySceneIndex::_PrimsDirtied(
    const HdSceneIndexBase&, const HdSceneIndexObserver::DirtiedPrimEntries& entries) {
    const HdDataSourceLocator& visibility = HdVisibilitySchema::GetDefaultLocator();
    const HdDataSourceLocator& topology = HdInstancerTopologySchema::GetDefaultLocator();
    HdSceneIndexObserver::DirtiedPrimEntries result = entries;
    for (HdSceneIndexObserver::DirtiedPrimEntry& entry : result) {
        if (entry.dirtyLocators.Intersects(visibility) &&
            !entry.dirtyLocators.Intersects(topology) &&
            GetPrim(entry.primPath).primType == HdPrimTypeTokens->instancer) {
            entry.dirtyLocators.insert(topology);
        }
    }
    _SendPrimsDirtied(result);
}

PXR_NAMESPACE_CLOSE_SCOPE
