// SPDX-License-Identifier: Apache-2.0
// Which meshes have an inside that a medium can fill.
#include "hdStream/scene/closedMeshes.h"

#include "testenv/support/tetrahedron.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <utility>
#include <vector>

namespace hds {
namespace {

using test::Tetrahedron;

TEST(ClosedMeshes, AMeshIsClosedWhereEachEdgeHasTwoSides) {
    EXPECT_TRUE(IsClosed(Tetrahedron()));
    GeometryDescription open = Tetrahedron();
    open.faceVertexCounts = std::vector<std::int32_t>{3, 3, 3};
    EXPECT_FALSE(IsClosed(open));
    GeometryDescription hole = Tetrahedron();
    hole.holeIndices = std::vector<std::int32_t>{2};
    EXPECT_FALSE(IsClosed(hole));
    hole.holeIndices = std::vector<std::int32_t>{-1, 17}; // no faces
    EXPECT_TRUE(IsClosed(hole));
}

TEST(ClosedMeshes, AFaceThatIsWoundTheOtherWayIsAHole) {
    GeometryDescription mesh = Tetrahedron();
    mesh.faceVertexIndices = std::vector<std::int32_t>{0, 1, 2, 0, 1, 3, 1, 2, 3, 2, 0, 3};
    EXPECT_FALSE(IsClosed(mesh));
}

TEST(ClosedMeshes, PointsInOnePlaceAreOne) {
    const GeometryDescription welded = Tetrahedron();
    GeometryDescription apart = welded;
    std::vector<float> points;
    std::vector<std::int32_t> indices;
    for (const std::int32_t point : welded.faceVertexIndices) {
        indices.push_back(static_cast<std::int32_t>(indices.size()));
        for (int i = 0; i < 3; ++i) {
            points.push_back(welded.points[3 * static_cast<std::size_t>(point) + i]);
        }
    }
    apart.points = points;
    apart.faceVertexIndices = indices;
    EXPECT_TRUE(IsClosed(apart));
    // As of a seam whose points are computed twice.
    for (std::size_t i = 0; i < points.size(); ++i) {
        points[i] += 1e-7F * static_cast<float>(i % 5);
    }
    apart.points = points;
    EXPECT_TRUE(IsClosed(apart));
    points[0] += 0.01F;
    apart.points = points;
    EXPECT_FALSE(IsClosed(apart));
}

TEST(ClosedMeshes, BadTopologyIsNotClosed) {
    GeometryDescription mesh = Tetrahedron();
    mesh.faceVertexIndices = std::vector<std::int32_t>{0, 2, 1, 0, 1, 9, 1, 2, 3, 2, 0, 3};
    EXPECT_FALSE(IsClosed(mesh));
    mesh.faceVertexIndices = std::vector<std::int32_t>{0, 2};
    EXPECT_FALSE(IsClosed(mesh));
    mesh.faceVertexCounts = std::vector<std::int32_t>{-3, 3};
    EXPECT_FALSE(IsClosed(mesh));
}

/// A sphere of quads with its first meridian twice: the second time each coordinate is off by at
/// most `jitter`. \param firstLeftOut of `numLeftOut` rows without their first quad
GeometryDescription SplitSphere(int numRows, double jitter, int firstLeftOut = 0,
                                int numLeftOut = 0) {
    constexpr int kColumns = 4;
    const double pi = std::acos(-1.0);
    std::vector<float> points;
    std::vector<std::int32_t> counts;
    std::vector<std::int32_t> indices;
    std::uint32_t random = 1;
    const auto nextRandom = [&random] { // -1 to 1
        random = 1664525U * random + 1013904223U;
        return 2.0 * (random >> 8U) / double(1U << 24U) - 1.0;
    };
    for (int row = 0; row <= numRows; ++row) {
        for (int column = 0; column <= kColumns; ++column) {
            const double theta = pi * row / numRows;
            const double phi = 2.0 * pi * (column % kColumns) / kColumns;
            const double by = column == kColumns ? jitter : 0.0;
            for (const double at : {std::sin(theta) * std::cos(phi), std::cos(theta),
                                    -std::sin(theta) * std::sin(phi)}) {
                points.push_back(static_cast<float>(at + by * nextRandom()));
            }
        }
    }
    for (int row = 0; row < numRows; ++row) {
        for (int column = 0; column < kColumns; ++column) {
            if (column == 0 && row >= firstLeftOut && row < firstLeftOut + numLeftOut) {
                continue;
            }
            const int first = row * (kColumns + 1) + column;
            counts.push_back(4);
            indices.insert(indices.end(),
                           {first, first + kColumns + 1, first + kColumns + 2, first + 1});
        }
    }
    GeometryDescription mesh;
    mesh.points = std::move(points);
    mesh.faceVertexCounts = std::move(counts);
    mesh.faceVertexIndices = std::move(indices);
    return mesh;
}

TEST(ClosedMeshes, ASeamIsNoHoleHoweverDenseItIs) {
    for (const int numRows : {8, 300, 10000, 40000}) {
        for (const double jitter : {0.0, 1e-7, 1e-6}) {
            EXPECT_TRUE(IsClosed(SplitSphere(numRows, jitter))) << numRows << ' ' << jitter;
        }
    }
    // Its points are a tenth of the sphere apart.
    EXPECT_FALSE(IsClosed(SplitSphere(300, 0.1)));
}

TEST(ClosedMeshes, AHoleIsOneHoweverDenseItsRimIs) {
    for (const int numRows : {300, 10000, 40000}) {
        for (const double jitter : {0.0, 1e-7}) {
            const int numLeftOut = numRows / 50;
            EXPECT_FALSE(IsClosed(SplitSphere(numRows, jitter, numRows / 2, numLeftOut)))
                << numRows << ' ' << jitter;
        }
    }
}

TEST(ClosedMeshes, PointsOfNoFaceHideNoHoles) {
    GeometryDescription mesh = Tetrahedron();
    std::vector<float> points(mesh.points.begin(), mesh.points.end());
    points.insert(points.end(), {1e6F, 0.0F, 0.0F});
    mesh.points = points;
    EXPECT_TRUE(IsClosed(mesh));
    mesh.faceVertexCounts = std::vector<std::int32_t>{3, 3, 3};
    EXPECT_FALSE(IsClosed(mesh));
    // Nor do faces that are left out count.
    mesh.faceVertexCounts = std::vector<std::int32_t>{3, 3, 3, 3, 3};
    mesh.faceVertexIndices = std::vector<std::int32_t>{0, 2, 1, 0, 1, 3, 1, 2, 3, 2, 0, 3, 0, 1, 4};
    mesh.holeIndices = std::vector<std::int32_t>{3, 4};
    EXPECT_FALSE(IsClosed(mesh));
}

TEST(ClosedMeshes, PlacesThatAreNoNumbersAreNoSeam) {
    GeometryDescription mesh = SplitSphere(8, 1e-7);
    std::vector<float> points(mesh.points.begin(), mesh.points.end());
    points[3 * 5 * 4] = std::nanf("");
    mesh.points = points;
    EXPECT_FALSE(IsClosed(mesh));
}

TEST(ClosedMeshes, EachGeometryIsLookedAtOnce) {
    ClosedMeshes meshes;
    auto open = Tetrahedron();
    open.faceVertexCounts = std::vector<std::int32_t>{3, 3, 3};
    const auto whole = std::make_shared<const GeometryDescription>(Tetrahedron());
    auto part = std::make_shared<const GeometryDescription>(open);
    EXPECT_EQ(meshes.Look(whole), nullptr) << "nobody asked";
    meshes.Ask(whole);
    meshes.Ask(part);
    EXPECT_NE(meshes.Look(whole), nullptr);
    EXPECT_EQ(meshes.Look(whole), nullptr);
    meshes.LookAtOthers();
    EXPECT_EQ(meshes.Look(part), nullptr);
    EXPECT_TRUE(meshes.IsClosed(whole));
    EXPECT_FALSE(meshes.IsClosed(part));
    // Another in the place of one that is gone is another.
    part = nullptr;
    part = std::make_shared<const GeometryDescription>(Tetrahedron());
    meshes.Ask(part);
    meshes.LookAtOthers();
    EXPECT_TRUE(meshes.IsClosed(part));
}

} // namespace
} // namespace hds
