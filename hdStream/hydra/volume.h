// SPDX-License-Identifier: Apache-2.0
// Volumes, and the fields that they are made of.
#pragma once

#include "hdStream/session/session.h"

#include <pxr/imaging/hd/field.h>
#include <pxr/imaging/hd/volume.h>
#include <pxr/pxr.h>

#include <map>
#include <string>

PXR_NAMESPACE_OPEN_SCOPE

class HdStreamRenderParam;

/// The types of fields, those of UsdVolImagingTokens. What is no openvdbAsset is not drawn, but
/// UsdImaging fails where the renderer does not have it.
const TfTokenVector& HdStreamFieldTypes();

/// A field of any of these types. Synced before volumes.
class HdStreamVolumeField final : public HdField {
public:
    explicit HdStreamVolumeField(const SdfPath& id) : HdField(id) {}

    HdDirtyBits GetInitialDirtyBitsMask() const override { return AllDirty; }
    /// Keeps what the field is, and queues the volumes that have it.
    void Sync(HdSceneDelegate* delegate, HdRenderParam* renderParam,
              HdDirtyBits* dirtyBits) override;
    void Finalize(HdRenderParam* renderParam) override;
};

/// A volume of Hydra on its way into the core. Synced in parallel with other prims.
class HdStreamVolume final : public HdVolume {
public:
    explicit HdStreamVolume(const SdfPath& id) : HdVolume(id) {}

    HdDirtyBits GetInitialDirtyBitsMask() const override;
    void Sync(HdSceneDelegate* delegate, HdRenderParam* renderParam, HdDirtyBits* dirtyBits,
              const TfToken& reprToken) override;
    void UpdateRenderTag(HdSceneDelegate* delegate, HdRenderParam* renderParam) override;
    void Finalize(HdRenderParam* renderParam) override;

protected:
    HdDirtyBits _PropagateDirtyBits(HdDirtyBits bits) const override { return bits; }
    void _InitRepr(const TfToken& reprToken, HdDirtyBits* dirtyBits) override;

private:
    void SyncFields(HdSceneDelegate* delegate, HdStreamRenderParam* param);

    std::string _scenePath;          ///< empty until the first Sync
    bool _isPathProvisional = false; ///< no instance has told it
    hds::VolumePrim _prim;           ///< without its fields
    std::map<std::string, SdfPath> _fieldIds;
};

PXR_NAMESPACE_CLOSE_SCOPE
