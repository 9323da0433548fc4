// SPDX-License-Identifier: Apache-2.0
// Bare triangles as a source of chunks.
#pragma once

#include "hdStream/geometry/triangleMeshSource.h"

#include <glm/common.hpp>

#include <memory>

namespace hds::test {

/// Fills what a mesh of positions and triangles lacks: a triangle is a face of its own.
inline std::shared_ptr<const ChunkSource> SourceOf(TriangleMesh mesh) {
    for (std::uint32_t i = 0; i < mesh.triangles.size(); ++i) {
        if (mesh.faces.size() <= i) {
            mesh.faces.push_back(i);
        }
        if (mesh.corners.size() <= i) {
            mesh.corners.emplace_back(3 * i, 3 * i + 1, 3 * i + 2);
        }
        for (int k = 0; k < 3; ++k) {
            const glm::vec3& position = mesh.positions[mesh.triangles[i][k]];
            mesh.bounds.min = glm::min(mesh.bounds.min, position);
            mesh.bounds.max = glm::max(mesh.bounds.max, position);
        }
    }
    return std::make_shared<const TriangleMeshSource>(
        std::make_shared<const TriangleMesh>(std::move(mesh)));
}

} // namespace hds::test
