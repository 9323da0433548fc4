// SPDX-License-Identifier: Apache-2.0
// Diced surfaces against the limit masks of uniform refinement: every vertex, normal and
// face-varying value of a uniform level, for all tags, schemes and kinds of faces.
#include "testenv/unit/geometry/subdivFixtures.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <set>

namespace hds::test {
namespace {

/// Finds points by position: cells of a grid much larger than rounding, smaller than edges.
class PointFinder {
public:
    explicit PointFinder(const std::vector<glm::dvec3>& points) : _points(points) {
        for (std::size_t i = 0; i < points.size(); ++i) {
            _cells[Cell(points[i], 0, 0, 0)].push_back(i);
        }
    }

    /// All points within `distance`, which is at most a cell.
    std::vector<std::size_t> Near(const glm::dvec3& point, double distance) const {
        std::vector<std::size_t> found;
        for (int dz = -1; dz <= 1; ++dz) {
            for (int dy = -1; dy <= 1; ++dy) {
                for (int dx = -1; dx <= 1; ++dx) {
                    const auto cell = _cells.find(Cell(point, dx, dy, dz));
                    if (cell == _cells.end()) {
                        continue;
                    }
                    for (const std::size_t i : cell->second) {
                        if (glm::length(_points[i] - point) <= distance) {
                            found.push_back(i);
                        }
                    }
                }
            }
        }
        return found;
    }

private:
    static constexpr double kCell = 1e-3;
    static std::array<long, 3> Cell(const glm::dvec3& p, int dx, int dy, int dz) {
        return {std::lround(p.x / kCell) + dx, std::lround(p.y / kCell) + dy,
                std::lround(p.z / kCell) + dz};
    }
    const std::vector<glm::dvec3>& _points;
    std::map<std::array<long, 3>, std::vector<std::size_t>> _cells;
};

glm::dvec3 PositionOf(const Diced& diced, std::size_t vertex) {
    return diced.source->Origin() + glm::dvec3(diced.chunk.positions[vertex]);
}

glm::dvec3 NormalOf(const ChunkGeometry& chunk, std::size_t triangle, int k) {
    const MeshAttribute& normals = chunk.normals;
    std::size_t element = normals.interpolation == Interpolation::FaceVarying
                              ? chunk.corners[triangle][k]
                              : chunk.points[chunk.triangles[triangle][k]];
    if (!normals.indices.empty()) {
        element = std::size_t(normals.indices[element]);
    }
    const float* n = normals.values.data() + 3 * element;
    return {n[0], n[1], n[2]};
}

/// Every vertex of the diced mesh is a vertex of the refined one, and the other way round.
void CheckAgainstLimit(const MeshDescription& mesh, int level) {
    const Diced diced = DiceUniform(mesh, std::uint32_t(level));
    ASSERT_TRUE(diced.source);
    const LimitLevel limit = RefineToLimit(mesh, level);
    std::set<int> used;
    for (const auto& face : limit.faces) {
        used.insert(face.begin(), face.end());
    }
    const PointFinder finder(limit.points);
    std::set<std::size_t> met;
    std::vector<std::size_t> pointOf(diced.chunk.positions.size());
    for (std::size_t i = 0; i < diced.chunk.positions.size(); ++i) {
        auto near = finder.Near(PositionOf(diced, i), 2e-6);
        if (near.empty()) { // only masks of darts are inexact
            near = finder.Near(PositionOf(diced, i), 2e-3);
            near.erase(std::remove_if(near.begin(), near.end(),
                                      [&](std::size_t point) { return !limit.isDart[point]; }),
                       near.end());
        }
        ASSERT_FALSE(near.empty()) << i;
        pointOf[i] = near.front();
        met.insert(near.begin(), near.end());
    }
    ASSERT_EQ(diced.chunk.positions.size(), used.size());
    for (const int point : used) {
        EXPECT_TRUE(met.count(std::size_t(point)) == 1);
    }
    const double side = mesh.leftHanded ? -1.0 : 1.0;
    for (std::size_t t = 0; t < diced.chunk.triangles.size(); ++t) {
        for (int k = 0; k < 3; ++k) {
            const std::size_t point = pointOf[diced.chunk.triangles[t][k]];
            if (mesh.subdivisionScheme != "bilinear" && !limit.isSharp[point] &&
                limit.normals[point] != glm::dvec3(0.0)) {
                ASSERT_LT(glm::length(NormalOf(diced.chunk, t, k) - side * limit.normals[point]),
                          2e-3);
            }
        }
    }
}

TEST(SubdivSource, VerticesAreOnTheLimitSurface) {
    std::mt19937 random(11);
    for (int round = 0; round < 24; ++round) {
        SCOPED_TRACE(round);
        MeshDescription mesh = MakeRandomCage(random, round % 3 == 2);
        if (round % 6 == 1) {
            mesh.subdivisionScheme = "bilinear";
        }
        mesh.leftHanded = round % 2 == 1;
        if (round >= 6) {
            AddRandomTags(mesh, random);
        }
        if (round >= 12) {
            mesh.holeIndices = std::vector<std::int32_t>{1, 4};
        }
        for (int level = 1; level <= 3; ++level) {
            CheckAgainstLimit(mesh, level);
        }
    }
}

TEST(SubdivSource, OpenCagesFollowEveryBoundaryRule) {
    std::mt19937 random(12);
    for (int round = 0; round < 18; ++round) {
        SCOPED_TRACE(round);
        MeshDescription mesh =
            MakeGrid(4, [&](float, float) { return float(random() % 100) / 300; });
        mesh.subdivisionScheme = "catmullClark";
        if (round >= 6) {
            AddRandomTags(mesh, random);
        }
        const char* const rules[] = {"none", "edgeOnly", "edgeAndCorner"};
        mesh.subdivTags.interpolateBoundary = rules[round % 3];
        CheckAgainstLimit(mesh, 2);
    }
}

} // namespace
} // namespace hds::test
