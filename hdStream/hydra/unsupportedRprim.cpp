// SPDX-License-Identifier: Apache-2.0
#include "hdStream/hydra/unsupportedRprim.h"

#include "hdStream/hydra/renderParam.h"

#include <pxr/imaging/hd/changeTracker.h>
#include <pxr/imaging/hd/instancer.h>
#include <pxr/imaging/hd/sceneDelegate.h>

#include <algorithm>

PXR_NAMESPACE_OPEN_SCOPE

HdStreamUnsupportedRprim::HdStreamUnsupportedRprim(const SdfPath& id, const TfToken& typeId)
    : HdRprim(id), _typeId(typeId) {}

HdDirtyBits HdStreamUnsupportedRprim::GetInitialDirtyBitsMask() const {
    return HdChangeTracker::InitRepr | HdChangeTracker::DirtyVisibility |
           HdChangeTracker::DirtyInstancer | HdChangeTracker::DirtyRenderTag;
}

HdDirtyBits HdStreamUnsupportedRprim::_PropagateDirtyBits(HdDirtyBits bits) const {
    return bits;
}

void HdStreamUnsupportedRprim::_InitRepr(const TfToken& reprToken, HdDirtyBits*) {
    const auto found = std::find_if(_reprs.begin(), _reprs.end(), _ReprComparator(reprToken));
    if (found == _reprs.end()) {
        _reprs.emplace_back(reprToken, HdReprSharedPtr());
    }
}

const TfTokenVector& HdStreamUnsupportedRprim::GetBuiltinPrimvarNames() const {
    static const TfTokenVector none;
    return none;
}

void HdStreamUnsupportedRprim::Sync(HdSceneDelegate* delegate, HdRenderParam* renderParam,
                                    HdDirtyBits* dirtyBits, const TfToken&) {
    _UpdateVisibility(delegate, dirtyBits);
    _UpdateInstancer(delegate, dirtyBits);
    HdInstancer::_SyncInstancerAndParents(delegate->GetRenderIndex(), GetInstancerId());
    if (IsVisible() && !_hasWarned) {
        _hasWarned = true;
        static_cast<HdStreamRenderParam*>(renderParam)
            ->Warn(GetId(), _typeId.GetString() + " is not supported yet; left out");
    }
    *dirtyBits = HdChangeTracker::Clean;
}

PXR_NAMESPACE_CLOSE_SCOPE
