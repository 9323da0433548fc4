// SPDX-License-Identifier: Apache-2.0
// The triangles of an interpreted mesh as a source of chunks: a group is a triangle.
#pragma once

#include "hdStream/geometry/triangleMesh.h"

#include <memory>

namespace hds {

/// Serves a whole mesh that is there already.
class TriangleMeshSource final : public ChunkSource {
public:
    explicit TriangleMeshSource(std::shared_ptr<const TriangleMesh> mesh);

    std::uint32_t GroupTriangles(std::uint32_t) const override { return 1; }
    Bounds GroupBounds(std::uint32_t group) const override;
    ChunkGeometry Gather(const std::uint32_t* groups, std::size_t count) const override;

private:
    std::shared_ptr<const TriangleMesh> _mesh;
};

} // namespace hds
