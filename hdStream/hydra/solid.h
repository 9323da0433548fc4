// SPDX-License-Identifier: Apache-2.0
// Curves and points. What changes without the geometry keeps the pointer to the description, and
// with it all that the core has prepared.
#pragma once

#include "hdStream/hydra/gprim.h"

#include <pxr/imaging/hd/basisCurves.h>
#include <pxr/imaging/hd/points.h>
#include <pxr/pxr.h>

#include <string>

PXR_NAMESPACE_OPEN_SCOPE

/// Curves (Base HdBasisCurves) or points (HdPoints) of Hydra on their way into the core. Synced in
/// parallel with other prims, without a lock.
template <typename Base>
class HdStreamSolid final : public Base {
public:
    explicit HdStreamSolid(const SdfPath& id);

    HdDirtyBits GetInitialDirtyBitsMask() const override;
    /// Pulls what is dirty and queues an edit. While the prim is invisible nothing but its
    /// visibility is pulled; the other bits stay dirty.
    void Sync(HdSceneDelegate* delegate, HdRenderParam* renderParam, HdDirtyBits* dirtyBits,
              const TfToken& reprToken) override;
    void UpdateRenderTag(HdSceneDelegate* delegate, HdRenderParam* renderParam) override;
    void Finalize(HdRenderParam* renderParam) override;

protected:
    HdDirtyBits _PropagateDirtyBits(HdDirtyBits bits) const override;
    void _InitRepr(const TfToken& reprToken, HdDirtyBits* dirtyBits) override;

private:
    void SyncGeometry(HdSceneDelegate* delegate, HdStreamRenderParam* param, HdDirtyBits bits);
    /// Queues the prim as it is now, or its removal when there is nothing to draw.
    void Push(HdStreamRenderParam* param);

    std::string _scenePath; ///< empty until the first Sync
    hds::MeshPrim _prim;
    HdStreamMeshVariants _variants; ///< of the prim, in the scene
};

using HdStreamBasisCurves = HdStreamSolid<HdBasisCurves>;
using HdStreamPoints = HdStreamSolid<HdPoints>;

extern template class HdStreamSolid<HdBasisCurves>;
extern template class HdStreamSolid<HdPoints>;

PXR_NAMESPACE_CLOSE_SCOPE
