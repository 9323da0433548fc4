// SPDX-License-Identifier: Apache-2.0
// About how bright the triangles of a mesh are, as weights of light samples: a guess decides
// noise alone. Explained in docs/lights.md, "Emissive meshes".
#pragma once

#include "hdStream/geometry/displacement.h"
#include "hdStream/scene/commit.h"

#include <memory>

namespace hds {

/// Reads what an emission is looked up from. The chunk must outlive it.
class EmissionGuess {
public:
    /// Prepares the texture, whose decoded mip the cache keeps.
    EmissionGuess(const EmissionInput& emission, const ChunkGeometry& chunk,
                  const MaterialCommit& materials, CommitCache* cache);

    /// Mean luminance over a triangle; 1 where the mesh or the material does not tell.
    double Of(std::uint32_t triangle) const;

private:
    const float* CornerValue(std::uint32_t triangle, int corner) const;

    const ChunkGeometry& _chunk;
    const GeometryAttribute* _attribute = nullptr;
    std::shared_ptr<const DisplacementAmount> _texture; ///< luminance at coordinates
    std::uint32_t _numPoints = 0;                       ///< to look up on a triangle
};

} // namespace hds
