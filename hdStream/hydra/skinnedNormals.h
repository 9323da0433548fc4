// SPDX-License-Identifier: Apache-2.0
// Normals of meshes whose points are computed: usdSkelImaging skins points alone.
#pragma once

#include "hdStream/session/session.h"

#include <pxr/imaging/hd/sceneDelegate.h>
#include <pxr/pxr.h>
#include <pxr/usd/sdf/path.h>

PXR_NAMESPACE_OPEN_SCOPE

/// True when a computation makes the points of a prim.
bool HdStreamHasComputedPoints(HdSceneDelegate* delegate, const SdfPath& id);

/// Puts the normals of a polygon mesh with computed points where these are, at the frame and at the
/// samples around it. `mesh` has its faces, points and samples. Legacy delegates do not list the
/// normals, but tell them, and points at rest, when asked; a host that knows no such points leaves
/// normals as they are.
void HdStreamCarryNormals(HdSceneDelegate* delegate, const SdfPath& id,
                          hds::GeometryDescription* mesh);

PXR_NAMESPACE_CLOSE_SCOPE
