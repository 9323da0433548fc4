// SPDX-License-Identifier: Apache-2.0
#include "hdStream/scene/mediaBounds.h"

#include <glm/common.hpp>
#include <glm/gtc/matrix_transform.hpp>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <limits>

namespace hds {

namespace {

/// Spreads what differs over all bits (the finaliser of SplitMix64).
std::uint64_t Mix(std::uint64_t bits) {
    bits = (bits ^ (bits >> 30U)) * 0xbf58476d1ce4e5b9U;
    bits = (bits ^ (bits >> 27U)) * 0x94d049bb133111ebU;
    return bits ^ (bits >> 31U);
}

/// Cells along the longest edge of a mesh's box: points in one of them count as one.
constexpr double kCells = 1024.0;

/// Cells in which points are one.
struct Lattice {
    double cells = 0.0; ///< a unit of length; 0: points are one where they are equal
    double shift = 0.0;
};

/// Of a point's place: -0 is 0.
std::uint64_t HashPlace(const Lattice& lattice, const float* point) {
    std::uint64_t hash = 0;
    for (int i = 0; i < 3; ++i) {
        double place = static_cast<double>(point[i]);
        if (lattice.cells > 0.0) {
            place = std::floor(place * lattice.cells + lattice.shift);
        }
        place += 0.0;
        std::uint64_t bits = 0;
        std::memcpy(&bits, &place, sizeof(bits));
        hash = Mix(hash + 0x9e3779b97f4a7c15U + bits);
    }
    return hash;
}

/// Of an edge; the other way along it has the negative.
std::uint64_t HashEdge(std::uint64_t from, std::uint64_t to) {
    if (from == to) {
        return 0; // it has no length
    }
    const std::uint64_t hash = Mix(std::min(from, to) + Mix(std::max(from, to)));
    return from < to ? hash : 0 - hash;
}

/// As IsClosed, with points that are one by a lattice.
bool IsClosedBy(const Lattice& lattice, const GeometryDescription& mesh) {
    const std::size_t numPoints = mesh.points.size() / 3;
    std::vector<bool> isHole(mesh.faceVertexCounts.size());
    for (const std::int32_t face : mesh.holeIndices) {
        if (face >= 0 && std::size_t(face) < isHole.size()) {
            isHole[face] = true;
        }
    }
    // Edges along which faces go both ways cancel; what is left would be 0 by chance alone, once in
    // 2^64.
    std::uint64_t sum = 0;
    std::size_t begin = 0;
    for (std::size_t face = 0; face < mesh.faceVertexCounts.size(); ++face) {
        const std::int32_t count = mesh.faceVertexCounts[face];
        if (count < 0 || begin + std::size_t(count) > mesh.faceVertexIndices.size()) {
            return false;
        }
        const std::int32_t* const points = mesh.faceVertexIndices.data() + begin;
        begin += std::size_t(count);
        if (count == 0 || isHole[face]) {
            continue;
        }
        const auto isPoint = [&](std::int32_t point) {
            return point >= 0 && std::size_t(point) < numPoints;
        };
        if (!std::all_of(points, points + count, isPoint)) {
            return false;
        }
        const auto place = [&](std::int32_t k) {
            return HashPlace(lattice, mesh.points.data() + 3 * std::size_t(points[k]));
        };
        std::uint64_t from = place(count - 1);
        for (std::int32_t k = 0; k < count; ++k) {
            const std::uint64_t to = place(k);
            sum += HashEdge(from, to);
            from = to;
        }
    }
    return sum == 0;
}

/// Length of the longest edge of the box of all points.
double LongestEdge(const SharedSpan<float>& points) {
    double longest = 0.0;
    for (std::size_t axis = 0; axis < 3; ++axis) {
        float least = std::numeric_limits<float>::max();
        float most = std::numeric_limits<float>::lowest();
        for (std::size_t i = axis; i < points.size(); i += 3) {
            least = std::min(least, points[i]);
            most = std::max(most, points[i]);
        }
        longest = std::max(longest, static_cast<double>(most) - static_cast<double>(least));
    }
    return longest;
}

} // namespace

bool IsClosed(const GeometryDescription& mesh) {
    if (IsClosedBy({}, mesh)) {
        return true;
    }
    // Points of a seam may differ by rounding. Of two lattices one has both in one cell.
    const double edge = LongestEdge(mesh.points);
    const double cells = kCells / edge;
    return edge > 0.0 && std::isfinite(cells) &&
           (IsClosedBy({cells, 0.5}, mesh) || IsClosedBy({cells, 0.0}, mesh));
}

std::optional<float> DielectricPriority(const std::vector<Primvar>& primvars) {
    for (const char* name :
         {"hdstream:dielectricPriority", "ri:attributes:trace:intersectpriority"}) {
        const auto found = std::find_if(primvars.begin(), primvars.end(),
                                        [&](const Primvar& one) { return one.name == name; });
        if (found != primvars.end() && found->interpolation == Interpolation::Constant &&
            found->values.size() == 1) {
            return found->values[0];
        }
    }
    return std::nullopt;
}

MediaBounds FindMediaBounds(const SceneDescription& scene, const std::vector<DrawnLeaf>& leaves,
                            glm::dvec3 centre) {
    MediaBounds box;
    for (const DrawnLeaf& leaf : leaves) {
        const LeafObject& object = leaf.object;
        if ((object.flags & HDS_INSTANCE_MEDIUM) == 0) {
            continue;
        }
        ForEachPlacement(scene, leaf.Prim().placement, [&](const glm::dmat4& worldFromObject) {
            for (int corner = 0; corner < 8; ++corner) {
                glm::dvec3 at = object.origin;
                for (int i = 0; i < 3; ++i) {
                    at[i] += static_cast<double>((corner >> i & 1) != 0 ? object.bounds.max[i]
                                                                        : object.bounds.min[i]);
                }
                const glm::dvec3 world = glm::dvec3(worldFromObject * glm::dvec4(at, 1.0)) - centre;
                box.min = glm::min(box.min, world);
                box.max = glm::max(box.max, world);
            }
        });
    }
    return box;
}

} // namespace hds
