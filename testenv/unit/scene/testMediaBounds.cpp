// SPDX-License-Identifier: Apache-2.0
// Which meshes have an inside that a medium can fill, and where they are.
#include "hdStream/scene/mediaBounds.h"

#include <glm/gtc/matrix_transform.hpp>
#include <gtest/gtest.h>

#include <memory>

namespace hds {
namespace {

/// A tetrahedron, wound outwards.
GeometryDescription Tetrahedron() {
    GeometryDescription mesh;
    mesh.points = std::vector<float>{0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1};
    mesh.faceVertexCounts = std::vector<std::int32_t>{3, 3, 3, 3};
    mesh.faceVertexIndices = std::vector<std::int32_t>{0, 2, 1, 0, 1, 3, 1, 2, 3, 2, 0, 3};
    return mesh;
}

TEST(MediaBounds, AMeshIsClosedWhereEachEdgeHasTwoSides) {
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

TEST(MediaBounds, AFaceThatIsWoundTheOtherWayIsAHole) {
    GeometryDescription mesh = Tetrahedron();
    mesh.faceVertexIndices = std::vector<std::int32_t>{0, 1, 2, 0, 1, 3, 1, 2, 3, 2, 0, 3};
    EXPECT_FALSE(IsClosed(mesh));
}

TEST(MediaBounds, PointsInOnePlaceAreOne) {
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

TEST(MediaBounds, BadTopologyIsNotClosed) {
    GeometryDescription mesh = Tetrahedron();
    mesh.faceVertexIndices = std::vector<std::int32_t>{0, 2, 1, 0, 1, 9, 1, 2, 3, 2, 0, 3};
    EXPECT_FALSE(IsClosed(mesh));
    mesh.faceVertexIndices = std::vector<std::int32_t>{0, 2};
    EXPECT_FALSE(IsClosed(mesh));
    mesh.faceVertexCounts = std::vector<std::int32_t>{-3, 3};
    EXPECT_FALSE(IsClosed(mesh));
}

TEST(MediaBounds, TheBoxHoldsAllPlacementsOfWhatHasAMedium) {
    SceneDescription scene;
    std::vector<DrawnLeaf> leaves;
    for (const char* path : {"/fog", "/stone"}) {
        GeometryPrim prim;
        prim.geometry = std::make_shared<GeometryDescription>(Tetrahedron());
        prim.placement.worldFromObject =
            glm::translate(glm::dmat4(1.0), glm::dvec3(path[1] == 'f' ? 10.0 : 50.0, 0.0, 0.0));
        scene.geometry.emplace(path, prim);
    }
    for (const auto& entry : scene.geometry) {
        DrawnLeaf leaf;
        leaf.entry = &entry;
        leaf.object.flags = entry.first == "/fog" ? HDS_INSTANCE_MEDIUM : 0U;
        leaf.object.origin = glm::dvec3(0.0, 100.0, 0.0);
        leaf.object.bounds = {glm::vec3(-1.0F), glm::vec3(2.0F)};
        leaves.push_back(leaf);
    }
    const MediaBounds box = FindMediaBounds(scene, leaves, glm::dvec3(1.0, 0.0, 0.0));
    EXPECT_EQ(box.min, glm::dvec3(8.0, 99.0, -1.0));
    EXPECT_EQ(box.max, glm::dvec3(11.0, 102.0, 2.0));
}

} // namespace
} // namespace hds
