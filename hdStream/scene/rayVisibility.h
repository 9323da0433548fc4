// SPDX-License-Identifier: Apache-2.0
// Which rays see a prim, as its primvars say. Explained in docs/geometry.md.
#pragma once

#include "hdStream/scene/sceneDescription.h"
#include "kernels/shared/geometry.h"

#include <cstdint>
#include <string>
#include <vector>

namespace hds {

/// HDS_INSTANCE_* of a prim: who sees it, and whether it is held out. Constant primvars of one
/// number count; 0 is false. Those of hdstream win over those of other renderers.
std::uint32_t RayVisibilityFlags(const std::vector<Primvar>& primvars);

/// Whether some prim of a scene is a shadow catcher, seen or not.
bool HasCatchers(const SceneDescription& scene);

/// Whether a primvar may be one of these, by its name.
bool SaysVisibility(const std::string& name);

} // namespace hds
