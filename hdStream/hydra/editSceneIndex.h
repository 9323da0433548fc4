// SPDX-License-Identifier: Apache-2.0
// Edits that would reach no renderer: OpenUSD's dirty bits know no visibility of instancers and no
// lights in meshes where hosts run scene indices, nor that filters are parts of lights; with legacy
// delegates no links of instances.
#pragma once

#include <pxr/imaging/hd/filteringSceneIndex.h>
#include <pxr/pxr.h>
#include <pxr/usd/sdf/path.h>

#include <map>

PXR_NAMESPACE_OPEN_SCOPE

/// Calls an instancer's topology dirty when its visibility is, and a mesh's material bindings when
/// what makes it a light is; a light when one of its filters changes, comes or goes; and instancers
/// when a light of a legacy delegate that links is. Otherwise its input. Costs a path or two for
/// each instancer, and for each light with filters or links.
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

private:
    /// Keeps what a prim that has come or changed says of filters and links.
    void Learn(const SdfPath& path, const TfToken& primType);
    void SetFilters(const SdfPath& light, const SdfPathVector& filters);
    /// Of the prim and all below it.
    void Forget(const SdfPath& path);
    /// Adds entries of the lights that name the prim as a filter.
    void AddLightsOf(const SdfPath& filter, HdSceneIndexObserver::DirtiedPrimEntries* entries);
    void AddInstancers(HdSceneIndexObserver::DirtiedPrimEntries* entries);

    std::map<SdfPath, SdfPathVector> _filtersByLight; ///< of lights that have some
    std::map<SdfPath, SdfPathSet> _lightsByFilter;
    SdfPathSet _linkingLights; ///< those of legacy delegates
    SdfPathSet _instancers;
};

PXR_NAMESPACE_CLOSE_SCOPE
