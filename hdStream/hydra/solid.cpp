// SPDX-License-Identifier: Apache-2.0
#include "hdStream/hydra/solid.h"

#include "hdStream/hydra/arrays.h"
#include "hdStream/hydra/categories.h"
#include "hdStream/hydra/motion.h"
#include "hdStream/hydra/primvars.h"
#include "hdStream/hydra/renderParam.h"

#include <pxr/imaging/hd/changeTracker.h>
#include <pxr/imaging/hd/instancer.h>
#include <pxr/imaging/hd/sceneDelegate.h>
#include <pxr/imaging/hd/tokens.h>

#include <algorithm>
#include <type_traits>
#include <utility>
#include <vector>

PXR_NAMESPACE_OPEN_SCOPE

namespace {

constexpr HdDirtyBits kGeometryBits =
    HdChangeTracker::DirtyPoints | HdChangeTracker::DirtyTopology | HdChangeTracker::DirtyPrimvar |
    HdChangeTracker::DirtyNormals | HdChangeTracker::DirtyWidths |
    HdChangeTracker::DirtyComputationPrimvarDesc;

/// What may change how instances split the prim.
constexpr HdDirtyBits kVariantBits =
    kGeometryBits | HdChangeTracker::DirtyInstancer | HdChangeTracker::DirtyInstanceIndex;

constexpr HdDirtyBits kAllBits =
    kGeometryBits | HdChangeTracker::InitRepr | HdChangeTracker::DirtyTransform |
    HdChangeTracker::DirtyVisibility | HdChangeTracker::DirtyMaterialId |
    HdChangeTracker::DirtyPrimID | HdChangeTracker::DirtyInstancer |
    HdChangeTracker::DirtyInstanceIndex | HdChangeTracker::DirtyDisplayStyle |
    HdChangeTracker::DirtyRenderTag | HdChangeTracker::DirtyExtent | HdChangeTracker::DirtyRepr |
    HdChangeTracker::DirtyCategories;

template <typename Base>
constexpr bool kIsCurves = std::is_same_v<Base, HdBasisCurves>;

void SetTopology(const HdBasisCurvesTopology& topology, hds::MeshDescription* curves) {
    curves->faceVertexCounts = HdStreamShareArray<std::int32_t>(topology.GetCurveVertexCounts());
    curves->faceVertexIndices = HdStreamShareArray<std::int32_t>(topology.GetCurveIndices());
    curves->curves.type = topology.GetCurveType().GetString();
    curves->curves.basis = topology.GetCurveBasis().GetString();
    curves->curves.wrap = topology.GetCurveWrap().GetString();
}

/// Curves without widths have a constant one of 1: legacy scene delegates say so, scene indices do
/// not.
void AddDefaultWidths(std::vector<hds::Primvar>* primvars) {
    const bool hasWidths =
        std::any_of(primvars->begin(), primvars->end(), [](const hds::Primvar& primvar) {
            return primvar.name == HdTokens->widths.GetString();
        });
    if (!hasWidths) {
        hds::Primvar widths;
        widths.name = HdTokens->widths.GetString();
        widths.values = std::vector<float>{1.0F};
        primvars->push_back(std::move(widths));
    }
}

} // namespace

template <typename Base>
HdStreamSolid<Base>::HdStreamSolid(const SdfPath& id) : Base(id) {}

template <typename Base>
HdDirtyBits HdStreamSolid<Base>::GetInitialDirtyBitsMask() const {
    return kAllBits;
}

template <typename Base>
HdDirtyBits HdStreamSolid<Base>::_PropagateDirtyBits(HdDirtyBits bits) const {
    return bits;
}

template <typename Base>
void HdStreamSolid<Base>::_InitRepr(const TfToken& reprToken, HdDirtyBits*) {
    // Draw items serve rasterisers; Hydra wants a repr to exist all the same.
    const auto found = std::find_if(this->_reprs.begin(), this->_reprs.end(),
                                    typename Base::_ReprComparator(reprToken));
    if (found == this->_reprs.end()) {
        this->_reprs.emplace_back(reprToken, HdReprSharedPtr());
    }
}

template <typename Base>
void HdStreamSolid<Base>::Sync(HdSceneDelegate* delegate, HdRenderParam* renderParam,
                               HdDirtyBits* dirtyBits, const TfToken&) {
    auto* param = static_cast<HdStreamRenderParam*>(renderParam);
    HdDirtyBits bits = *dirtyBits;
    if (bits & HdChangeTracker::DirtyComputationPrimvarDesc) {
        bits |= HdChangeTracker::DirtyPoints | HdChangeTracker::DirtyPrimvar;
    }
    const hds::MeshPrim before = _prim;
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
    this->_UpdateInstancer(delegate, dirtyBits);
    HdInstancer::_SyncInstancerAndParents(delegate->GetRenderIndex(), this->GetInstancerId());
    HdStreamSyncPlacement(delegate, id, this->GetInstancerId(), bits, param, &_prim.placement,
                          &_scenePath);
    if (bits & HdChangeTracker::DirtyMaterialId) {
        this->SetMaterialId(delegate->GetMaterialId(id));
        _prim.materialPath = param->MaterialPath(delegate, this->GetMaterialId());
    }
    if (bits & HdChangeTracker::DirtyCategories) {
        _prim.categories = HdStreamCategories(delegate->GetCategories(id));
    }
    _prim.purpose = HdStreamPurpose(HdRprim::GetRenderTag());
    _prim.primId = this->GetPrimId();
    if (bits & kGeometryBits) {
        SyncGeometry(delegate, param, bits);
    }
    const bool isSplitAnew =
        (bits & kVariantBits) && HdStreamSyncVariants(delegate, this->GetInstancerId(), _scenePath,
                                                      _prim, param, &_variants);
    if (isSplitAnew || !_variants.IsInScene() || !HdStreamEqual(_prim, before)) {
        Push(param);
    }
    *dirtyBits = HdChangeTracker::Clean;
}

template <typename Base>
void HdStreamSolid<Base>::SyncGeometry(HdSceneDelegate* delegate, HdStreamRenderParam* param,
                                       HdDirtyBits bits) {
    auto solid = _prim.mesh ? std::make_shared<hds::MeshDescription>(*_prim.mesh)
                            : std::make_shared<hds::MeshDescription>();
    solid->primitives = kIsCurves<Base> ? hds::PrimitiveKind::Curves : hds::PrimitiveKind::Points;
    if constexpr (kIsCurves<Base>) {
        if (bits & HdChangeTracker::DirtyTopology) {
            SetTopology(this->GetBasisCurvesTopology(delegate), solid.get());
        }
    }
    if (HdChangeTracker::IsAnyPrimvarDirty(bits, this->GetId())) {
        HdStreamSyncPrimvars(delegate, this->GetId(), bits, &solid->points, &solid->primvars);
        solid->samples = HdStreamSamplePoints(delegate, this->GetId(), param->Shutter());
        if constexpr (kIsCurves<Base>) {
            AddDefaultWidths(&solid->primvars);
        }
    }
    if (!_prim.mesh || !HdStreamEqual(*solid, *_prim.mesh)) {
        _prim.mesh = std::move(solid);
    }
}

template <typename Base>
void HdStreamSolid<Base>::Push(HdStreamRenderParam* param) {
    const bool isDrawable = _prim.mesh && !_prim.mesh->points.empty() &&
                            (!kIsCurves<Base> || !_prim.mesh->faceVertexCounts.empty());
    _variants.Push(param, this->GetId(), _scenePath, _prim, isDrawable);
}

template <typename Base>
void HdStreamSolid<Base>::UpdateRenderTag(HdSceneDelegate* delegate, HdRenderParam* renderParam) {
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
void HdStreamSolid<Base>::Finalize(HdRenderParam* renderParam) {
    auto* param = static_cast<HdStreamRenderParam*>(renderParam);
    _variants.Finalize(param, _scenePath);
    if (!_scenePath.empty()) {
        param->ReleasePath(_scenePath);
        _scenePath.clear();
    }
    _prim.mesh.reset();
}

template class HdStreamSolid<HdBasisCurves>;
template class HdStreamSolid<HdPoints>;

PXR_NAMESPACE_CLOSE_SCOPE
