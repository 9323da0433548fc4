// SPDX-License-Identifier: Apache-2.0
#include "hdStream/geometry/curveCounts.h"

#include <algorithm>
#include <string>

namespace hds {

CurveCounts ReadCurveCounts(const GeometryDescription& curves, std::size_t numPoints,
                            PrimLog& log) {
    CurveCounts result;
    const bool isIndexed = !curves.faceVertexIndices.empty();
    const std::uint64_t numGiven = isIndexed ? curves.faceVertexIndices.size() : numPoints;
    const bool isSegmented = curves.curves->wrap == "segmented";
    std::uint64_t end = 0;
    std::size_t numBad = 0;
    std::uint32_t face = 0;
    for (const std::int32_t count : curves.faceVertexCounts) {
        // Values are made for the vertices that there are, whatever is asked for.
        const std::uint64_t begin = std::min(end, numGiven);
        end += static_cast<std::uint64_t>(std::max(count, 0));
        const bool isGood = count >= 0 && end <= numGiven;
        numBad += isGood ? 0 : 1;
        for (std::uint64_t first = begin; isSegmented && isGood && first + 1 < end; first += 2) {
            result.begins.push_back(first);
            result.counts.push_back(2);
            result.faces.push_back(face);
        }
        if (!isSegmented) {
            result.begins.push_back(begin);
            result.counts.push_back(isGood ? static_cast<std::uint32_t>(count) : 0U);
        }
        ++face;
    }
    if (end != numGiven) {
        log.Warn("curveVertexCounts ask for " + std::to_string(end) + " points, there are " +
                 std::to_string(numGiven));
    }
    if (numBad > 0) {
        log.Warn(std::to_string(numBad) +
                 " curves dropped: curveVertexCounts negative or beyond the points");
    }
    return result;
}

} // namespace hds
