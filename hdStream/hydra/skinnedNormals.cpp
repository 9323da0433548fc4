// SPDX-License-Identifier: Apache-2.0
#include "hdStream/hydra/skinnedNormals.h"

#include "hdStream/hydra/arrays.h"
#include "hdStream/hydra/floatValues.h"

#include <pxr/imaging/hd/dataSource.h>
#include <pxr/imaging/hd/renderIndex.h>
#include <pxr/imaging/hd/sceneIndex.h>
#include <pxr/imaging/hd/tokens.h>

#include <algorithm>
#include <optional>
#include <utility>

PXR_NAMESPACE_OPEN_SCOPE

namespace {

/// Who made a prim: a legacy delegate, which tells more than the scene index before it lists.
HdSceneDelegate* MakerOf(HdSceneDelegate* delegate, const SdfPath& id) {
    const HdSceneIndexBaseRefPtr scene = delegate->GetRenderIndex().GetTerminalSceneIndex();
    const HdContainerDataSourceHandle prim = scene ? scene->GetPrim(id).dataSource : nullptr;
    using Source = HdTypedSampledDataSource<HdSceneDelegate*>;
    const Source::Handle source =
        prim ? Source::Cast(prim->Get(HdSceneIndexEmulationTokens->sceneDelegate)) : nullptr;
    HdSceneDelegate* maker = source ? source->GetTypedValue(0.0F) : nullptr;
    return maker != nullptr ? maker : delegate;
}

/// The normals at rest that a delegate tells without listing them. How they go with the mesh it
/// does not say: their number does.
std::optional<hds::Primvar> UnlistedNormals(HdSceneDelegate* delegate, const SdfPath& id,
                                            const hds::GeometryDescription& mesh) {
    VtIntArray indices;
    std::optional<HdStreamFloatRows> rows =
        HdStreamGetFloatRows(delegate->GetIndexedPrimvar(id, HdTokens->normals, &indices));
    const auto IsZero = [](float value) { return value == 0.0F; };
    if (!rows || rows->numComponents != 3 ||
        std::all_of(rows->values.begin(), rows->values.end(), IsZero)) { // UsdImaging's fallback
        return std::nullopt;
    }
    const std::size_t count = indices.empty() ? rows->values.size() / 3 : indices.size();
    hds::Primvar normals{"normals", hds::Interpolation::Constant, 3, std::move(rows->values),
                         HdStreamShareArray<std::int32_t>(indices)};
    if (count == mesh.points.size() / 3) {
        normals.interpolation = hds::Interpolation::Vertex;
    } else if (count == mesh.faceVertexIndices.size()) {
        normals.interpolation = hds::Interpolation::FaceVarying;
    } else if (count == mesh.faceVertexCounts.size()) {
        normals.interpolation = hds::Interpolation::Uniform;
    } else if (count != 1) {
        return std::nullopt;
    }
    return normals;
}

} // namespace

bool HdStreamHasComputedPoints(HdSceneDelegate* delegate, const SdfPath& id) {
    const HdExtComputationPrimvarDescriptorVector computed =
        delegate->GetExtComputationPrimvarDescriptors(id, HdInterpolationVertex);
    return std::any_of(computed.begin(), computed.end(),
                       [](const HdExtComputationPrimvarDescriptor& descriptor) {
                           return descriptor.name == HdTokens->points;
                       });
}

void HdStreamCarryNormals(HdSceneDelegate* delegate, const SdfPath& id,
                          hds::GeometryDescription* mesh) {
    mesh->normalSamples.clear();
    HdSceneDelegate* maker = MakerOf(delegate, id);
    const std::optional<HdStreamFloatRows> atRest =
        HdStreamGetFloatRows(maker->Get(id, HdTokens->points));
    if (mesh->subdivisionScheme != "none" || !atRest || atRest->numComponents != 3) {
        return;
    }
    const auto listed = std::find_if(mesh->primvars.begin(), mesh->primvars.end(),
                                     [](const hds::Primvar& it) { return it.name == "normals"; });
    const std::optional<hds::Primvar> normals = listed != mesh->primvars.end()
                                                    ? std::optional<hds::Primvar>(*listed)
                                                    : UnlistedNormals(maker, id, *mesh);
    if (listed != mesh->primvars.end()) {
        mesh->primvars.erase(listed);
    }
    const auto Carried = [&](const hds::SharedSpan<float>& points) {
        return normals ? hds::CarryNormals(*normals, *mesh, atRest->values, points) : std::nullopt;
    };
    std::optional<hds::Primvar> carried = Carried(mesh->points);
    if (!carried) {
        return;
    }
    for (const hds::PointSample& sample : mesh->samples) {
        if (const std::optional<hds::Primvar> moved = Carried(sample.points)) {
            mesh->normalSamples.push_back({sample.time, moved->values});
        }
    }
    mesh->primvars.push_back(std::move(*carried));
}

PXR_NAMESPACE_CLOSE_SCOPE
