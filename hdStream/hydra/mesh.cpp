// SPDX-License-Identifier: Apache-2.0
#include "hdStream/hydra/mesh.h"

#include "hdStream/hydra/arrays.h"
#include "hdStream/hydra/categories.h"
#include "hdStream/hydra/gprim.h"
#include "hdStream/hydra/instancer.h"
#include "hdStream/hydra/lightParameters.h"
#include "hdStream/hydra/motion.h"
#include "hdStream/hydra/primvars.h"
#include "hdStream/hydra/renderParam.h"

#include <pxr/imaging/hd/changeTracker.h>
#include <pxr/imaging/hd/sceneDelegate.h>
#include <pxr/imaging/hd/tokens.h>
#include <pxr/imaging/pxOsd/tokens.h>

#include <algorithm>
#include <set>
#include <utility>

PXR_NAMESPACE_OPEN_SCOPE

namespace {

constexpr HdDirtyBits kGeometryBits =
    HdChangeTracker::DirtyPoints | HdChangeTracker::DirtyTopology |
    HdChangeTracker::DirtySubdivTags | HdChangeTracker::DirtyPrimvar |
    HdChangeTracker::DirtyNormals | HdChangeTracker::DirtyWidths |
    HdChangeTracker::DirtyComputationPrimvarDesc;

/// What may change how instances split the mesh.
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

/// Faces that are not drawn, in ascending order when some are invisible: holes, and what a host
/// hides, whose neighbours are shaped as if it were there, as around holes.
VtIntArray HiddenFaces(const HdMeshTopology& topology) {
    if (topology.GetInvisibleFaces().empty()) {
        return topology.GetHoleIndices();
    }
    std::set<int> faces(topology.GetHoleIndices().cbegin(), topology.GetHoleIndices().cend());
    faces.insert(topology.GetInvisibleFaces().cbegin(), topology.GetInvisibleFaces().cend());
    return VtIntArray(faces.begin(), faces.end());
}

hds::CullStyle CullStyleFrom(HdCullStyle style) {
    switch (style) {
    case HdCullStyleNothing:
        return hds::CullStyle::Nothing;
    case HdCullStyleBack:
        return hds::CullStyle::Back;
    case HdCullStyleFront:
        return hds::CullStyle::Front;
    case HdCullStyleBackUnlessDoubleSided:
        return hds::CullStyle::BackUnlessDoubleSided;
    case HdCullStyleFrontUnlessDoubleSided:
        return hds::CullStyle::FrontUnlessDoubleSided;
    default:
        return hds::CullStyle::DontCare;
    }
}

void SetUnlessEmpty(const TfToken& token, std::string* text) {
    if (!token.IsEmpty()) {
        *text = token.GetString();
    }
}

hds::SubdivTags SubdivTagsFrom(const PxOsdSubdivTags& tags) {
    hds::SubdivTags result;
    SetUnlessEmpty(tags.GetVertexInterpolationRule(), &result.interpolateBoundary);
    SetUnlessEmpty(tags.GetFaceVaryingInterpolationRule(), &result.faceVaryingLinearInterpolation);
    SetUnlessEmpty(tags.GetTriangleSubdivision(), &result.triangleSubdivisionRule);
    result.creaseIndices = HdStreamShareArray<std::int32_t>(tags.GetCreaseIndices());
    result.creaseLengths = HdStreamShareArray<std::int32_t>(tags.GetCreaseLengths());
    result.creaseSharpnesses = HdStreamShareArray<float>(tags.GetCreaseWeights());
    result.cornerIndices = HdStreamShareArray<std::int32_t>(tags.GetCornerIndices());
    result.cornerSharpnesses = HdStreamShareArray<float>(tags.GetCornerWeights());
    return result;
}

} // namespace

HdStreamMesh::HdStreamMesh(const SdfPath& id) : HdMesh(id) {}

HdDirtyBits HdStreamMesh::GetInitialDirtyBitsMask() const {
    return kAllBits;
}

HdDirtyBits HdStreamMesh::_PropagateDirtyBits(HdDirtyBits bits) const {
    return bits;
}

void HdStreamMesh::_InitRepr(const TfToken& reprToken, HdDirtyBits*) {
    // Draw items serve rasterisers; Hydra wants a repr to exist all the same.
    const auto found = std::find_if(_reprs.begin(), _reprs.end(), _ReprComparator(reprToken));
    if (found == _reprs.end()) {
        _reprs.emplace_back(reprToken, HdReprSharedPtr());
    }
}

void HdStreamMesh::Sync(HdSceneDelegate* delegate, HdRenderParam* renderParam,
                        HdDirtyBits* dirtyBits, const TfToken&) {
    auto* param = static_cast<HdStreamRenderParam*>(renderParam);
    HdDirtyBits bits = *dirtyBits;
    if (bits & HdChangeTracker::DirtyComputationPrimvarDesc) {
        bits |= HdChangeTracker::DirtyPoints | HdChangeTracker::DirtyNormals |
                HdChangeTracker::DirtyPrimvar;
    }
    const hds::MeshPrim before = _prim;
    _UpdateVisibility(delegate, dirtyBits);
    _prim.placement.visible = IsVisible();
    if (!IsVisible()) {
        if (_variants.IsInScene() && (bits & HdChangeTracker::DirtyVisibility)) {
            Push(param);
        }
        *dirtyBits &= ~(HdChangeTracker::DirtyVisibility | HdChangeTracker::NewRepr |
                        HdChangeTracker::InitRepr);
        return;
    }
    _UpdateInstancer(delegate, dirtyBits);
    HdInstancer::_SyncInstancerAndParents(delegate->GetRenderIndex(), GetInstancerId());
    HdStreamSyncPlacement(delegate, GetId(), GetInstancerId(), bits, param, &_prim.placement,
                          &_scenePath);
    SyncLook(delegate, param, bits);
    if (bits & kGeometryBits) {
        SyncGeometry(delegate, param, bits);
    }
    const bool isSplitAnew = (bits & kVariantBits) && SyncVariants(delegate, param);
    if (isSplitAnew || !_variants.IsInScene() || !HdStreamEqual(_prim, before)) {
        Push(param);
    }
    *dirtyBits = HdChangeTracker::Clean;
}

void HdStreamMesh::SyncLook(HdSceneDelegate* delegate, HdStreamRenderParam* param,
                            HdDirtyBits bits) {
    const SdfPath& id = GetId();
    if (bits & HdChangeTracker::DirtyMaterialId) {
        SetMaterialId(delegate->GetMaterialId(id));
        _prim.materialPath = param->MaterialPath(delegate, GetMaterialId());
    }
    // Lights have no bit of their own in meshes; legacy delegates set that of primvars for inputs.
    if (bits & (HdChangeTracker::DirtyMaterialId | HdChangeTracker::DirtyPrimvar)) {
        SyncLight(delegate, param);
    }
    if (bits & HdChangeTracker::DirtyCategories) {
        _prim.categories = HdStreamCategories(delegate->GetCategories(id));
    }
    if (bits & HdChangeTracker::DirtyDoubleSided) {
        _prim.doubleSided = IsDoubleSided(delegate);
    }
    if (bits & HdChangeTracker::DirtyCullStyle) {
        _prim.cullStyle = CullStyleFrom(GetCullStyle(delegate));
    }
    if (bits & HdChangeTracker::DirtyDisplayStyle) {
        param->SetRefineLevel(GetDisplayStyle(delegate).refineLevel);
    }
    _prim.purpose = HdStreamPurpose(HdRprim::GetRenderTag());
    _prim.primId = GetPrimId();
}

void HdStreamMesh::SyncLight(HdSceneDelegate* delegate, HdStreamRenderParam* param) {
    _prim.light = HdStreamReadMeshLight(delegate, GetId());
    if (_prim.light) {
        for (const std::string& feature : HdStreamUnsupportedLightFeatures(delegate, GetId())) {
            param->Warn(SdfPath(_scenePath), feature + " is not supported yet");
        }
        if (HdStreamHidesLinks(delegate, GetId())) {
            param->Warn(SdfPath(_scenePath),
                        "links of a mesh light do not come through Hydra; ignored");
        }
    }
}

void HdStreamMesh::SyncGeometry(HdSceneDelegate* delegate, HdStreamRenderParam* param,
                                HdDirtyBits bits) {
    auto mesh = _prim.mesh ? std::make_shared<hds::MeshDescription>(*_prim.mesh)
                           : std::make_shared<hds::MeshDescription>();
    if (bits & HdChangeTracker::DirtyTopology) {
        SyncTopology(delegate, param, mesh.get());
    }
    if (bits & HdChangeTracker::DirtySubdivTags) {
        mesh->subdivTags = SubdivTagsFrom(delegate->GetSubdivTags(GetId()));
    }
    if (HdChangeTracker::IsAnyPrimvarDirty(bits, GetId())) {
        HdStreamSyncPrimvars(delegate, GetId(), bits, &mesh->points, &mesh->primvars);
        mesh->samples = HdStreamSamplePoints(delegate, GetId(), param->Shutter());
    }
    if (!_prim.mesh || !HdStreamEqual(*mesh, *_prim.mesh)) {
        _prim.mesh = std::move(mesh);
    }
}

void HdStreamMesh::SyncTopology(HdSceneDelegate* delegate, HdStreamRenderParam* param,
                                hds::MeshDescription* mesh) {
    const HdMeshTopology topology = GetMeshTopology(delegate);
    mesh->faceVertexCounts = HdStreamShareArray<std::int32_t>(topology.GetFaceVertexCounts());
    mesh->faceVertexIndices = HdStreamShareArray<std::int32_t>(topology.GetFaceVertexIndices());
    mesh->holeIndices = HdStreamShareArray<std::int32_t>(HiddenFaces(topology));
    mesh->subdivisionScheme =
        topology.GetScheme().IsEmpty() ? "none" : topology.GetScheme().GetString();
    mesh->leftHanded = topology.GetOrientation() == HdTokens->leftHanded;
    mesh->subsets.clear();
    _prim.subsetMaterialPaths.clear();
    for (const HdGeomSubset& subset : topology.GetGeomSubsets()) {
        if (subset.type == HdGeomSubset::TypeFaceSet && !subset.indices.empty()) {
            mesh->subsets.push_back({_scenePath + "/" + subset.id.GetName(),
                                     HdStreamShareArray<std::int32_t>(subset.indices)});
            _prim.subsetMaterialPaths.push_back(param->MaterialPath(delegate, subset.materialId));
        }
    }
}

bool HdStreamMesh::SyncVariants(HdSceneDelegate* delegate, HdStreamRenderParam* param) {
    return HdStreamSyncVariants(delegate, GetInstancerId(), _scenePath, _prim, param, &_variants);
}

void HdStreamMesh::Push(HdStreamRenderParam* param) {
    const bool hasFaces =
        _prim.mesh && !_prim.mesh->points.empty() && !_prim.mesh->faceVertexCounts.empty();
    if (_prim.light && !hasFaces) {
        param->Warn(SdfPath(_scenePath), "mesh light has no faces; it lights nothing");
    }
    _variants.Push(param, GetId(), _scenePath, _prim,
                   hasFaces && HdStreamInstancer::IsPlaced(_prim.placement));
}

void HdStreamMesh::UpdateRenderTag(HdSceneDelegate* delegate, HdRenderParam* renderParam) {
    HdMesh::UpdateRenderTag(delegate, renderParam);
    std::string purpose = HdStreamPurpose(HdRprim::GetRenderTag());
    if (purpose != _prim.purpose) {
        _prim.purpose = std::move(purpose);
        if (_variants.IsInScene()) {
            Push(static_cast<HdStreamRenderParam*>(renderParam));
        }
    }
}

void HdStreamMesh::Finalize(HdRenderParam* renderParam) {
    auto* param = static_cast<HdStreamRenderParam*>(renderParam);
    _variants.Finalize(param, _scenePath);
    if (!_scenePath.empty()) {
        param->ReleasePath(_scenePath);
        _scenePath.clear();
    }
    _prim.mesh.reset();
}

PXR_NAMESPACE_CLOSE_SCOPE
