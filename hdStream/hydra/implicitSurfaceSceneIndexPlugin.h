// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <pxr/imaging/hd/sceneIndexPlugin.h>
#include <pxr/pxr.h>

PXR_NAMESPACE_OPEN_SCOPE

/// Turns implicit gprims (sphere, cube, cone, cylinder, capsule, plane) into OpenUSD's own meshes
/// of them before the delegate sees them; the core's MakeImplicitMesh gives the same meshes.
class HdStreamImplicitSurfaceSceneIndexPlugin final : public HdSceneIndexPlugin {
public:
    HdStreamImplicitSurfaceSceneIndexPlugin();

protected:
    HdSceneIndexBaseRefPtr _AppendSceneIndex(const HdSceneIndexBaseRefPtr& inputScene,
                                             const HdContainerDataSourceHandle& inputArgs) override;
};

PXR_NAMESPACE_CLOSE_SCOPE
