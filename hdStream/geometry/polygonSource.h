// SPDX-License-Identifier: Apache-2.0
// An authored mesh drawn as polygons, as a source of chunks: a group is a face, or a part of one
// with very many vertices. Explained in docs/geometry.md.
#pragma once

#include "hdStream/base/log.h"
#include "hdStream/geometry/chunkSource.h"
#include "hdStream/geometry/displacement.h"

#include <memory>
#include <string>

namespace hds {

/// Checks the mesh and makes its source. Bad content warns with `primPath`, is counted and dropped:
/// out-of-range indices, NaN or infinite points, faces with fewer than 3 vertices or without area,
/// primvars of wrong length. Never throws on content; an unusable mesh has empty bounds. Values of
/// primvars are looked at when the first chunk is gathered, with their warnings.
/// Cost: one pass over the faces, on all cores.
/// \param displacement moves the points along smooth normals; shading normals are those of the
/// moved triangles then. \param keepsRest as MakeSubdivSource. \param warnings must outlive the
/// source.
std::shared_ptr<const ChunkSource>
MakePolygonSource(std::shared_ptr<const GeometryDescription> mesh, const std::string& primPath,
                  const Displacement& displacement, Warnings& warnings, bool keepsRest = false);

} // namespace hds
