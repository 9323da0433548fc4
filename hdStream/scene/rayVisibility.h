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

/// Whether a primvar is one of these, by its name.
bool SaysRayVisibility(const std::string& name);

/// Whether a primvar has a name of those that say something of a whole prim: these, and others in
/// their namespaces.
bool IsInObjectNamespace(const std::string& name);

/// Instances of a prim that the same rays see.
struct InstancesSeen {
    std::uint32_t flags = 0;            ///< as of RayVisibilityFlags
    SharedSpan<std::int32_t> instances; ///< the prim's, with -1 for those that others see
};

/// What primvars of its instancer say of a prim's instances, where they differ; what the prim has
/// itself wins. In the order of first instances; empty where no primvar of the instancer says
/// anything. Further instancers are not asked.
std::vector<InstancesSeen> RayVisibilityByInstance(const SceneDescription& scene,
                                                   const GeometryPrim& prim,
                                                   bool* isUnreadable = nullptr);

} // namespace hds
