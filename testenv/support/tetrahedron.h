// SPDX-License-Identifier: Apache-2.0
// The smallest closed mesh.
#pragma once

#include "hdStream/geometry/geometryDescription.h"

#include <cstdint>
#include <vector>

namespace hds::test {

/// Wound outwards.
inline GeometryDescription Tetrahedron() {
    GeometryDescription mesh;
    mesh.points = std::vector<float>{0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1};
    mesh.faceVertexCounts = std::vector<std::int32_t>{3, 3, 3, 3};
    mesh.faceVertexIndices = std::vector<std::int32_t>{0, 2, 1, 0, 1, 3, 1, 2, 3, 2, 0, 3};
    return mesh;
}

} // namespace hds::test
