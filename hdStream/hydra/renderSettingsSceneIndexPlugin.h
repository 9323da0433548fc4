// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <pxr/imaging/hd/sceneIndexPlugin.h>
#include <pxr/pxr.h>

PXR_NAMESPACE_OPEN_SCOPE

/// Tells render settings prims which of them is the scene's active one, and keeps the attributes of
/// namespace "hdstream:" only.
class HdStreamRenderSettingsSceneIndexPlugin final : public HdSceneIndexPlugin {
public:
    HdStreamRenderSettingsSceneIndexPlugin();

protected:
    HdSceneIndexBaseRefPtr _AppendSceneIndex(const HdSceneIndexBaseRefPtr& inputScene,
                                             const HdContainerDataSourceHandle& inputArgs) override;
};

PXR_NAMESPACE_CLOSE_SCOPE
