// SPDX-License-Identifier: Apache-2.0
// What the arrays of a scene take.
#pragma once

#include "hdStream/scene/sceneDescription.h"

#include <cstdint>

namespace hds {

/// Bytes of arrays that are in memory as long as the scene, each as often as prims have it. Mapped
/// files count.
struct KeptArrays {
    std::uint64_t geometryBytes = 0;
    std::uint64_t instanceBytes = 0; ///< of instancers, and of what they place the numbers of
};

/// Those of a prim.
KeptArrays KeptArraysOf(const GeometryPrim& prim);
KeptArrays KeptArraysOf(const InstancerPrim& prim);

} // namespace hds
