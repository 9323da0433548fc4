// SPDX-License-Identifier: Apache-2.0
#include "hdStream/hydra/material.h"

#include "hdStream/hydra/materialParameters.h"
#include "hdStream/hydra/renderParam.h"

#include <pxr/base/tf/error.h>
#include <pxr/base/tf/errorMark.h>
#include <pxr/imaging/hd/sceneDelegate.h>

#include <algorithm>
#include <memory>
#include <utility>

PXR_NAMESPACE_OPEN_SCOPE

namespace {

/// The network of a material. OpenUSD 25.02 cannot convert the configuration of MaterialX that
/// comes with networks of scene delegates, a dictionary within a dictionary, and posts an error for
/// each. Nothing here reads it: these errors are taken back, and all others are left.
VtValue NetworkOf(HdSceneDelegate* delegate, const SdfPath& id) {
    TfErrorMark errors;
    VtValue network = delegate->GetMaterialResource(id);
    const bool areKnown = std::all_of(errors.begin(), errors.end(), [](const TfError& error) {
        return error.GetCommentary() == "Unsupported type VtDictionary";
    });
    if (areKnown) {
        errors.Clear();
    }
    return network;
}

} // namespace

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
        const VtValue resource = NetworkOf(delegate, GetId());
        auto network = std::make_shared<hds::MaterialNetwork>(
            resource.IsHolding<HdMaterialNetworkMap>()
                ? HdStreamMaterialNetworkFrom(SdfPath(_scenePath), GetId(),
                                              resource.UncheckedGet<HdMaterialNetworkMap>())
                : hds::MaterialNetwork());
        HdStreamFixMaterial(param->Exporter(), network.get());
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
