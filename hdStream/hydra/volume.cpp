// SPDX-License-Identifier: Apache-2.0
#include "hdStream/hydra/volume.h"

#include "hdStream/hydra/assets.h"
#include "hdStream/hydra/categories.h"
#include "hdStream/hydra/gprim.h"
#include "hdStream/hydra/instancer.h"
#include "hdStream/hydra/lightParameters.h"
#include "hdStream/hydra/renderParam.h"

#include <pxr/imaging/hd/changeTracker.h>
#include <pxr/imaging/hd/sceneDelegate.h>
#include <pxr/imaging/hd/tokens.h>
#include <pxr/usd/sdf/assetPath.h>

#include <algorithm>
#include <utility>
#include <vector>

PXR_NAMESPACE_OPEN_SCOPE

namespace {

void Push(HdStreamRenderParam* param, HdStreamVolumeTable::Edit edit) {
    param->Push([edit = std::move(edit)](hds::Session& session) mutable {
        session.SetVolume(edit.scenePath, std::move(edit.prim));
    });
}

void PushAll(HdStreamRenderParam* param, std::vector<HdStreamVolumeTable::Edit> edits) {
    for (HdStreamVolumeTable::Edit& edit : edits) {
        Push(param, std::move(edit));
    }
}

} // namespace

const TfTokenVector& HdStreamFieldTypes() {
    static const TfTokenVector types{TfToken("openvdbAsset"), TfToken("field3dAsset")};
    return types;
}

void HdStreamVolumeField::Sync(HdSceneDelegate* delegate, HdRenderParam* renderParam,
                               HdDirtyBits* dirtyBits) {
    static const TfToken fieldIndex("fieldIndex"); // not among Hydra's tokens
    if (*dirtyBits & AllDirty) {
        auto* param = static_cast<HdStreamRenderParam*>(renderParam);
        const SdfPath& id = GetId();
        hds::VolumeField field;
        const VtValue file = delegate->Get(id, HdFieldTokens->filePath);
        if (file.IsHolding<SdfAssetPath>()) {
            field.asset = HdStreamAssetReference(file.UncheckedGet<SdfAssetPath>());
        }
        field.gridName =
            delegate->Get(id, HdFieldTokens->fieldName).GetWithDefault(TfToken()).GetString();
        field.gridIndex = delegate->Get(id, fieldIndex).GetWithDefault(0);
        PushAll(param, param->Volumes().SetField(id, field));
    }
    *dirtyBits = Clean;
}

void HdStreamVolumeField::Finalize(HdRenderParam* renderParam) {
    auto* param = static_cast<HdStreamRenderParam*>(renderParam);
    PushAll(param, param->Volumes().RemoveField(GetId()));
}

HdDirtyBits HdStreamVolume::GetInitialDirtyBitsMask() const {
    return HdChangeTracker::InitRepr | HdChangeTracker::DirtyTransform |
           HdChangeTracker::DirtyVisibility | HdChangeTracker::DirtyMaterialId |
           HdChangeTracker::DirtyVolumeField | HdChangeTracker::DirtyInstancer |
           HdChangeTracker::DirtyInstanceIndex | HdChangeTracker::DirtyRenderTag |
           HdChangeTracker::DirtyCategories;
}

void HdStreamVolume::_InitRepr(const TfToken& reprToken, HdDirtyBits*) {
    const auto found = std::find_if(_reprs.begin(), _reprs.end(), _ReprComparator(reprToken));
    if (found == _reprs.end()) {
        _reprs.emplace_back(reprToken, HdReprSharedPtr());
    }
}

void HdStreamVolume::Sync(HdSceneDelegate* delegate, HdRenderParam* renderParam,
                          HdDirtyBits* dirtyBits, const TfToken&) {
    auto* param = static_cast<HdStreamRenderParam*>(renderParam);
    const SdfPath& id = GetId();
    const HdDirtyBits bits = *dirtyBits;
    _UpdateVisibility(delegate, dirtyBits);
    _UpdateInstancer(delegate, dirtyBits);
    HdInstancer::_SyncInstancerAndParents(delegate->GetRenderIndex(), GetInstancerId());
    const bool isFirst = _scenePath.empty();
    const hds::VolumePrim before = _prim;
    const std::map<std::string, SdfPath> fieldsBefore = _fieldIds;
    *dirtyBits = HdChangeTracker::Clean;
    const std::string pathBefore = _scenePath;
    const bool isRenamed =
        HdStreamSyncPlacement(delegate, id, GetInstancerId(), bits, param, &_prim.placement,
                              &_scenePath, &_isPathProvisional);
    if (isRenamed) {
        param->Push([pathBefore](hds::Session& session) { session.Remove(pathBefore); });
    }
    _prim.placement.visible = IsVisible();
    _prim.purpose = HdStreamPurpose(GetRenderTag());
    if (bits & HdChangeTracker::DirtyMaterialId) {
        SetMaterialId(delegate->GetMaterialId(id));
        _prim.materialPath = param->MaterialPath(delegate, GetMaterialId());
    }
    if (bits & HdChangeTracker::DirtyCategories) {
        _prim.categories = HdStreamCategories(delegate->GetCategories(id));
    }
    if (isFirst) {
        HdStreamWarnOfNoLight(delegate, id, _scenePath, param);
    }
    if (bits & HdChangeTracker::DirtyVolumeField) {
        SyncFields(delegate, param);
    }
    if (isFirst || isRenamed || _prim != before || _fieldIds != fieldsBefore) {
        Push(param, param->Volumes().SetVolume(id, {_scenePath, _prim, _fieldIds}));
    }
}

void HdStreamVolume::SyncFields(HdSceneDelegate* delegate, HdStreamRenderParam* param) {
    _fieldIds.clear();
    for (const HdVolumeFieldDescriptor& field : delegate->GetVolumeFieldDescriptors(GetId())) {
        const std::string& name = field.fieldName.GetString();
        if (field.fieldPrimType == HdStreamFieldTypes()[0]) {
            _fieldIds[name] = field.fieldId;
        } else {
            param->Warn(SdfPath(_scenePath), "field '" + name + "' (" + field.fieldId.GetString() +
                                                 ") is a " + field.fieldPrimType.GetString() +
                                                 ", no OpenVDBAsset: left out");
        }
    }
}

void HdStreamVolume::UpdateRenderTag(HdSceneDelegate* delegate, HdRenderParam* renderParam) {
    HdVolume::UpdateRenderTag(delegate, renderParam);
    std::string purpose = HdStreamPurpose(GetRenderTag());
    if (purpose != _prim.purpose && !_scenePath.empty()) {
        _prim.purpose = std::move(purpose);
        auto* param = static_cast<HdStreamRenderParam*>(renderParam);
        Push(param, param->Volumes().SetVolume(GetId(), {_scenePath, _prim, _fieldIds}));
    }
}

void HdStreamVolume::Finalize(HdRenderParam* renderParam) {
    auto* param = static_cast<HdStreamRenderParam*>(renderParam);
    param->Volumes().RemoveVolume(GetId());
    if (!_scenePath.empty()) {
        param->Push([path = _scenePath](hds::Session& session) { session.Remove(path); });
        param->ReleasePath(_scenePath);
        _scenePath.clear();
    }
}

PXR_NAMESPACE_CLOSE_SCOPE
