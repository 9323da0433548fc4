// SPDX-License-Identifier: Apache-2.0
#include "hdStream/hydra/sceneIndexPlugins.h"

#include "hdStream/hydra/editSceneIndex.h"
#include "hdStream/hydra/linkSceneIndex.h"
#include "hdStream/hydra/passSceneIndex.h"
#include "hdStream/hydra/rendererPlugin.h"
#include "hdStream/hydra/roundSceneIndex.h"
#include "hdStream/hydra/shutterSceneIndex.h"

#include <pxr/base/tf/registryManager.h>
#include <pxr/base/tf/token.h>
#include <pxr/base/vt/array.h>
#include <pxr/imaging/hd/dependencyForwardingSceneIndex.h>
#include <pxr/imaging/hd/materialBindingsSchema.h>
#include <pxr/imaging/hd/retainedDataSource.h>
#include <pxr/imaging/hd/sceneGlobalsSchema.h>
#include <pxr/imaging/hd/sceneIndexPluginRegistry.h>
#include <pxr/imaging/hd/tokens.h>
#include <pxr/imaging/hdsi/implicitSurfaceSceneIndex.h>
#include <pxr/imaging/hdsi/lightLinkingSceneIndex.h>
#include <pxr/imaging/hdsi/materialBindingResolvingSceneIndex.h>
#include <pxr/imaging/hdsi/nurbsApproximatingSceneIndex.h>
#include <pxr/imaging/hdsi/renderSettingsFilteringSceneIndex.h>
#include <pxr/imaging/hdsi/tetMeshConversionSceneIndex.h>
#include <pxr/imaging/hdsi/velocityMotionResolvingSceneIndex.h>

#include <vector>

PXR_NAMESPACE_OPEN_SCOPE

namespace {

/// Behind all else that hosts insert, as for OpenUSD's own renderers.
constexpr HdSceneIndexPluginRegistry::InsertionPhase kLastPhase = 1000;

HdContainerDataSourceHandle RenderSettingsArguments() {
    return HdRetainedContainerDataSource::New(
        HdsiRenderSettingsFilteringSceneIndexTokens->namespacePrefixes,
        HdRetainedTypedSampledDataSource<VtArray<TfToken>>::New(
            VtArray<TfToken>{TfToken("hdstream:")}));
}

HdContainerDataSourceHandle ImplicitSurfaceArguments() {
    const HdDataSourceBaseHandle toMesh =
        HdRetainedTypedSampledDataSource<TfToken>::New(HdsiImplicitSurfaceSceneIndexTokens->toMesh);
    std::vector<TfToken> names{HdPrimTypeTokens->sphere,  HdPrimTypeTokens->cube,
                               HdPrimTypeTokens->cone,    HdPrimTypeTokens->cylinder,
                               HdPrimTypeTokens->capsule, HdPrimTypeTokens->plane};
    const std::vector<HdDataSourceBaseHandle> values(names.size(), toMesh);
    return HdRetainedContainerDataSource::New(names.size(), names.data(), values.data());
}

constexpr double kDefaultTimeCodesPerSecond = 24.0;

/// Time codes a second of a scene when it is asked for, which may be populated later.
class TimeCodesSource final : public HdTypedSampledDataSource<float> {
public:
    HD_DECLARE_DATASOURCE(TimeCodesSource);

    VtValue GetValue(Time time) override { return VtValue(GetTypedValue(time)); }
    float GetTypedValue(Time) override {
        return static_cast<float>(HdStreamTimeCodesPerSecond(_scene));
    }
    bool GetContributingSampleTimesForInterval(Time, Time, std::vector<Time>*) override {
        return false;
    }

private:
    explicit TimeCodesSource(const HdSceneIndexBaseRefPtr& scene) : _scene(scene) {}

    HdSceneIndexBaseRefPtr _scene;
};

HdContainerDataSourceHandle VelocityArguments(const HdSceneIndexBaseRefPtr& scene) {
    return HdRetainedContainerDataSource::New(TfToken("fps"), TimeCodesSource::New(scene));
}

void Register(const char* name, HdSceneIndexPluginRegistry::InsertionPhase phase,
              HdSceneIndexPluginRegistry::InsertionOrder order) {
    HdSceneIndexPluginRegistry::GetInstance().RegisterSceneIndexForRenderer(
        kHdStreamDisplayName, TfToken(name), nullptr, phase, order);
}

} // namespace

TF_REGISTRY_FUNCTION(TfType) {
    HdSceneIndexPluginRegistry::Define<HdStreamSceneIndexPlugin>();
    HdSceneIndexPluginRegistry::Define<HdStreamDependencySceneIndexPlugin>();
}

TF_REGISTRY_FUNCTION(HdSceneIndexPlugin) {
    Register("HdStreamSceneIndexPlugin", 0, HdSceneIndexPluginRegistry::InsertionOrderAtStart);
    Register("HdStreamDependencySceneIndexPlugin", kLastPhase,
             HdSceneIndexPluginRegistry::InsertionOrderAtEnd);
}

double HdStreamTimeCodesPerSecond(const HdSceneIndexBaseRefPtr& scene) {
    // By name: the schema has had the member since 25.05 only.
    static const TfToken name("timeCodesPerSecond");
    const HdContainerDataSourceHandle globals =
        scene ? HdSceneGlobalsSchema::GetFromSceneIndex(scene).GetContainer() : nullptr;
    const auto source = globals ? HdSampledDataSource::Cast(globals->Get(name)) : nullptr;
    const double found =
        source ? VtValue::Cast<double>(source->GetValue(0.0F)).GetWithDefault(0.0) : 0.0;
    return found > 0.0 ? found : kDefaultTimeCodesPerSecond;
}

HdStreamSceneIndexPlugin::HdStreamSceneIndexPlugin() = default;

HdSceneIndexBaseRefPtr
HdStreamSceneIndexPlugin::_AppendSceneIndex(const HdSceneIndexBaseRefPtr& inputScene,
                                            const HdContainerDataSourceHandle&) {
    HdSceneIndexBaseRefPtr scene = HdStreamPassSceneIndex::New(inputScene);
    scene = HdsiRenderSettingsFilteringSceneIndex::New(scene, RenderSettingsArguments());
    scene = HdStreamRoundSceneIndex::New(
        HdsiImplicitSurfaceSceneIndex::New(scene, ImplicitSurfaceArguments()), scene);
    scene = HdsiNurbsApproximatingSceneIndex::New(scene);
    scene = HdsiTetMeshConversionSceneIndex::New(scene);
    scene = HdsiVelocityMotionResolvingSceneIndex::New(scene, VelocityArguments(inputScene));
    scene = HdStreamLinkSceneIndex::New(scene);
    scene = HdsiLightLinkingSceneIndex::New(scene, nullptr);
    scene = HdsiMaterialBindingResolvingSceneIndex::New(
        scene, {HdTokens->full, HdMaterialBindingsSchemaTokens->allPurpose},
        HdMaterialBindingsSchemaTokens->allPurpose);
    scene = HdStreamEditSceneIndex::New(scene);
    return HdStreamShutterSceneIndex::New(scene);
}

HdStreamDependencySceneIndexPlugin::HdStreamDependencySceneIndexPlugin() = default;

HdSceneIndexBaseRefPtr
HdStreamDependencySceneIndexPlugin::_AppendSceneIndex(const HdSceneIndexBaseRefPtr& inputScene,
                                                      const HdContainerDataSourceHandle&) {
    return HdDependencyForwardingSceneIndex::New(inputScene);
}

PXR_NAMESPACE_CLOSE_SCOPE
