// SPDX-License-Identifier: Apache-2.0
// Authored curves as a source of chunks: a group is a few segments of a curve, a primitive a piece
// of a segment that bends little. Explained in docs/curves.md.
#pragma once

#include "hdStream/base/log.h"
#include "hdStream/geometry/chunkSource.h"

#include <memory>
#include <string>

namespace hds {

/// Checks the curves and makes their source. Bad content warns with `primPath`, is counted and
/// dropped: wrong counts, indices out of range, points that are not finite, curves too short for
/// their basis, primvars of wrong length. Never throws on content. \param warnings must outlive the
/// source. \pre curves->primitives is Curves.
std::shared_ptr<const ChunkSource>
MakeCurveSource(std::shared_ptr<const GeometryDescription> curves, const std::string& primPath,
                Warnings& warnings);

} // namespace hds
