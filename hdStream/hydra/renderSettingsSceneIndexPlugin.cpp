// SPDX-License-Identifier: Apache-2.0
#include "hdStream/hydra/renderSettingsSceneIndexPlugin.h"

#include "hdStream/hydra/rendererPlugin.h"

#include <pxr/base/tf/registryManager.h>
#include <pxr/base/tf/token.h>
#include <pxr/base/vt/array.h>
#include <pxr/imaging/hd/retainedDataSource.h>
#include <pxr/imaging/hd/sceneIndexPluginRegistry.h>
#include <pxr/imaging/hdsi/renderSettingsFilteringSceneIndex.h>

PXR_NAMESPACE_OPEN_SCOPE

TF_REGISTRY_FUNCTION(TfType) {
    HdSceneIndexPluginRegistry::Define<HdStreamRenderSettingsSceneIndexPlugin>();
}

TF_REGISTRY_FUNCTION(HdSceneIndexPlugin) {
    const HdSceneIndexPluginRegistry::InsertionPhase insertionPhase = 0;
    HdSceneIndexPluginRegistry::GetInstance().RegisterSceneIndexForRenderer(
        kHdStreamDisplayName, TfToken("HdStreamRenderSettingsSceneIndexPlugin"),
        HdRetainedContainerDataSource::New(
            HdsiRenderSettingsFilteringSceneIndexTokens->namespacePrefixes,
            HdRetainedTypedSampledDataSource<VtArray<TfToken>>::New(
                VtArray<TfToken>{TfToken("hdstream:")})),
        insertionPhase, HdSceneIndexPluginRegistry::InsertionOrderAtStart);
}

HdStreamRenderSettingsSceneIndexPlugin::HdStreamRenderSettingsSceneIndexPlugin() = default;

HdSceneIndexBaseRefPtr HdStreamRenderSettingsSceneIndexPlugin::_AppendSceneIndex(
    const HdSceneIndexBaseRefPtr& inputScene, const HdContainerDataSourceHandle& inputArgs) {
    return HdsiRenderSettingsFilteringSceneIndex::New(inputScene, inputArgs);
}

PXR_NAMESPACE_CLOSE_SCOPE
