// SPDX-License-Identifier: Apache-2.0
#include "hdStream/geometry/limitCage.h"

#include <glm/common.hpp>
#include <glm/vec3.hpp>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

namespace hds {
namespace {

/// The difference to the points shrinks by a half or more with each step.
constexpr int kMaxSteps = 64;
constexpr double kPrecision = 1e-9; ///< of the largest coordinate, far below a float's

/// Limit points of the vertices of a cage.
class LimitMask {
public:
    /// \pre `indices` are below `numPoints`, and `counts` add up to their number.
    LimitMask(const SharedSpan<std::int32_t>& counts, const SharedSpan<std::int32_t>& indices,
              std::size_t numPoints)
        : _counts(counts), _indices(indices), _numFaces(numPoints, 0), _boundary(numPoints) {
        std::vector<std::pair<std::int32_t, std::int32_t>> edges;
        ForEachFace([&](const std::int32_t* face, std::int32_t count) {
            for (std::int32_t i = 0; i < count; ++i) {
                ++_numFaces[std::size_t(face[i])];
                edges.emplace_back(face[i], face[(i + 1) % count]);
            }
        });
        std::sort(edges.begin(), edges.end());
        for (const auto& [from, to] : edges) {
            if (!std::binary_search(edges.begin(), edges.end(), std::make_pair(to, from))) {
                _boundary[std::size_t(from)].push_back(to);
                _boundary[std::size_t(to)].push_back(from);
            }
        }
    }

    std::vector<glm::dvec3> operator()(const std::vector<glm::dvec3>& points) const {
        // (4 sum of face centres + 2 sum of neighbours + (n^2 - n) p) / (n (n + 5)); each neighbour
        // is met in two faces.
        std::vector<glm::dvec3> sums(points.size(), glm::dvec3(0.0));
        ForEachFace([&](const std::int32_t* face, std::int32_t count) {
            glm::dvec3 centre(0.0);
            for (std::int32_t i = 0; i < count; ++i) {
                centre += points[std::size_t(face[i])] / double(count);
            }
            for (std::int32_t i = 0; i < count; ++i) {
                sums[std::size_t(face[i])] += 4.0 * centre +
                                              points[std::size_t(face[(i + 1) % count])] +
                                              points[std::size_t(face[(i + count - 1) % count])];
            }
        });
        std::vector<glm::dvec3> limit(points);
        for (std::size_t i = 0; i < points.size(); ++i) {
            const double n = _numFaces[i];
            if (_boundary[i].empty() && n > 0.0) {
                limit[i] = (sums[i] + (n * n - n) * points[i]) / (n * (n + 5.0));
            } else if (_boundary[i].size() == 2 && n > 1.0) { // a cubic B-spline
                limit[i] = (4.0 * points[i] + points[std::size_t(_boundary[i][0])] +
                            points[std::size_t(_boundary[i][1])]) /
                           6.0;
            }
        }
        return limit;
    }

private:
    template <typename Visit>
    void ForEachFace(const Visit& visit) const {
        std::size_t corner = 0;
        for (const std::int32_t count : _counts) {
            visit(_indices.data() + corner, count);
            corner += std::size_t(count);
        }
    }

    const SharedSpan<std::int32_t>& _counts;
    const SharedSpan<std::int32_t>& _indices;
    std::vector<int> _numFaces;                       ///< of each point
    std::vector<std::vector<std::int32_t>> _boundary; ///< neighbours along it
};

bool IndicesFit(const GeometryDescription& cage) {
    std::size_t numCorners = 0;
    for (const std::int32_t count : cage.faceVertexCounts) {
        if (count < 0) {
            return false;
        }
        numCorners += std::size_t(count);
    }
    const auto numPoints = static_cast<std::int64_t>(cage.points.size() / 3);
    return numCorners == cage.faceVertexIndices.size() &&
           std::all_of(cage.faceVertexIndices.begin(), cage.faceVertexIndices.end(),
                       [&](std::int32_t index) { return index >= 0 && index < numPoints; });
}

double LargestCoordinate(const std::vector<glm::dvec3>& vectors) {
    double largest = 0.0;
    for (const glm::dvec3& v : vectors) {
        const glm::dvec3 a = glm::abs(v);
        largest = std::max({largest, a.x, a.y, a.z});
    }
    return largest;
}

} // namespace

void FitLimitSurface(GeometryDescription& cage) {
    if (cage.subdivisionScheme != "catmullClark" || !IndicesFit(cage)) {
        return;
    }
    std::vector<glm::dvec3> goal(cage.points.size() / 3);
    for (std::size_t i = 0; i < goal.size(); ++i) {
        goal[i] = {cage.points[3 * i], cage.points[3 * i + 1], cage.points[3 * i + 2]};
    }
    const LimitMask limitOf(cage.faceVertexCounts, cage.faceVertexIndices, goal.size());
    const double precision = kPrecision * LargestCoordinate(goal);
    std::vector<glm::dvec3> points = goal;
    for (int step = 0; step < kMaxSteps; ++step) {
        std::vector<glm::dvec3> missing = limitOf(points);
        for (std::size_t i = 0; i < goal.size(); ++i) {
            missing[i] = goal[i] - missing[i];
            points[i] += missing[i];
        }
        if (!(LargestCoordinate(missing) > precision)) {
            break;
        }
    }
    std::vector<float> fitted;
    fitted.reserve(cage.points.size());
    for (const glm::dvec3& p : points) {
        fitted.insert(fitted.end(), {float(p.x), float(p.y), float(p.z)});
    }
    cage.points = std::move(fitted);
}

} // namespace hds
