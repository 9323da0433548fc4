// SPDX-License-Identifier: Apache-2.0
// Where meshes are that a medium fills.
#include "hdStream/scene/mediaBounds.h"

#include "testenv/support/tetrahedron.h"

#include <glm/gtc/matrix_transform.hpp>
#include <gtest/gtest.h>

#include <memory>
#include <numeric>
#include <vector>

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
    const MediaBounds box = FindMediaBounds(scene, leaves, glm::dvec3(1.0, 0.0, 0.0), Shutter());
    EXPECT_EQ(box.min, glm::dvec3(8.0, 99.0, -1.0));
    EXPECT_EQ(box.max, glm::dvec3(11.0, 102.0, 2.0));
}

/// A body that is small at the frame and grows around the camera while the shutter is open.
TEST(MediaBounds, TheBoxHoldsThemWhileTheShutterIsOpen) {
    SceneDescription scene;
    GeometryPrim prim;
    prim.geometry = std::make_shared<GeometryDescription>(Tetrahedron());
    prim.placement.samples = {{0.0, glm::dmat4(1.0)},
                              {1.0, glm::scale(glm::dmat4(1.0), glm::dvec3(100.0))}};
    scene.geometry.emplace("/fog", prim);
    DrawnLeaf leaf;
    leaf.object.flags = HDS_INSTANCE_MEDIUM;
    leaf.object.bounds = {glm::vec3(-1.0F), glm::vec3(2.0F)};
    leaf.entry = &*scene.geometry.begin();
    const Shutter open{0.0, 1.0};
    MediaBounds box = FindMediaBounds(scene, {leaf}, glm::dvec3(0.0), open);
    EXPECT_EQ(box.min, glm::dvec3(-100.0));
    EXPECT_EQ(box.max, glm::dvec3(200.0));
    box = FindMediaBounds(scene, {leaf}, glm::dvec3(0.0), Shutter());
    EXPECT_EQ(box.max, glm::dvec3(2.0));
    // So many placements, of an instancer that another one places, that boxes go level by level.
    std::vector<std::int32_t> all(5000);
    std::iota(all.begin(), all.end(), 0);
    InstancerPrim instancer;
    instancer.instanceTransforms.scales = std::vector<float>(3 * all.size(), 1.0F);
    scene.instancers.emplace("/outer", instancer);
    instancer.placement.instancerPath = "/outer";
    instancer.placement.instances = all;
    instancer.placement.samples = {{0.0, glm::dmat4(1.0)},
                                   {1.0, glm::translate(glm::dmat4(1.0), glm::dvec3(0, 50, 0))}};
    scene.instancers.emplace("/inner", instancer);
    GeometryPrim placed = prim;
    placed.placement.instancerPath = "/inner";
    placed.placement.instances = all;
    scene.geometry["/fog"] = placed;
    leaf.entry = &*scene.geometry.begin();
    box = FindMediaBounds(scene, {leaf}, glm::dvec3(0.0), open);
    EXPECT_EQ(box.min, glm::dvec3(-100.0));
    EXPECT_EQ(box.max, glm::dvec3(200.0, 250.0, 200.0));
}

} // namespace
} // namespace hds
