// SPDX-License-Identifier: Apache-2.0
// A closed subdivision surface for tests of leaks: displaced, creased, with edges of all rates.
#pragma once

#include "hdStream/geometry/chunkSource.h"
#include "hdStream/geometry/triangleMesh.h"

#include <memory>
#include <string>

namespace hds::test {

/// Star-shaped about the origin, outside of the ball of radius 0.9. \param scheme catmullClark or
/// loop.
std::shared_ptr<const ChunkSource> MakeDicedSource(const std::string& scheme);

/// All triangles of a source, each chunk of which had one group: nothing is shared between groups.
TriangleMesh GatherMesh(const ChunkSource& source);

} // namespace hds::test
