// SPDX-License-Identifier: Apache-2.0
#include "hdStream/hydra/renderSettings.h"

#include "hdStream/hydra/renderParam.h"

PXR_NAMESPACE_OPEN_SCOPE

HdStreamRenderSettings::HdStreamRenderSettings(const SdfPath& id) : HdRenderSettings(id) {}

void HdStreamRenderSettings::_Sync(HdSceneDelegate*, HdRenderParam* renderParam,
                                   const HdDirtyBits* dirtyBits) {
    if ((*dirtyBits & (DirtyActive | DirtyNamespacedSettings)) == 0) {
        return;
    }
    auto* param = static_cast<HdStreamRenderParam*>(renderParam);
    if (IsActive()) {
        param->SetSceneSettings(GetId(), GetNamespacedSettings());
    } else {
        param->ClearSceneSettings(GetId());
    }
}

void HdStreamRenderSettings::Finalize(HdRenderParam* renderParam) {
    static_cast<HdStreamRenderParam*>(renderParam)->ClearSceneSettings(GetId());
}

PXR_NAMESPACE_CLOSE_SCOPE
