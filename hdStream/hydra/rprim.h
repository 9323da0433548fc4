// SPDX-License-Identifier: Apache-2.0
// What meshes, curves and points of Hydra do alike. What changes without the geometry (transform,
// visibility, material, purpose, cull style, instances) keeps the pointer to the description, and
// with it all that the core has prepared.
#pragma once

#include "hdStream/hydra/geometryVariants.h"
#include "hdStream/session/session.h"

#include <pxr/imaging/hd/basisCurves.h>
#include <pxr/imaging/hd/mesh.h>
#include <pxr/imaging/hd/points.h>
#include <pxr/imaging/hd/tokens.h>
#include <pxr/pxr.h>

#include <string>
#include <vector>

PXR_NAMESPACE_OPEN_SCOPE

class HdStreamRenderParam;

/// A prim of Hydra (Base: HdMesh, HdBasisCurves or HdPoints) on its way into the core. Synced in
/// parallel with other prims, without a lock. Each kind of prim derives from it and adds what only
/// that kind has.
template <typename Base>
class HdStreamRprim : public Base {
public:
    explicit HdStreamRprim(const SdfPath& id) : Base(id) {}

    HdDirtyBits GetInitialDirtyBitsMask() const final;
    /// Pulls what is dirty and queues an edit. While the prim is invisible nothing but its
    /// visibility is pulled; the other bits stay dirty.
    void Sync(HdSceneDelegate* delegate, HdRenderParam* renderParam, HdDirtyBits* dirtyBits,
              const TfToken& reprToken) final;
    void UpdateRenderTag(HdSceneDelegate* delegate, HdRenderParam* renderParam) final;
    void Finalize(HdRenderParam* renderParam) final;

protected:
    HdDirtyBits _PropagateDirtyBits(HdDirtyBits bits) const final { return bits; }
    void _InitRepr(const TfToken& reprToken, HdDirtyBits* dirtyBits) final;

    // --- What a kind adds. ---
    /// Pulls what only this kind has, apart from geometry. Those without faces have nothing here,
    /// and warn where the scene says that they are lights.
    virtual void SyncLook(HdSceneDelegate* delegate, HdStreamRenderParam* param, HdDirtyBits bits);
    /// Pulls the geometry apart from primvars.
    virtual void SyncTopology(HdSceneDelegate* delegate, HdStreamRenderParam* param,
                              HdDirtyBits bits, hds::GeometryDescription* geometry) = 0;
    /// The primvar that has the points.
    virtual const TfToken& PointsName() const { return HdTokens->points; }
    /// Adds the primvars that this kind has by default.
    virtual void AddDefaultPrimvars(std::vector<hds::Primvar>*) const {}
    /// True when the geometry has something to draw; warns where the scene says otherwise.
    virtual bool CheckGeometry(HdStreamRenderParam* param) const = 0;

    std::string _scenePath; ///< empty until the first Sync
    hds::GeometryPrim _prim;

private:
    void SyncCommonLook(HdSceneDelegate* delegate, HdStreamRenderParam* param, HdDirtyBits bits);
    void SyncGeometry(HdSceneDelegate* delegate, HdStreamRenderParam* param, HdDirtyBits bits);
    /// Queues the prim as it is now, or its removal when there is nothing to draw.
    void Push(HdStreamRenderParam* param);

    bool _isPathProvisional = false;    ///< no instance has told it
    HdStreamGeometryVariants _variants; ///< of the prim, in the scene
};

extern template class HdStreamRprim<HdMesh>;
extern template class HdStreamRprim<HdBasisCurves>;
extern template class HdStreamRprim<HdPoints>;

PXR_NAMESPACE_CLOSE_SCOPE
