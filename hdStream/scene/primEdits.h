// SPDX-License-Identifier: Apache-2.0
// Which edits of a scene leave what a commit has made of its prims as it is (scene/primCommit):
// those that move, hide or show prims, and those of lights; and which leave all of it but what
// depends on the shape of the prim.
#pragma once

#include "hdStream/scene/sceneDescription.h"

namespace hds {

/// Whether two states of a prim differ in nothing but its transform and whether it is visible.
bool LeavesPrims(const GeometryPrim& before, const GeometryPrim& after);

/// Whether they differ in nothing but that and the shape: in values, as many as before, of points
/// and of primvars that vary over the prim.
bool LeavesAllButShape(const GeometryPrim& before, const GeometryPrim& after);

/// As LeavesPrims of an instancer, whose instances may be at other places: as many as before.
bool LeavesPrims(const InstancerPrim& before, const InstancerPrim& after);

/// Whether two states of a light agree in what prims know of lights: links and fading shadows, the
/// image, which comes first among textures, and spaces of colours.
bool LeavesPrims(const LightPrim& before, const LightPrim& after);

} // namespace hds
