// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "hdStream/session/session.h"

#include <pxr/imaging/hd/light.h>
#include <pxr/pxr.h>

#include <string>

PXR_NAMESPACE_OPEN_SCOPE

class HdStreamRenderParam;

/// A light of Hydra on its way into the core. Synced in parallel with other lights.
class HdStreamLight final : public HdLight {
public:
    HdStreamLight(const SdfPath& id, const TfToken& typeId, hds::LightType type);

    HdDirtyBits GetInitialDirtyBitsMask() const override;
    void Sync(HdSceneDelegate* delegate, HdRenderParam* renderParam,
              HdDirtyBits* dirtyBits) override;
    void Finalize(HdRenderParam* renderParam) override;

private:
    void SyncPlacement(HdSceneDelegate* delegate, HdStreamRenderParam* param, HdDirtyBits bits);
    void SyncParameters(HdSceneDelegate* delegate, HdStreamRenderParam* param);

    void SyncSamples(HdSceneDelegate* delegate, HdStreamRenderParam* param);

    TfToken _typeId;
    hds::LightType _type;
    hds::LightDescription _authored; ///< as the exporter wrote it
    std::string _scenePath;          ///< empty until the first Sync
    bool _isPathProvisional = false; ///< no instance has told it
    hds::LightPrim _prim;
    bool _isInScene = false;
};

/// A light that the core cannot render: warns once and is left out.
class HdStreamUnsupportedLight final : public HdSprim {
public:
    HdStreamUnsupportedLight(const SdfPath& id, const TfToken& typeId);

    HdDirtyBits GetInitialDirtyBitsMask() const override;
    void Sync(HdSceneDelegate* delegate, HdRenderParam* renderParam,
              HdDirtyBits* dirtyBits) override;

private:
    TfToken _typeId;
};

PXR_NAMESPACE_CLOSE_SCOPE
