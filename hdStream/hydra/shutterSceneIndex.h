// SPDX-License-Identifier: Apache-2.0
// Shutters that open: what moves is sampled for the interval in which some camera's shutter is
// open, so that it must be read again when that changes. Prims of scene indices are out of the
// change tracker's reach; here those of scene delegates and of scene indices are the same.
// Explained in docs/motionBlur.md.
#pragma once

#include <pxr/imaging/hd/filteringSceneIndex.h>
#include <pxr/pxr.h>

#include <map>
#include <utility>

PXR_NAMESPACE_OPEN_SCOPE

/// Calls transforms and points of gprims, lights and instancers dirty when a camera's shutter
/// changes; otherwise its input.
class HdStreamShutterSceneIndex final : public HdSingleInputFilteringSceneIndexBase {
public:
    static HdSceneIndexBaseRefPtr New(const HdSceneIndexBaseRefPtr& inputScene);

    HdSceneIndexPrim GetPrim(const SdfPath& path) const override;
    SdfPathVector GetChildPrimPaths(const SdfPath& path) const override;

protected:
    explicit HdStreamShutterSceneIndex(const HdSceneIndexBaseRefPtr& inputScene);

    void _PrimsAdded(const HdSceneIndexBase& sender,
                     const HdSceneIndexObserver::AddedPrimEntries& entries) override;
    void _PrimsRemoved(const HdSceneIndexBase& sender,
                       const HdSceneIndexObserver::RemovedPrimEntries& entries) override;
    void _PrimsDirtied(const HdSceneIndexBase& sender,
                       const HdSceneIndexObserver::DirtiedPrimEntries& entries) override;

private:
    /// Reads a camera's shutter. \return whether it is another one than before.
    bool Update(const SdfPath& camera);
    void DirtyWhatMoves();

    std::map<SdfPath, std::pair<double, double>> _shutters; ///< of cameras that have one
};

PXR_NAMESPACE_CLOSE_SCOPE
