// SPDX-License-Identifier: Apache-2.0
// Where meshes are that a medium fills.
#include "hdStream/scene/mediaBounds.h"

#include "testenv/support/tetrahedron.h"

#include <glm/gtc/matrix_transform.hpp>
#include <gtest/gtest.h>

#include <memory>

namespace hds {
namespace {

using test::Tetrahedron;

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
