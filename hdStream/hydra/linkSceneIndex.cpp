// SPDX-License-Identifier: Apache-2.0
#include "hdStream/hydra/linkSceneIndex.h"

#include <pxr/imaging/hd/collectionSchema.h>
#include <pxr/imaging/hd/collectionsSchema.h>
#include <pxr/imaging/hd/tokens.h>

#include <utility>

PXR_NAMESPACE_OPEN_SCOPE

HdSceneIndexBaseRefPtr HdStreamLinkSceneIndex::New(const HdSceneIndexBaseRefPtr& inputScene) {
    return TfCreateRefPtr(new HdStreamLinkSceneIndex(inputScene));
}

HdStreamLinkSceneIndex::HdStreamLinkSceneIndex(const HdSceneIndexBaseRefPtr& inputScene)
    : HdSingleInputFilteringSceneIndexBase(inputScene) {}

HdSceneIndexPrim HdStreamLinkSceneIndex::GetPrim(const SdfPath& path) const {
    return _GetInputSceneIndex()->GetPrim(path);
}

SdfPathVector HdStreamLinkSceneIndex::GetChildPrimPaths(const SdfPath& path) const {
    return _GetInputSceneIndex()->GetChildPrimPaths(path);
}

bool HdStreamLinkSceneIndex::Replace(const SdfPath& path) {
    const HdSceneIndexPrim prim = GetPrim(path);
    Expressions expressions;
    if (const auto collections = HdCollectionsSchema::GetFromParent(prim.dataSource)) {
        for (const TfToken& name :
             {HdTokens->lightLink, HdTokens->shadowLink, HdTokens->filterLink}) {
            HdCollectionSchema collection = collections.GetCollection(name);
            const auto source = collection ? collection.GetMembershipExpression() : nullptr;
            expressions.push_back(source ? source->GetTypedValue(0.0F) : SdfPathExpression());
        }
    }
    const auto known = _expressions.find(path);
    const bool isReplaced = known != _expressions.end() && known->second != expressions;
    if (!expressions.empty()) {
        _expressions[path] = std::move(expressions);
    } else if (known != _expressions.end()) {
        _expressions.erase(known);
    }
    return isReplaced;
}

void HdStreamLinkSceneIndex::_PrimsAdded(const HdSceneIndexBase&,
                                         const HdSceneIndexObserver::AddedPrimEntries& entries) {
    HdSceneIndexObserver::AddedPrimEntries result;
    for (const HdSceneIndexObserver::AddedPrimEntry& entry : entries) {
        const bool isLight =
            HdPrimTypeIsLight(entry.primType) || entry.primType == HdPrimTypeTokens->lightFilter;
        if (isLight && Replace(entry.primPath)) {
            result.push_back({entry.primPath, TfToken()}); // no light for a moment
        }
        result.push_back(entry);
    }
    _SendPrimsAdded(result);
}

void HdStreamLinkSceneIndex::_PrimsRemoved(
    const HdSceneIndexBase&, const HdSceneIndexObserver::RemovedPrimEntries& entries) {
    for (const HdSceneIndexObserver::RemovedPrimEntry& entry : entries) {
        for (auto it = _expressions.lower_bound(entry.primPath);
             it != _expressions.end() && it->first.HasPrefix(entry.primPath);) {
            it = _expressions.erase(it);
        }
    }
    _SendPrimsRemoved(entries);
}

void HdStreamLinkSceneIndex::_PrimsDirtied(
    const HdSceneIndexBase&, const HdSceneIndexObserver::DirtiedPrimEntries& entries) {
    HdSceneIndexObserver::AddedPrimEntries again;
    HdSceneIndexObserver::DirtiedPrimEntries result;
    for (const HdSceneIndexObserver::DirtiedPrimEntry& entry : entries) {
        const bool mayLink =
            entry.dirtyLocators.Intersects(HdCollectionsSchema::GetDefaultLocator());
        const TfToken type = mayLink ? GetPrim(entry.primPath).primType : TfToken();
        const bool isLight = HdPrimTypeIsLight(type) || type == HdPrimTypeTokens->lightFilter;
        if (isLight && Replace(entry.primPath)) {
            again.push_back({entry.primPath, TfToken()}); // no light for a moment
            again.push_back({entry.primPath, type});
        } else {
            result.push_back(entry);
        }
    }
    if (!again.empty()) {
        _SendPrimsAdded(again);
    }
    _SendPrimsDirtied(result);
}

PXR_NAMESPACE_CLOSE_SCOPE
