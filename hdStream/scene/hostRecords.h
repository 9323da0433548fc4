// SPDX-License-Identifier: Apache-2.0
// What host memory a scene takes beside its arrays, as long as it is there: of many small meshes
// more than the arrays. Explained in docs/memory-budgets.md.
#pragma once

#include "hdStream/scene/geometryCommit.h"
#include "hdStream/scene/sceneDescription.h"

#include <cstdint>
#include <string>

namespace hds {

/// About the bytes of what front ends have said of a prim at a path, without arrays.
std::uint64_t DescribedBytes(const std::string& path, const GeometryPrim& prim);
std::uint64_t DescribedBytes(const std::string& path, const InstancerPrim& prim);

/// About the bytes of what is known of the chunks of a prim's geometry, without pages and sources.
std::uint64_t PlannedBytes(const std::string& path, const PlannedGeometry& planned);

} // namespace hds
