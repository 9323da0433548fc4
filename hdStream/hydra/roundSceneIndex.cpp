// SPDX-License-Identifier: Apache-2.0
#include "hdStream/hydra/roundSceneIndex.h"

#include "hdStream/session/session.h"

#include <pxr/base/gf/vec3f.h>
#include <pxr/base/vt/array.h>
#include <pxr/imaging/hd/dataSourceLegacyPrim.h>
#include <pxr/imaging/hd/meshSchema.h>
#include <pxr/imaging/hd/overlayContainerDataSource.h>
#include <pxr/imaging/hd/primvarSchema.h>
#include <pxr/imaging/hd/primvarsSchema.h>
#include <pxr/imaging/hd/retainedDataSource.h>
#include <pxr/imaging/hd/tokens.h>

#include <algorithm>
#include <vector>

PXR_NAMESPACE_OPEN_SCOPE

namespace {

bool IsRound(const TfToken& type) {
    return type == HdPrimTypeTokens->sphere || type == HdPrimTypeTokens->cylinder ||
           type == HdPrimTypeTokens->cone || type == HdPrimTypeTokens->capsule;
}

/// Scene delegates make meshes of implicit gprims themselves, and do not tell.
bool IsOfSceneDelegate(const HdSceneIndexPrim& prim) {
    return prim.dataSource && prim.dataSource->Get(HdSceneIndexEmulationTokens->sceneDelegate);
}

/// Whether a cage has the faces that OpenUSD gives to an implicit gprim that is round.
bool HasFacesOfRoundGprim(const hds::GeometryDescription& cage) {
    static const std::vector<hds::GeometryDescription> known = [] {
        std::vector<hds::GeometryDescription> meshes;
        for (const char* type : {"Sphere", "Cylinder", "Cone", "Capsule"}) {
            hds::ImplicitShape shape;
            shape.type = type;
            meshes.push_back(hds::MakeImplicitMesh(shape));
        }
        return meshes;
    }();
    const auto isEqual = [](const hds::SharedSpan<std::int32_t>& a,
                            const hds::SharedSpan<std::int32_t>& b) {
        return a.size() == b.size() && std::equal(a.begin(), a.end(), b.begin());
    };
    return std::any_of(known.begin(), known.end(), [&](const hds::GeometryDescription& mesh) {
        return isEqual(cage.faceVertexCounts, mesh.faceVertexCounts) &&
               isEqual(cage.faceVertexIndices, mesh.faceVertexIndices);
    });
}

std::vector<std::int32_t> IntsOf(const HdIntArrayDataSourceHandle& source) {
    const VtIntArray values = source ? source->GetTypedValue(0.0F) : VtIntArray();
    return {values.cbegin(), values.cend()};
}

constexpr std::size_t kMostPoints = 128; ///< no cage of OpenUSD has more

/// Points of a mesh; those of an implicit gprim's cage are fitted when they are asked for.
class FittedPointsSource final : public HdVec3fArrayDataSource {
public:
    HD_DECLARE_DATASOURCE(FittedPointsSource);

    VtValue GetValue(Time time) override { return VtValue(GetTypedValue(time)); }
    VtVec3fArray GetTypedValue(Time time) override {
        const VtValue value = _points->GetValue(time);
        if (!value.IsHolding<VtVec3fArray>()) {
            return {};
        }
        VtVec3fArray points = value.UncheckedGet<VtVec3fArray>();
        if (points.size() > kMostPoints) {
            return points;
        }
        const HdMeshSchema mesh = HdMeshSchema::GetFromParent(_prim);
        const HdMeshTopologySchema topology = mesh.GetTopology();
        const HdTokenDataSourceHandle scheme = mesh.GetSubdivisionScheme();
        hds::GeometryDescription cage;
        cage.subdivisionScheme = scheme ? scheme->GetTypedValue(0.0F).GetString() : "";
        cage.faceVertexCounts = IntsOf(topology.GetFaceVertexCounts());
        cage.faceVertexIndices = IntsOf(topology.GetFaceVertexIndices());
        if (!HasFacesOfRoundGprim(cage)) {
            return points;
        }
        const float* numbers = reinterpret_cast<const float*>(points.cdata());
        cage.points = std::vector<float>(numbers, numbers + 3 * points.size());
        hds::FitLimitSurface(cage);
        std::copy(cage.points.begin(), cage.points.end(), reinterpret_cast<float*>(points.data()));
        return points;
    }
    bool GetContributingSampleTimesForInterval(Time start, Time end,
                                               std::vector<Time>* times) override {
        return _points->GetContributingSampleTimesForInterval(start, end, times);
    }

private:
    FittedPointsSource(HdContainerDataSourceHandle prim, HdSampledDataSourceHandle points)
        : _prim(std::move(prim)), _points(std::move(points)) {}

    HdContainerDataSourceHandle _prim;
    HdSampledDataSourceHandle _points;
};

} // namespace

HdSceneIndexBaseRefPtr HdStreamRoundSceneIndex::New(const HdSceneIndexBaseRefPtr& inputScene,
                                                    const HdSceneIndexBaseRefPtr& authoredScene) {
    return TfCreateRefPtr(new HdStreamRoundSceneIndex(inputScene, authoredScene));
}

HdStreamRoundSceneIndex::HdStreamRoundSceneIndex(const HdSceneIndexBaseRefPtr& inputScene,
                                                 const HdSceneIndexBaseRefPtr& authoredScene)
    : HdSingleInputFilteringSceneIndexBase(inputScene), _authoredScene(authoredScene) {}

HdSceneIndexPrim HdStreamRoundSceneIndex::GetPrim(const SdfPath& path) const {
    HdSceneIndexPrim prim = _GetInputSceneIndex()->GetPrim(path);
    if (prim.primType != HdPrimTypeTokens->mesh) {
        return prim;
    }
    const HdSceneIndexPrim authored = _authoredScene->GetPrim(path);
    if (!IsRound(authored.primType) && !IsOfSceneDelegate(authored)) {
        return prim;
    }
    const HdSampledDataSourceHandle points = HdPrimvarsSchema::GetFromParent(prim.dataSource)
                                                 .GetPrimvar(HdPrimvarsSchemaTokens->points)
                                                 .GetPrimvarValue();
    if (points) {
        const HdContainerDataSourceHandle primvars = HdRetainedContainerDataSource::New(
            HdPrimvarsSchemaTokens->points,
            HdRetainedContainerDataSource::New(HdPrimvarSchemaTokens->primvarValue,
                                               FittedPointsSource::New(prim.dataSource, points)));
        prim.dataSource = HdOverlayContainerDataSource::New(
            HdRetainedContainerDataSource::New(HdPrimvarsSchemaTokens->primvars, primvars),
            prim.dataSource);
    }
    return prim;
}

SdfPathVector HdStreamRoundSceneIndex::GetChildPrimPaths(const SdfPath& path) const {
    return _GetInputSceneIndex()->GetChildPrimPaths(path);
}

void HdStreamRoundSceneIndex::_PrimsAdded(const HdSceneIndexBase&,
                                          const HdSceneIndexObserver::AddedPrimEntries& entries) {
    _SendPrimsAdded(entries);
}

void HdStreamRoundSceneIndex::_PrimsRemoved(
    const HdSceneIndexBase&, const HdSceneIndexObserver::RemovedPrimEntries& entries) {
    _SendPrimsRemoved(entries);
}

void HdStreamRoundSceneIndex::_PrimsDirtied(
    const HdSceneIndexBase&, const HdSceneIndexObserver::DirtiedPrimEntries& entries) {
    _SendPrimsDirtied(entries);
}

PXR_NAMESPACE_CLOSE_SCOPE
