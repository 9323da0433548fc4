// SPDX-License-Identifier: Apache-2.0
// Meshes of implicit gprims whose limit surface is the gprim, as the stage reader has them. OpenUSD
// puts the points of the cage on the gprim, so that a subdivided sphere would be too small.
#pragma once

#include <pxr/imaging/hd/filteringSceneIndex.h>
#include <pxr/pxr.h>

PXR_NAMESPACE_OPEN_SCOPE

/// Fits the points of meshes that are spheres, cylinders, cones or capsules in `authoredScene`, and
/// of meshes of scene delegates that have the faces of OpenUSD's meshes of those; otherwise its
/// input.
class HdStreamRoundSceneIndex final : public HdSingleInputFilteringSceneIndexBase {
public:
    /// \param inputScene what has turned the gprims of `authoredScene` into meshes.
    static HdSceneIndexBaseRefPtr New(const HdSceneIndexBaseRefPtr& inputScene,
                                      const HdSceneIndexBaseRefPtr& authoredScene);

    HdSceneIndexPrim GetPrim(const SdfPath& path) const override;
    SdfPathVector GetChildPrimPaths(const SdfPath& path) const override;

protected:
    HdStreamRoundSceneIndex(const HdSceneIndexBaseRefPtr& inputScene,
                            const HdSceneIndexBaseRefPtr& authoredScene);

    void _PrimsAdded(const HdSceneIndexBase& sender,
                     const HdSceneIndexObserver::AddedPrimEntries& entries) override;
    void _PrimsRemoved(const HdSceneIndexBase& sender,
                       const HdSceneIndexObserver::RemovedPrimEntries& entries) override;
    void _PrimsDirtied(const HdSceneIndexBase& sender,
                       const HdSceneIndexObserver::DirtiedPrimEntries& entries) override;

private:
    HdSceneIndexBaseRefPtr _authoredScene;
};

PXR_NAMESPACE_CLOSE_SCOPE
