// SPDX-License-Identifier: Apache-2.0
#include "hdStream/hydra/implicitSurfaceSceneIndexPlugin.h"

#include "hdStream/hydra/rendererPlugin.h"

#include <pxr/base/tf/registryManager.h>
#include <pxr/base/tf/token.h>
#include <pxr/imaging/hd/retainedDataSource.h>
#include <pxr/imaging/hd/sceneIndexPluginRegistry.h>
#include <pxr/imaging/hd/tokens.h>
#include <pxr/imaging/hdsi/implicitSurfaceSceneIndex.h>

#include <vector>

PXR_NAMESPACE_OPEN_SCOPE

namespace {

HdContainerDataSourceHandle MakeArguments() {
    const HdDataSourceBaseHandle toMesh =
        HdRetainedTypedSampledDataSource<TfToken>::New(HdsiImplicitSurfaceSceneIndexTokens->toMesh);
    std::vector<TfToken> names{HdPrimTypeTokens->sphere,  HdPrimTypeTokens->cube,
                               HdPrimTypeTokens->cone,    HdPrimTypeTokens->cylinder,
                               HdPrimTypeTokens->capsule, HdPrimTypeTokens->plane};
    const std::vector<HdDataSourceBaseHandle> values(names.size(), toMesh);
    return HdRetainedContainerDataSource::New(names.size(), names.data(), values.data());
}

} // namespace

TF_REGISTRY_FUNCTION(TfType) {
    HdSceneIndexPluginRegistry::Define<HdStreamImplicitSurfaceSceneIndexPlugin>();
}

TF_REGISTRY_FUNCTION(HdSceneIndexPlugin) {
    const HdSceneIndexPluginRegistry::InsertionPhase insertionPhase = 0;
    HdSceneIndexPluginRegistry::GetInstance().RegisterSceneIndexForRenderer(
        kHdStreamDisplayName, TfToken("HdStreamImplicitSurfaceSceneIndexPlugin"), MakeArguments(),
        insertionPhase, HdSceneIndexPluginRegistry::InsertionOrderAtStart);
}

HdStreamImplicitSurfaceSceneIndexPlugin::HdStreamImplicitSurfaceSceneIndexPlugin() = default;

HdSceneIndexBaseRefPtr HdStreamImplicitSurfaceSceneIndexPlugin::_AppendSceneIndex(
    const HdSceneIndexBaseRefPtr& inputScene, const HdContainerDataSourceHandle& inputArgs) {
    return HdsiImplicitSurfaceSceneIndex::New(inputScene, inputArgs);
}

PXR_NAMESPACE_CLOSE_SCOPE
