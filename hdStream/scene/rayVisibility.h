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
/// \param[out] isUnreadable may be null: Karma's expression could not be read, and does not count.
std::uint32_t RayVisibilityFlags(const std::vector<Primvar>& primvars,
                                 bool* isUnreadable = nullptr);

/// Whether a primvar may be one of these, by its name.
bool SaysVisibility(const std::string& name);

} // namespace hds
