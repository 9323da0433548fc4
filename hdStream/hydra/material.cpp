// SPDX-License-Identifier: Apache-2.0
#include "hdStream/hydra/material.h"

#include "hdStream/hydra/materialParameters.h"
#include "hdStream/hydra/renderParam.h"

#include <pxr/imaging/hd/sceneDelegate.h>

#include <memory>
#include <utility>

PXR_NAMESPACE_OPEN_SCOPE

HdStreamMaterial::HdStreamMaterial(const SdfPath& id) : HdMaterial(id) {}

HdDirtyBits HdStreamMaterial::GetInitialDirtyBitsMask() const {
    return AllDirty;
}

void HdStreamMaterial::Sync(HdSceneDelegate* delegate, HdRenderParam* renderParam,
                            HdDirtyBits* dirtyBits) {
    if (*dirtyBits & AllDirty) {
        auto* param = static_cast<HdStreamRenderParam*>(renderParam);
        if (_scenePath.empty()) {
            _scenePath = param->MaterialPath(delegate, GetId());
        }
        const VtValue resource = delegate->GetMaterialResource(GetId());
        auto network = std::make_shared<hds::MaterialNetwork>(
            resource.IsHolding<HdMaterialNetworkMap>()
                ? HdStreamMaterialNetworkFrom(SdfPath(_scenePath), GetId(),
                                              resource.UncheckedGet<HdMaterialNetworkMap>())
                : hds::MaterialNetwork());
        HdStreamFixMaterial(param->Exporter(), network.get());
        if (network->terminals.count("surface") + network->terminals.count("volume") == 0) {
            param->Warn(SdfPath(_scenePath), "material has no surface");
        }
        param->Push([path = _scenePath, network](hds::Session& session) {
            session.SetMaterial(path, network);
        });
    }
    *dirtyBits = Clean;
}

void HdStreamMaterial::Finalize(HdRenderParam* renderParam) {
    if (!_scenePath.empty()) {
        static_cast<HdStreamRenderParam*>(renderParam)
            ->Push([path = _scenePath](hds::Session& session) { session.Remove(path); });
    }
}

PXR_NAMESPACE_CLOSE_SCOPE
