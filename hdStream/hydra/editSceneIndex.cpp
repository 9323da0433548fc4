// SPDX-License-Identifier: Apache-2.0
#include "hdStream/hydra/editSceneIndex.h"

#include <pxr/imaging/hd/instancerTopologySchema.h>
#include <pxr/imaging/hd/lightSchema.h>
#include <pxr/imaging/hd/materialBindingsSchema.h>
#include <pxr/imaging/hd/tokens.h>
#include <pxr/imaging/hd/visibilitySchema.h>

PXR_NAMESPACE_OPEN_SCOPE

HdSceneIndexBaseRefPtr HdStreamEditSceneIndex::New(const HdSceneIndexBaseRefPtr& inputScene) {
    return TfCreateRefPtr(new HdStreamEditSceneIndex(inputScene));
}

HdStreamEditSceneIndex::HdStreamEditSceneIndex(const HdSceneIndexBaseRefPtr& inputScene)
    : HdSingleInputFilteringSceneIndexBase(inputScene) {}

HdSceneIndexPrim HdStreamEditSceneIndex::GetPrim(const SdfPath& path) const {
    return _GetInputSceneIndex()->GetPrim(path);
}

SdfPathVector HdStreamEditSceneIndex::GetChildPrimPaths(const SdfPath& path) const {
    return _GetInputSceneIndex()->GetChildPrimPaths(path);
}

void HdStreamEditSceneIndex::_PrimsAdded(const HdSceneIndexBase&,
                                         const HdSceneIndexObserver::AddedPrimEntries& entries) {
    _SendPrimsAdded(entries);
}

void HdStreamEditSceneIndex::_PrimsRemoved(
    const HdSceneIndexBase&, const HdSceneIndexObserver::RemovedPrimEntries& entries) {
    _SendPrimsRemoved(entries);
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
    for (HdSceneIndexObserver::DirtiedPrimEntry& entry : result) {
        forward(HdPrimTypeTokens->instancer, HdVisibilitySchema::GetDefaultLocator(),
                HdInstancerTopologySchema::GetDefaultLocator(), &entry);
        forward(HdPrimTypeTokens->mesh, HdLightSchema::GetDefaultLocator(),
                HdMaterialBindingsSchema::GetDefaultLocator(), &entry);
    }
    _SendPrimsDirtied(result);
}

PXR_NAMESPACE_CLOSE_SCOPE
