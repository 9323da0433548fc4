// SPDX-License-Identifier: Apache-2.0
// What host memory a scene takes beside its arrays, as long as it is there: of many small meshes
// more than the arrays. Explained in docs/memory-budgets.md.
#pragma once

#include "hdStream/scene/geometryStore.h"
#include "hdStream/scene/sceneDescription.h"

#include <cstdint>

namespace hds {

/// About the bytes of what front ends have said of geometry and instancers, without arrays.
std::uint64_t DescribedBytes(const SceneDescription& scene);

/// About the bytes of what is known of the geometry's chunks, without pages and sources.
std::uint64_t PlannedBytes(const GeometryStore& store);

} // namespace hds
