// SPDX-License-Identifier: Apache-2.0
// Authored points as a source of chunks: a group is a point, drawn as a sphere.
// Explained in docs/curves.md.
#pragma once

#include "hdStream/base/log.h"
#include "hdStream/geometry/chunkSource.h"

#include <memory>
#include <string>

namespace hds {

/// Checks the points and makes their source. Points that are not finite or have no width are
/// dropped with a line. \param warnings must outlive the source. \pre points->primitives is Points.
std::shared_ptr<const ChunkSource>
MakePointSource(std::shared_ptr<const GeometryDescription> points, const std::string& primPath,
                Warnings& warnings);

} // namespace hds
