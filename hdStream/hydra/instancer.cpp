// SPDX-License-Identifier: Apache-2.0
#include "hdStream/hydra/instancer.h"

#include "hdStream/hydra/arrays.h"
#include "hdStream/hydra/instanceTransforms.h"
#include "hdStream/hydra/renderParam.h"
#include "hdStream/hydra/scenePaths.h"

#include <pxr/imaging/hd/changeTracker.h>
#include <pxr/imaging/hd/sceneDelegate.h>
#include <pxr/imaging/hd/tokens.h>

#include <algorithm>
#include <utility>

PXR_NAMESPACE_OPEN_SCOPE

HdStreamInstancer::HdStreamInstancer(HdSceneDelegate* delegate, const SdfPath& id)
    : HdInstancer(delegate, id) {}

const std::string& HdStreamInstancer::ScenePath(HdStreamRenderParam* param) {
    std::call_once(_hasScenePath, [&] {
        HdSceneDelegate* delegate = GetDelegate();
        const SdfPath parentId = delegate->GetInstancerId(GetId());
        hds::Placement parent;
        UpdatePathOf(delegate->GetRenderIndex(), parentId, param, &parent);
        _scenePath = param->ReservePath(
            HdStreamInstancerScenePath(delegate, GetId(), parentId, parent.instancerPath), GetId());
    });
    return _scenePath;
}

bool HdStreamInstancer::UpdatePathOf(HdRenderIndex& index, const SdfPath& instancerId,
                                     HdStreamRenderParam* param, hds::Placement* placement) {
    auto* instancer = instancerId.IsEmpty()
                          ? nullptr
                          : static_cast<HdStreamInstancer*>(index.GetInstancer(instancerId));
    std::string path = instancer ? instancer->ScenePath(param) : std::string();
    if (path == placement->instancerPath) {
        return false;
    }
    placement->instancerPath = std::move(path);
    return true;
}

void HdStreamInstancer::ReadInstances(HdSceneDelegate* delegate, const SdfPath& instancerId,
                                      const SdfPath& prototypeId, hds::Placement* placement) {
    placement->instances = instancerId.IsEmpty()
                               ? hds::SharedSpan<std::int32_t>()
                               : HdStreamShareArray<std::int32_t>(
                                     delegate->GetInstanceIndices(instancerId, prototypeId));
}

HdDirtyBits HdStreamInstancer::GetInitialDirtyBitsMask() const {
    return HdInstancer::GetInitialDirtyBitsMask() | HdChangeTracker::DirtyVisibility;
}

void HdStreamInstancer::Sync(HdSceneDelegate* delegate, HdRenderParam* renderParam,
                             HdDirtyBits* dirtyBits) {
    auto* param = static_cast<HdStreamRenderParam*>(renderParam);
    const HdDirtyBits bits = *dirtyBits;
    _UpdateInstancer(delegate, dirtyBits);
    ScenePath(param);
    hds::Placement& placement = _prim.placement;
    const bool isMoved = UpdatePathOf(delegate->GetRenderIndex(), GetParentId(), param, &placement);
    if (isMoved || (bits & HdChangeTracker::DirtyInstanceIndex)) {
        ReadInstances(delegate, GetParentId(), GetId(), &placement);
    }
    if (bits & HdChangeTracker::DirtyTransform) {
        placement.worldFromObject = HdStreamToGlm(delegate->GetInstancerTransform(GetId()));
    }
    // Legacy delegates fold an instancer's visibility into what it places, and GetVisible would be
    // that of the first native instance only.
    if ((bits & HdChangeTracker::DirtyVisibility) &&
        !HdStreamFindLegacyDelegate(delegate, GetId())) {
        placement.visible = delegate->GetVisible(GetId());
    }
    if (HdChangeTracker::IsAnyPrimvarDirty(bits, GetId())) {
        SyncPrimvars(delegate, param, bits);
    }
    const bool isPlacing = !_prim.instanceTransforms.empty() && IsPlaced(placement);
    if (isPlacing) {
        param->Push([path = _scenePath, prim = _prim](hds::Session& session) mutable {
            session.SetInstancer(path, std::move(prim));
        });
    } else if (_isInScene) {
        param->Push([path = _scenePath](hds::Session& session) { session.Remove(path); });
    }
    _isInScene = isPlacing;
    *dirtyBits = HdChangeTracker::Clean;
}

void HdStreamInstancer::SyncPrimvars(HdSceneDelegate* delegate, HdStreamRenderParam* param,
                                     HdDirtyBits bits) {
    const SdfPath& id = GetId();
    const TfTokenVector& transforms = GetBuiltinPrimvarNames();
    std::map<TfToken, VtValue> values;
    bool hasOthers = false;
    for (const HdPrimvarDescriptor& descriptor :
         delegate->GetPrimvarDescriptors(id, HdInterpolationInstance)) {
        const TfToken& name = descriptor.name;
        if (std::find(transforms.begin(), transforms.end(), name) == transforms.end()) {
            hasOthers = true;
        } else if (HdChangeTracker::IsPrimvarDirty(bits, id, name)) {
            values[name] = delegate->Get(id, name);
        } else if (const auto found = _values.find(name); found != _values.end()) {
            values.insert(*found);
        }
    }
    if (hasOthers) {
        param->Warn(SdfPath(_scenePath), "primvars per instance are not supported yet");
    }
    _values = std::move(values);
    _prim.instanceTransforms = HdStreamInstanceTransforms(
        _values[HdInstancerTokens->instanceTranslations],
        _values[HdInstancerTokens->instanceRotations], _values[HdInstancerTokens->instanceScales],
        _values[HdInstancerTokens->instanceTransforms]);
}

void HdStreamInstancer::Finalize(HdRenderParam* renderParam) {
    auto* param = static_cast<HdStreamRenderParam*>(renderParam);
    if (_isInScene) {
        param->Push([path = _scenePath](hds::Session& session) { session.Remove(path); });
        _isInScene = false;
    }
    if (!_scenePath.empty()) {
        param->ReleasePath(_scenePath);
        _scenePath.clear();
    }
}

PXR_NAMESPACE_CLOSE_SCOPE
