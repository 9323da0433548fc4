// SPDX-License-Identifier: Apache-2.0
// What Hydra's scene goes through before the delegate's prims read it, for scene indices and for
// legacy scene delegates alike. All but one step are OpenUSD's own.
#pragma once

#include <pxr/imaging/hd/sceneIndexPlugin.h>
#include <pxr/pxr.h>

PXR_NAMESPACE_OPEN_SCOPE

/// Time codes a second, as the scene's globals say since OpenUSD 25.05; where they do not, 24:
/// UsdStage's default, and Storm's. \param scene may be null.
double HdStreamTimeCodesPerSecond(const HdSceneIndexBaseRefPtr& scene);

/// Other gprims become meshes, velocities are applied, material bindings of purpose `full` win,
/// the links of lights become categories,
/// render settings prims are told which is active.
class HdStreamSceneIndexPlugin final : public HdSceneIndexPlugin {
public:
    HdStreamSceneIndexPlugin();

protected:
    HdSceneIndexBaseRefPtr _AppendSceneIndex(const HdSceneIndexBaseRefPtr& inputScene,
                                             const HdContainerDataSourceHandle& inputArgs) override;
};

/// Passes changes on to the prims that depend on what has changed; behind all other scene indices.
class HdStreamDependencySceneIndexPlugin final : public HdSceneIndexPlugin {
public:
    HdStreamDependencySceneIndexPlugin();

protected:
    HdSceneIndexBaseRefPtr _AppendSceneIndex(const HdSceneIndexBaseRefPtr& inputScene,
                                             const HdContainerDataSourceHandle& inputArgs) override;
};

PXR_NAMESPACE_CLOSE_SCOPE
