// SPDX-License-Identifier: Apache-2.0
// Meshes. What changes without the geometry (transform, visibility, material, purpose, cull style,
// instances) keeps the pointer to the description, and with it all that the core has prepared.
#pragma once

#include "hdStream/hydra/meshVariants.h"
#include "hdStream/session/session.h"

#include <pxr/imaging/hd/mesh.h>
#include <pxr/pxr.h>

#include <memory>
#include <string>

PXR_NAMESPACE_OPEN_SCOPE

class HdStreamRenderParam;

/// A mesh of Hydra on its way into the core. Synced in parallel with other prims, without a lock.
class HdStreamMesh final : public HdMesh {
public:
    explicit HdStreamMesh(const SdfPath& id);

    HdDirtyBits GetInitialDirtyBitsMask() const override;
    /// Pulls what is dirty and queues an edit. While the mesh is invisible nothing but its
    /// visibility is pulled; the other bits stay dirty.
    void Sync(HdSceneDelegate* delegate, HdRenderParam* renderParam, HdDirtyBits* dirtyBits,
              const TfToken& reprToken) override;
    void UpdateRenderTag(HdSceneDelegate* delegate, HdRenderParam* renderParam) override;
    void Finalize(HdRenderParam* renderParam) override;

protected:
    HdDirtyBits _PropagateDirtyBits(HdDirtyBits bits) const override;
    void _InitRepr(const TfToken& reprToken, HdDirtyBits* dirtyBits) override;

private:
    void SyncLook(HdSceneDelegate* delegate, HdStreamRenderParam* param, HdDirtyBits bits);
    void SyncLight(HdSceneDelegate* delegate, HdStreamRenderParam* param);
    void SyncGeometry(HdSceneDelegate* delegate, HdStreamRenderParam* param, HdDirtyBits bits);
    void SyncTopology(HdSceneDelegate* delegate, HdStreamRenderParam* param,
                      hds::MeshDescription* mesh);
    /// Splits the mesh by the primvars of its instances. \return true when that changed anything.
    bool SyncVariants(HdSceneDelegate* delegate, HdStreamRenderParam* param);
    /// Queues the prim as it is now, or its removal when there is nothing to draw.
    void Push(HdStreamRenderParam* param);

    std::string _scenePath; ///< empty until the first Sync
    hds::MeshPrim _prim;
    HdStreamMeshVariants _variants; ///< of the prim, in the scene
};

PXR_NAMESPACE_CLOSE_SCOPE
