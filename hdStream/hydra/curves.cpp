// SPDX-License-Identifier: Apache-2.0
#include "hdStream/hydra/curves.h"

#include "hdStream/hydra/arrays.h"

#include <pxr/imaging/hd/changeTracker.h>
#include <pxr/imaging/hd/tokens.h>

#include <algorithm>
#include <utility>

PXR_NAMESPACE_OPEN_SCOPE

void HdStreamBasisCurves::SyncTopology(HdSceneDelegate* delegate, HdStreamRenderParam*,
                                       HdDirtyBits bits, hds::GeometryDescription* curves) {
    curves->primitives = hds::PrimitiveKind::Curves;
    if (bits & HdChangeTracker::DirtyTopology) {
        const HdBasisCurvesTopology topology = GetBasisCurvesTopology(delegate);
        curves->faceVertexCounts =
            HdStreamShareArray<std::int32_t>(topology.GetCurveVertexCounts());
        curves->faceVertexIndices = HdStreamShareArray<std::int32_t>(topology.GetCurveIndices());
        hds::CurveForm& form = curves->curves.Edit();
        form.type = topology.GetCurveType().GetString();
        form.basis = topology.GetCurveBasis().GetString();
        form.wrap = topology.GetCurveWrap().GetString();
    }
}

void HdStreamBasisCurves::AddDefaultPrimvars(std::vector<hds::Primvar>* primvars) const {
    // Curves without widths have a constant one of 1: legacy scene delegates say so, scene indices
    // do not.
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

bool HdStreamBasisCurves::CheckGeometry(HdStreamRenderParam*) const {
    return _prim.geometry && !_prim.geometry->points.empty() &&
           !_prim.geometry->faceVertexCounts.empty();
}

void HdStreamPoints::SyncTopology(HdSceneDelegate*, HdStreamRenderParam*, HdDirtyBits,
                                  hds::GeometryDescription* points) {
    points->primitives = hds::PrimitiveKind::Points;
}

bool HdStreamPoints::CheckGeometry(HdStreamRenderParam*) const {
    return _prim.geometry && !_prim.geometry->points.empty();
}

const TfToken& HdStreamParticleField() {
    static const TfToken type("particleField");
    return type;
}

void HdStreamSplats::SyncTopology(HdSceneDelegate*, HdStreamRenderParam*, HdDirtyBits,
                                  hds::GeometryDescription* splats) {
    splats->primitives = hds::PrimitiveKind::Splats;
}

const TfToken& HdStreamSplats::PointsName() const {
    static const TfToken name("positions");
    return name;
}

bool HdStreamSplats::CheckGeometry(HdStreamRenderParam*) const {
    return _prim.geometry && !_prim.geometry->points.empty();
}

PXR_NAMESPACE_CLOSE_SCOPE
