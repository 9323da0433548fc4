// SPDX-License-Identifier: Apache-2.0
// The active render pass of a scene (HdSceneGlobalsSchema), applied: what it prunes is gone, what
// it does not render is invisible, and what the camera does not see, or what it mattes, says so by
// the primvars of docs/geometry.md. Explained in docs/film.md.
#pragma once

#include "hdStream/hydra/passMembership.h"

#include <pxr/imaging/hd/filteringSceneIndex.h>
#include <pxr/pxr.h>

#include <memory>

PXR_NAMESPACE_OPEN_SCOPE

/// Its input, as its active render pass shows it. The scene may be read on many threads, between
/// notices.
class HdStreamPassSceneIndex final : public HdSingleInputFilteringSceneIndexBase {
public:
    static HdSceneIndexBaseRefPtr New(const HdSceneIndexBaseRefPtr& inputScene);

    HdSceneIndexPrim GetPrim(const SdfPath& path) const override;
    SdfPathVector GetChildPrimPaths(const SdfPath& path) const override;

protected:
    explicit HdStreamPassSceneIndex(const HdSceneIndexBaseRefPtr& inputScene);

    void _PrimsAdded(const HdSceneIndexBase& sender,
                     const HdSceneIndexObserver::AddedPrimEntries& entries) override;
    void _PrimsRemoved(const HdSceneIndexBase& sender,
                       const HdSceneIndexObserver::RemovedPrimEntries& entries) override;
    void _PrimsDirtied(const HdSceneIndexBase& sender,
                       const HdSceneIndexObserver::DirtiedPrimEntries& entries) override;

private:
    HdContainerDataSourceHandle OfGprim(const SdfPath& path, const HdSceneIndexPrim& prim) const;
    HdContainerDataSourceHandle OfInstancer(const SdfPath& path,
                                            const HdSceneIndexPrim& prim) const;
    template <typename Entries>
    Entries WithoutPruned(const Entries& entries) const;
    /// Reads the pass again where a change may be one of it.
    template <typename Entries>
    void UpdatePass(const Entries& entries);
    /// Tells observers what another pass changes.
    void SendChanges(const HdStreamPassMembership& before);

    std::unique_ptr<HdStreamPassMembership> _pass; ///< never null
};

PXR_NAMESPACE_CLOSE_SCOPE
