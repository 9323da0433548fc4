// SPDX-License-Identifier: Apache-2.0
// Edits that would reach no renderer where hosts run scene indices: OpenUSD's dirty bits know no
// visibility of instancers and no lights in meshes there.
#pragma once

#include <pxr/imaging/hd/filteringSceneIndex.h>
#include <pxr/pxr.h>

PXR_NAMESPACE_OPEN_SCOPE

/// Calls an instancer's topology dirty when its visibility is, and a mesh's material bindings when
/// what makes it a light is; otherwise its input.
class HdStreamEditSceneIndex final : public HdSingleInputFilteringSceneIndexBase {
public:
    static HdSceneIndexBaseRefPtr New(const HdSceneIndexBaseRefPtr& inputScene);

    HdSceneIndexPrim GetPrim(const SdfPath& path) const override;
    SdfPathVector GetChildPrimPaths(const SdfPath& path) const override;

protected:
    explicit HdStreamEditSceneIndex(const HdSceneIndexBaseRefPtr& inputScene);

    void _PrimsAdded(const HdSceneIndexBase& sender,
                     const HdSceneIndexObserver::AddedPrimEntries& entries) override;
    void _PrimsRemoved(const HdSceneIndexBase& sender,
                       const HdSceneIndexObserver::RemovedPrimEntries& entries) override;
    void _PrimsDirtied(const HdSceneIndexBase& sender,
                       const HdSceneIndexObserver::DirtiedPrimEntries& entries) override;
};

PXR_NAMESPACE_CLOSE_SCOPE
