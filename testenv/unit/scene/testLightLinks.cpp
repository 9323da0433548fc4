// SPDX-License-Identifier: Apache-2.0
// Link sets: one number a combination of categories that lights name, bits for each category, and
// records of their own for instances that are linked differently.
#include "hdStream/scene/lightLinks.h"

#include "hdStream/scene/hierarchy.h"
#include "testenv/support/drawnLeaves.h"

#include <glm/gtc/matrix_transform.hpp>
#include <glm/gtc/type_ptr.hpp>
#include <gtest/gtest.h>

namespace hds {
namespace {

SceneDescription TwoLights() {
    SceneDescription scene;
    scene.lights["/A"].links.lightLink = "lit";
    scene.lights["/B"].links.shadowLink = "shadowing";
    return scene;
}

std::uint32_t SetOf(std::uint32_t flags) {
    return flags >> HDS_INSTANCE_LINK_SHIFT;
}

TEST(LightLinks, WithoutLinksNothingIsMarked) {
    SceneDescription scene;
    scene.lights["/A"];
    LightLinks links(scene);
    EXPECT_FALSE(links.AreUsed());
    EXPECT_EQ(links.FlagsOf({"lit"}), 0U);
    EXPECT_EQ(links.IndexOf(""), HDS_NONE);
    EXPECT_TRUE(links.Table().categories.empty());
}

TEST(LightLinks, SetsAreNumberedByTheCategoriesThatCount) {
    const SceneDescription scene = TwoLights();
    LightLinks links(scene);
    const std::uint32_t none = links.FlagsOf({});
    const std::uint32_t lit = links.FlagsOf({"lit", "of no light"});
    const std::uint32_t both = links.FlagsOf({"lit"}, {"shadowing"});
    EXPECT_EQ(SetOf(none), 0U);
    EXPECT_NE(SetOf(lit), SetOf(none));
    EXPECT_NE(SetOf(both), SetOf(lit));
    EXPECT_EQ(links.FlagsOf({"shadowing", "lit"}), both);
    // What casts no shadow of some light may be passed by shadow rays.
    EXPECT_NE(none & HDS_INSTANCE_CUTOUT, 0U);
    EXPECT_NE(lit & HDS_INSTANCE_CUTOUT, 0U);
    EXPECT_EQ(both & HDS_INSTANCE_CUTOUT, 0U);
    EXPECT_TRUE(links.HaveUnshadowing());
    const LinkTable table = links.Table();
    ASSERT_EQ(table.numSets, 3U);
    const std::vector<bool>& isLit = table.categories[links.IndexOf("lit")];
    const std::vector<bool>& isShadowing = table.categories[links.IndexOf("shadowing")];
    EXPECT_FALSE(isLit[SetOf(none)]);
    EXPECT_TRUE(isLit[SetOf(lit)] && isLit[SetOf(both)]);
    EXPECT_TRUE(isShadowing[SetOf(both)]);
    EXPECT_FALSE(isShadowing[SetOf(none)] || isShadowing[SetOf(lit)]);
}

TEST(LightLinks, VolumesHaveSetsAndCastAllShadows) {
    const SceneDescription scene = TwoLights();
    LightLinks links(scene);
    EXPECT_EQ(links.SetOf({}), 0U);
    const std::uint32_t lit = links.SetOf({"of no light"}, {"lit"});
    EXPECT_NE(lit, 0U);
    EXPECT_FALSE(links.HaveUnshadowing());
    EXPECT_EQ(SetOf(links.FlagsOf({"lit"})), lit);
    EXPECT_TRUE(links.Table().categories[links.IndexOf("lit")][lit]);
    EXPECT_EQ(LightLinks(SceneDescription()).SetOf({"lit"}), 0U);
}

TEST(LightLinks, MeshLightsAreLights) {
    SceneDescription scene;
    MeshLight light;
    light.links = {"lit", "shadowing"};
    scene.geometry["/A"].light = std::make_shared<const MeshLight>(light);
    LightLinks links(scene);
    ASSERT_TRUE(links.AreUsed());
    const std::uint32_t both = links.FlagsOf({"lit", "shadowing"});
    EXPECT_EQ(both & HDS_INSTANCE_CUTOUT, 0U);
    EXPECT_NE(links.FlagsOf({"lit"}) & HDS_INSTANCE_CUTOUT, 0U);
    EXPECT_TRUE(links.Table().categories[links.IndexOf("lit")][SetOf(both)]);
}

TEST(LightLinks, ShadowsThatFadeLetAllGeometryBePassed) {
    SceneDescription scene;
    scene.lights["/A"].light.shadow.falloff = 1.0F;
    EXPECT_EQ(LightLinks(scene).FlagsOf({}), 0U); // no distance at which the shadow ends
    scene.lights["/A"].light.shadow.distance = 2.0F;
    LightLinks links(scene);
    EXPECT_EQ(links.FlagsOf({}), HDS_INSTANCE_CUTOUT);
    EXPECT_TRUE(links.HaveUnshadowing());
    scene.lights["/B"].links.shadowLink = "shadowing";
    EXPECT_NE(LightLinks(scene).FlagsOf({"shadowing"}) & HDS_INSTANCE_CUTOUT, 0U);
    scene.lights["/A"].light.shadow.enable = false;
    EXPECT_EQ(LightLinks(scene).FlagsOf({"shadowing"}) & HDS_INSTANCE_CUTOUT, 0U);
}

TEST(LightLinks, MoreSetsThanNumbersAreOneWarning) {
    SceneDescription scene;
    for (int i = 0; i < 17; ++i) {
        scene.lights["/" + std::to_string(i)].links.lightLink = std::to_string(i);
    }
    LightLinks links(scene);
    std::uint32_t last = 1;
    for (unsigned bits = 0; bits < (1U << 17U); ++bits) {
        std::set<std::string> categories;
        for (unsigned i = 0; i < 17; ++i) {
            if ((bits >> i & 1U) != 0) {
                categories.insert(std::to_string(i));
            }
        }
        last = links.FlagsOf(categories);
    }
    EXPECT_EQ(last, 0U);
    Warnings warnings;
    links.WarnOfOverflow(warnings);
    EXPECT_EQ(warnings.Lines().size(), 1U);
}

TEST(LightLinks, InstancesInOtherCategoriesGetRecordsOfTheirOwn) {
    SceneDescription scene = TwoLights();
    InstancerPrim& instancer = scene.instancers["/I"];
    std::vector<double> transforms;
    for (int i = 0; i < 3; ++i) {
        const glm::dmat4 matrix = glm::translate(glm::dmat4(1.0), {10.0 * i, 0.0, 0.0});
        transforms.insert(transforms.end(), glm::value_ptr(matrix), glm::value_ptr(matrix) + 16);
    }
    instancer.instanceTransforms = std::move(transforms);
    instancer.instanceCategories = {{"lit", "shadowing"}, {"shadowing"}, {"lit", "shadowing"}};
    GeometryPrim& mesh = scene.geometry["/M"];
    mesh.placement.instancerPath = "/I";
    mesh.placement.instances = std::vector<std::int32_t>{0, 1, 2};
    LightLinks links(scene);
    LeafObject leaf;
    leaf.object = 1;
    leaf.bounds.min = glm::vec3(-1.0F);
    leaf.bounds.max = glm::vec3(1.0F);
    leaf.isLinkedByInstance = links.IsLinkedByInstance(mesh.placement);
    EXPECT_TRUE(leaf.isLinkedByInstance);
    Warnings warnings;
    const Hierarchy tables = BuildHierarchy(scene, test::DrawnLeaves(scene, {{"/M", leaf}}),
                                            glm::dvec3(0.0), 2, &links, Shutter(), warnings);
    ASSERT_EQ(tables.instances.size(), 3U);
    const LinkTable table = links.Table();
    for (const shared::HdsInstance& instance : tables.instances) {
        const bool isLit = table.categories[links.IndexOf("lit")][SetOf(instance.flags)];
        EXPECT_EQ(isLit, instance.objectFromParent[3] != -10.0F); // all but the one at x = 10
        EXPECT_EQ(instance.flags & HDS_INSTANCE_CUTOUT, 0U);
    }
    instancer.instanceCategories.clear();
    EXPECT_FALSE(links.IsLinkedByInstance(mesh.placement));
}

} // namespace
} // namespace hds
