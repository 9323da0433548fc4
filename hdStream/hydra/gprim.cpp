// SPDX-License-Identifier: Apache-2.0
#include "hdStream/hydra/gprim.h"

#include "hdStream/hydra/arrays.h"
#include "hdStream/hydra/instancer.h"
#include "hdStream/hydra/motion.h"
#include "hdStream/hydra/primvars.h"
#include "hdStream/hydra/renderParam.h"
#include "hdStream/hydra/scenePaths.h"

#include <pxr/imaging/hd/changeTracker.h>
#include <pxr/imaging/hd/tokens.h>

#include <algorithm>
#include <utility>
#include <vector>

PXR_NAMESPACE_OPEN_SCOPE

namespace {

bool IsEqual(const hds::SubdivTags& a, const hds::SubdivTags& b) {
    return a.interpolateBoundary == b.interpolateBoundary &&
           a.faceVaryingLinearInterpolation == b.faceVaryingLinearInterpolation &&
           a.triangleSubdivisionRule == b.triangleSubdivisionRule &&
           HdStreamEqual(a.creaseIndices, b.creaseIndices) &&
           HdStreamEqual(a.creaseLengths, b.creaseLengths) &&
           HdStreamEqual(a.creaseSharpnesses, b.creaseSharpnesses) &&
           HdStreamEqual(a.cornerIndices, b.cornerIndices) &&
           HdStreamEqual(a.cornerSharpnesses, b.cornerSharpnesses);
}

} // namespace

std::string HdStreamPurpose(const TfToken& renderTag) {
    // Hydra's name of the default purpose is another one.
    const bool isDefault = renderTag.IsEmpty() || renderTag == HdRenderTagTokens->geometry;
    return isDefault ? "default" : renderTag.GetString();
}

bool HdStreamEqual(const hds::GeometryDescription& a, const hds::GeometryDescription& b) {
    return a.primitives == b.primitives && a.curves->type == b.curves->type &&
           a.curves->basis == b.curves->basis && a.curves->wrap == b.curves->wrap &&
           a.subdivisionScheme == b.subdivisionScheme && a.leftHanded == b.leftHanded &&
           HdStreamEqual(a.points, b.points) && HdStreamEqual(a.samples, b.samples) &&
           HdStreamEqual(a.widthSamples, b.widthSamples) &&
           HdStreamEqual(a.normalSamples, b.normalSamples) &&
           HdStreamEqual(a.splatSamples->orientations, b.splatSamples->orientations) &&
           HdStreamEqual(a.splatSamples->scales, b.splatSamples->scales) &&
           HdStreamEqual(a.splatSamples->opacities, b.splatSamples->opacities) &&
           HdStreamEqual(a.faceVertexCounts, b.faceVertexCounts) &&
           HdStreamEqual(a.faceVertexIndices, b.faceVertexIndices) &&
           HdStreamEqual(a.holeIndices, b.holeIndices) && IsEqual(*a.subdivTags, *b.subdivTags) &&
           HdStreamEqual(a.primvars, b.primvars) &&
           std::equal(a.subsets.begin(), a.subsets.end(), b.subsets.begin(), b.subsets.end(),
                      [](const hds::MeshSubset& left, const hds::MeshSubset& right) {
                          return left.name == right.name && HdStreamEqual(left.faces, right.faces);
                      });
}

bool HdStreamEqual(const hds::GeometryPrim& a, const hds::GeometryPrim& b) {
    return a.geometry == b.geometry && a.placement.visible == b.placement.visible &&
           a.placement.worldFromObject == b.placement.worldFromObject &&
           HdStreamEqual(a.placement.samples, b.placement.samples) &&
           a.placement.instancerPath == b.placement.instancerPath &&
           HdStreamEqual(a.placement.instances, b.placement.instances) && a.purpose == b.purpose &&
           a.categories == b.categories && a.doubleSided == b.doubleSided &&
           a.cullStyle == b.cullStyle && a.materialPath == b.materialPath &&
           a.subsetMaterialPaths == b.subsetMaterialPaths && a.primId == b.primId &&
           a.light == b.light;
}

bool HdStreamSyncVariants(HdSceneDelegate* delegate, const SdfPath& instancerId,
                          const std::string& scenePath, const hds::GeometryPrim& prim,
                          HdStreamRenderParam* param, HdStreamGeometryVariants* variants) {
    static const std::vector<hds::Primvar> none;
    const hds::Placement& placement = prim.placement;
    HdStreamInstanceGroups groups =
        HdStreamGroupInstances(HdStreamInstancer::Levels(delegate->GetRenderIndex(), instancerId),
                               placement.instances, prim.geometry ? prim.geometry->primvars : none);
    const auto warn = [param](const std::string& path, const char* text) {
        param->Push([path, text](hds::Session& session) { session.Warn(path, text); });
    };
    if (groups.hasTooMany) {
        warn(placement.instancerPath,
             "more than 64 different values by instance of primvars that are read once a prim are "
             "not supported");
    }
    if (groups.variesAbove) {
        warn(scenePath, "primvars that are read once a prim differ between instances of an outer "
                        "instancer; those of the first are used");
    }
    return variants->Update(prim.geometry, std::move(groups));
}

bool HdStreamSyncPlacement(HdSceneDelegate* delegate, const SdfPath& id, const SdfPath& instancerId,
                           HdDirtyBits bits, HdStreamRenderParam* param, hds::Placement* placement,
                           std::string* scenePath, bool* isPathProvisional) {
    // What is drawn keeps its path, as where no instancer was found.
    *isPathProvisional = *isPathProvisional && !HdStreamInstancer::IsPlaced(*placement);
    const bool isMoved =
        HdStreamInstancer::UpdatePathOf(delegate->GetRenderIndex(), instancerId, param, placement);
    const bool isBlurDirty =
        param->Shutter().IsOpen() && HdChangeTracker::IsPrimvarDirty(bits, id, HdTokens->blurScale);
    if ((bits & HdChangeTracker::DirtyTransform) || isBlurDirty) {
        placement->worldFromObject = HdStreamToGlm(delegate->GetTransform(id));
        placement->samples = HdStreamSampleTransform(delegate, id, param->Shutter());
    }
    if (isMoved || (bits & HdChangeTracker::DirtyInstanceIndex)) {
        HdStreamInstancer::ReadInstances(delegate, instancerId, id, placement);
    }
    return HdStreamReservePath(delegate, id, instancerId, *placement, param, scenePath,
                               isPathProvisional);
}

PXR_NAMESPACE_CLOSE_SCOPE
