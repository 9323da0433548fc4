// SPDX-License-Identifier: Apache-2.0
// Which vertices each curve has. Internal to geometry. Explained in docs/curves.md.
#pragma once

#include "hdStream/geometry/meshContent.h"

#include <cstdint>
#include <vector>

namespace hds {

struct CurveCounts {
    std::vector<std::uint64_t> begins; ///< [numCurves] first vertex; not beyond what is given
    std::vector<std::uint32_t> counts; ///< [numCurves] vertices; 0: asks for too many, or negative
    std::vector<std::uint32_t> faces;  ///< [numCurves] authored curve; empty: the same
};

/// Vertices of each curve; each pair is a curve of its own where the wrap is "segmented".
CurveCounts ReadCurveCounts(const GeometryDescription& curves, std::size_t numPoints, PrimLog& log);

} // namespace hds
