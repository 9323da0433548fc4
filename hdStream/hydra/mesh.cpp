// SPDX-License-Identifier: Apache-2.0
#include "hdStream/hydra/mesh.h"

#include "hdStream/hydra/arrays.h"
#include "hdStream/hydra/lightParameters.h"
#include "hdStream/hydra/renderParam.h"

#include <pxr/imaging/hd/changeTracker.h>
#include <pxr/imaging/hd/renderIndex.h>
#include <pxr/imaging/hd/sceneDelegate.h>
#include <pxr/imaging/hd/tokens.h>
#include <pxr/imaging/pxOsd/tokens.h>

#include <set>
#include <string>

PXR_NAMESPACE_OPEN_SCOPE

namespace {

/// True for the names of the materials that OpenUSD's draw modes bind the faces of a card to.
bool IsOfCard(const std::string& name) {
    static const std::string kPrefix = "subsetMaterial";
    if (name.compare(0, kPrefix.size(), kPrefix) != 0) {
        return false;
    }
    const std::string face = name.substr(kPrefix.size());
    return face.size() == 4 && face[0] >= 'X' && face[0] <= 'Z' &&
           (face.substr(1) == "Pos" || face.substr(1) == "Neg");
}

/// The material of a subset; empty: none of its own. Legacy scene delegates bind a card's faces
/// without texture to a material that they do not make. They make those of the other faces together
/// with the card, so one that is missing here is meant to be missing, unlike other materials, which
/// may arrive later.
SdfPath MaterialOf(const HdGeomSubset& subset, const HdRenderIndex& index) {
    const bool isMissing = IsOfCard(subset.materialId.GetName()) &&
                           index.GetSprim(HdPrimTypeTokens->material, subset.materialId) == nullptr;
    return isMissing ? SdfPath() : subset.materialId;
}

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

void HdStreamMesh::SyncLook(HdSceneDelegate* delegate, HdStreamRenderParam* param,
                            HdDirtyBits bits) {
    // Lights have no bit of their own in meshes; legacy delegates set that of primvars for inputs.
    if (bits & (HdChangeTracker::DirtyMaterialId | HdChangeTracker::DirtyPrimvar)) {
        SyncLight(delegate, param);
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

void HdStreamMesh::SyncTopology(HdSceneDelegate* delegate, HdStreamRenderParam* param,
                                HdDirtyBits bits, hds::GeometryDescription* mesh) {
    if (bits & HdChangeTracker::DirtyTopology) {
        const HdMeshTopology topology = GetMeshTopology(delegate);
        mesh->faceVertexCounts = HdStreamShareArray<std::int32_t>(topology.GetFaceVertexCounts());
        mesh->faceVertexIndices = HdStreamShareArray<std::int32_t>(topology.GetFaceVertexIndices());
        mesh->holeIndices = HdStreamShareArray<std::int32_t>(HiddenFaces(topology));
        mesh->subdivisionScheme =
            topology.GetScheme().IsEmpty() ? "none" : topology.GetScheme().GetString();
        mesh->leftHanded = topology.GetOrientation() == HdTokens->leftHanded;
        SyncSubsets(delegate, param, topology.GetGeomSubsets(), mesh);
    }
    if (bits & HdChangeTracker::DirtySubdivTags) {
        mesh->subdivTags = SubdivTagsFrom(delegate->GetSubdivTags(GetId()));
    }
}

void HdStreamMesh::SyncSubsets(HdSceneDelegate* delegate, HdStreamRenderParam* param,
                               const HdGeomSubsets& subsets, hds::GeometryDescription* mesh) {
    mesh->subsets.clear();
    _prim.subsetMaterialPaths.clear();
    for (const HdGeomSubset& subset : subsets) {
        if (subset.type == HdGeomSubset::TypeFaceSet && !subset.indices.empty()) {
            mesh->subsets.push_back({_scenePath + "/" + subset.id.GetName(),
                                     HdStreamShareArray<std::int32_t>(subset.indices)});
            _prim.subsetMaterialPaths.push_back(
                param->MaterialPath(delegate, MaterialOf(subset, delegate->GetRenderIndex())));
        }
    }
}

bool HdStreamMesh::CheckGeometry(HdStreamRenderParam* param) const {
    const bool hasFaces = _prim.geometry && !_prim.geometry->points.empty() &&
                          !_prim.geometry->faceVertexCounts.empty();
    if (_prim.light && !hasFaces) {
        param->Warn(SdfPath(_scenePath), "mesh light has no faces; it lights nothing");
    }
    return hasFaces;
}

PXR_NAMESPACE_CLOSE_SCOPE
