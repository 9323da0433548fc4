// SPDX-License-Identifier: Apache-2.0
// The paths that prims get in the core's scene: those of USD where Hydra can tell them, so that
// both front ends name a prim alike (docs/hydra.md, "Names of prims").
#pragma once

#include "hdStream/session/session.h"

#include <pxr/imaging/hd/sceneDelegate.h>
#include <pxr/imaging/hd/sceneIndex.h>
#include <pxr/pxr.h>
#include <pxr/usd/sdf/path.h>

#include <string>

PXR_NAMESPACE_OPEN_SCOPE

class HdStreamRenderParam;

/// The path of a prim. Below native instances: its path in the first instance. Below a point
/// instancer: its USD path when it lies below the instancer, else "INSTANCER{PATH}". Hydra's id,
/// which is unique, where neither is known. Thread-safe during Sync.
/// \param delegate the one that syncs the prim
/// \param instancerId empty: not instanced
/// \param placement its instancer's scene path and its instances; the id is the path of a prim
/// that no instance draws yet
std::string HdStreamScenePath(HdSceneDelegate* delegate, const SdfPath& id,
                              const SdfPath& instancerId, const hds::Placement& placement);

/// Reserves the path of a prim that has none, and another one where no instance told the path that
/// it has: names must not depend on what was seen first. Thread-safe during Sync.
/// \param[in,out] path of the prim; must not be in the scene unless it is kept
/// \param[in,out] isProvisional true while `path` is an id for want of instances
/// \return true when the prim had another path
bool HdStreamReservePath(HdSceneDelegate* delegate, const SdfPath& id, const SdfPath& instancerId,
                         const hds::Placement& placement, HdStreamRenderParam* param,
                         std::string* path, bool* isProvisional);

/// The path of an instancer: of the first native instance it stands for, or its own.
std::string HdStreamInstancerScenePath(HdSceneDelegate* delegate, const SdfPath& id,
                                       const SdfPath& parentId, const std::string& parentPath);

/// The path of a material: its id, and below native instances that in the first instance where
/// scene indices tell it.
std::string HdStreamMaterialScenePath(HdSceneDelegate* delegate, const SdfPath& id);

/// The instancer of a prim of a scene index; empty: none.
SdfPath HdStreamInstancerOf(const HdContainerDataSourceHandle& prim);

/// Where the native instances of an instancer are in its scene index; empty for point instancers.
VtArray<SdfPath> HdStreamInstanceLocations(const HdContainerDataSourceHandle& instancer);

/// The USD paths of a prim: one, or one for each native instance that shows it, through the first
/// instance of what is further out. Empty paths where scene indices do not tell.
SdfPathVector HdStreamUsdPaths(const HdSceneIndexBaseRefPtr& scene, const SdfPath& path);

/// The same of the native instances of an instancer, in its order; none for point instancers.
SdfPathVector HdStreamUsdPathsOfInstances(const HdSceneIndexBaseRefPtr& scene,
                                          const SdfPath& instancer);

/// The legacy scene delegate that a prim comes from; null when scene indices made it.
HdSceneDelegate* HdStreamFindLegacyDelegate(HdSceneDelegate* delegate, const SdfPath& id);

PXR_NAMESPACE_CLOSE_SCOPE
