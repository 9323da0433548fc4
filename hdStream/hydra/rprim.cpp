// SPDX-License-Identifier: Apache-2.0
#include "hdStream/hydra/rprim.h"

#include "hdStream/hydra/categories.h"
#include "hdStream/hydra/gprim.h"
#include "hdStream/hydra/instancer.h"
#include "hdStream/hydra/lightParameters.h"
#include "hdStream/hydra/motion.h"
#include "hdStream/hydra/primvars.h"
#include "hdStream/hydra/renderParam.h"
#include "hdStream/hydra/skinnedNormals.h"

#include <pxr/imaging/hd/changeTracker.h>
#include <pxr/imaging/hd/sceneDelegate.h>
#include <pxr/imaging/hd/tokens.h>

#include <algorithm>
#include <memory>
#include <utility>

PXR_NAMESPACE_OPEN_SCOPE

namespace {

constexpr HdDirtyBits kGeometryBits =
    HdChangeTracker::DirtyPoints | HdChangeTracker::DirtyTopology |
    HdChangeTracker::DirtySubdivTags | HdChangeTracker::DirtyPrimvar |
    HdChangeTracker::DirtyNormals | HdChangeTracker::DirtyWidths |
    HdChangeTracker::DirtyComputationPrimvarDesc;

/// What may change how instances split the prim.
constexpr HdDirtyBits kVariantBits =
    kGeometryBits | HdChangeTracker::DirtyInstancer | HdChangeTracker::DirtyInstanceIndex;

constexpr HdDirtyBits kAllBits =
    kGeometryBits | HdChangeTracker::InitRepr | HdChangeTracker::DirtyTransform |
    HdChangeTracker::DirtyVisibility | HdChangeTracker::DirtyDoubleSided |
    HdChangeTracker::DirtyCullStyle | HdChangeTracker::DirtyMaterialId |
    HdChangeTracker::DirtyPrimID | HdChangeTracker::DirtyInstancer |
    HdChangeTracker::DirtyInstanceIndex | HdChangeTracker::DirtyDisplayStyle |
    HdChangeTracker::DirtyRenderTag | HdChangeTracker::DirtyExtent | HdChangeTracker::DirtyRepr |
    HdChangeTracker::DirtyCategories;

} // namespace

template <typename Base>
HdDirtyBits HdStreamRprim<Base>::GetInitialDirtyBitsMask() const {
    return kAllBits;
}

template <typename Base>
void HdStreamRprim<Base>::_InitRepr(const TfToken& reprToken, HdDirtyBits*) {
    // Draw items serve rasterisers; Hydra wants a repr to exist all the same.
    const auto found = std::find_if(this->_reprs.begin(), this->_reprs.end(),
                                    typename Base::_ReprComparator(reprToken));
    if (found == this->_reprs.end()) {
        this->_reprs.emplace_back(reprToken, HdReprSharedPtr());
    }
}

template <typename Base>
void HdStreamRprim<Base>::Sync(HdSceneDelegate* delegate, HdRenderParam* renderParam,
                               HdDirtyBits* dirtyBits, const TfToken&) {
    auto* param = static_cast<HdStreamRenderParam*>(renderParam);
    HdDirtyBits bits = *dirtyBits;
    if (bits & HdChangeTracker::DirtyComputationPrimvarDesc) {
        bits |= HdChangeTracker::DirtyPoints | HdChangeTracker::DirtyNormals |
                HdChangeTracker::DirtyPrimvar;
    }
    const hds::GeometryPrim before = _prim;
    this->_UpdateVisibility(delegate, dirtyBits);
    _prim.placement.visible = this->IsVisible();
    if (!this->IsVisible()) {
        if (_variants.IsInScene() && (bits & HdChangeTracker::DirtyVisibility)) {
            Push(param);
        }
        *dirtyBits &= ~(HdChangeTracker::DirtyVisibility | HdChangeTracker::NewRepr |
                        HdChangeTracker::InitRepr);
        return;
    }
    const SdfPath& id = this->GetId();
    const SdfPath& instancerId = this->GetInstancerId();
    this->_UpdateInstancer(delegate, dirtyBits);
    HdInstancer::_SyncInstancerAndParents(delegate->GetRenderIndex(), instancerId);
    if (HdStreamSyncPlacement(delegate, id, instancerId, bits, param, &_prim.placement, &_scenePath,
                              &_isPathProvisional)) {
        bits |= HdChangeTracker::DirtyTopology; // The names of subsets begin with the path.
    }
    SyncCommonLook(delegate, param, bits);
    SyncLook(delegate, param, bits);
    if (bits & kGeometryBits) {
        SyncGeometry(delegate, param, bits);
    }
    const bool isSplitAnew =
        (bits & kVariantBits) &&
        HdStreamSyncVariants(delegate, instancerId, _scenePath, _prim, param, &_variants);
    if (isSplitAnew || !_variants.IsInScene() || !HdStreamEqual(_prim, before)) {
        Push(param);
    }
    *dirtyBits = HdChangeTracker::Clean;
}

template <typename Base>
void HdStreamRprim<Base>::SyncCommonLook(HdSceneDelegate* delegate, HdStreamRenderParam* param,
                                         HdDirtyBits bits) {
    const SdfPath& id = this->GetId();
    if (bits & HdChangeTracker::DirtyMaterialId) {
        this->SetMaterialId(delegate->GetMaterialId(id));
        _prim.materialPath = param->MaterialPath(delegate, this->GetMaterialId());
    }
    if (bits & HdChangeTracker::DirtyCategories) {
        _prim.categories = HdStreamCategories(delegate->GetCategories(id));
    }
    _prim.purpose = HdStreamPurpose(HdRprim::GetRenderTag());
    _prim.primId = this->GetPrimId();
}

template <typename Base>
void HdStreamRprim<Base>::SyncLook(HdSceneDelegate* delegate, HdStreamRenderParam* param,
                                   HdDirtyBits bits) {
    if ((bits & HdChangeTracker::DirtyMaterialId) && !_variants.IsInScene()) {
        HdStreamWarnOfNoLight(delegate, this->GetId(), _scenePath, param);
    }
}

template <typename Base>
void HdStreamRprim<Base>::SyncGeometry(HdSceneDelegate* delegate, HdStreamRenderParam* param,
                                       HdDirtyBits bits) {
    const SdfPath& id = this->GetId();
    auto geometry = _prim.geometry ? std::make_shared<hds::GeometryDescription>(*_prim.geometry)
                                   : std::make_shared<hds::GeometryDescription>();
    SyncTopology(delegate, param, bits, geometry.get());
    if (HdChangeTracker::IsAnyPrimvarDirty(bits, id)) {
        const TfToken& points = PointsName();
        const bool isCarried = geometry->primitives == hds::PrimitiveKind::Faces &&
                               HdStreamHasComputedPoints(delegate, id);
        if (isCarried) { // What is carried must be what is at rest, not what was carried before.
            bits |= HdChangeTracker::DirtyNormals;
        }
        HdStreamSyncPrimvars(delegate, id, points, bits, &geometry->points, &geometry->primvars);
        bool fit = true;
        bool isFinite = true;
        geometry->samples =
            HdStreamSamplePoints(delegate, id, points, param->Shutter(), &fit, &isFinite);
        if (!fit) {
            param->Push([path = _scenePath](hds::Session& session) {
                session.Warn(path, "its points change in number while the shutter is open: drawn "
                                   "without motion blur");
            });
        }
        if (!isFinite) {
            param->Push([path = _scenePath](hds::Session& session) {
                session.Warn(path, "velocities are not finite: points that have these stand still");
            });
        }
        if (geometry->primitives == hds::PrimitiveKind::Splats) {
            geometry->splatSamples =
                HdStreamSampleShapes(delegate, id, *geometry, param->Shutter());
        } else if (geometry->primitives != hds::PrimitiveKind::Faces) {
            geometry->widthSamples = HdStreamSampleWidths(delegate, id, param->Shutter());
        } else if (isCarried) {
            HdStreamCarryNormals(delegate, id, geometry.get());
        } else {
            geometry->normalSamples = HdStreamSampleNormals(delegate, id, param->Shutter());
        }
        AddDefaultPrimvars(&geometry->primvars);
    }
    if (!_prim.geometry || !HdStreamEqual(*geometry, *_prim.geometry)) {
        _prim.geometry = std::move(geometry);
    }
}

template <typename Base>
void HdStreamRprim<Base>::Push(HdStreamRenderParam* param) {
    const bool hasGeometry = CheckGeometry(param);
    _variants.Push(param, this->GetId(), _scenePath, _prim,
                   hasGeometry && HdStreamInstancer::IsPlaced(_prim.placement));
}

template <typename Base>
void HdStreamRprim<Base>::UpdateRenderTag(HdSceneDelegate* delegate, HdRenderParam* renderParam) {
    Base::UpdateRenderTag(delegate, renderParam);
    std::string purpose = HdStreamPurpose(HdRprim::GetRenderTag());
    if (purpose != _prim.purpose) {
        _prim.purpose = std::move(purpose);
        if (_variants.IsInScene()) {
            Push(static_cast<HdStreamRenderParam*>(renderParam));
        }
    }
}

template <typename Base>
void HdStreamRprim<Base>::Finalize(HdRenderParam* renderParam) {
    auto* param = static_cast<HdStreamRenderParam*>(renderParam);
    _variants.Finalize(param, _scenePath);
    if (!_scenePath.empty()) {
        param->ReleasePath(_scenePath);
        _scenePath.clear();
    }
    _prim.geometry.reset();
}

template class HdStreamRprim<HdMesh>;
template class HdStreamRprim<HdBasisCurves>;
template class HdStreamRprim<HdPoints>;

PXR_NAMESPACE_CLOSE_SCOPE
