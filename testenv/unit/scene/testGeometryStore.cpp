// SPDX-License-Identifier: Apache-2.0
// Geometry is planned again when, and only when, its description or the options are others.
#include "hdStream/scene/geometryStore.h"

#include <gtest/gtest.h>

namespace hds {
namespace {

std::shared_ptr<const GeometryDescription> Triangle(float size) {
    auto mesh = std::make_shared<GeometryDescription>();
    mesh->points = std::vector<float>{0, 0, 0, size, 0, 0, 0, size, 0};
    mesh->faceVertexCounts = std::vector<std::int32_t>{3};
    mesh->faceVertexIndices = std::vector<std::int32_t>{0, 1, 2};
    return mesh;
}

class GeometryStoreTest : public ::testing::Test {
protected:
    bool Prepare(const CancelCallback& isCancelled = {}) {
        std::vector<GeometryStore::Drawn> drawn;
        for (const auto& [path, prim] : scene.geometry) {
            if (prim.placement.visible) {
                inputs.geometry = prim.geometry;
                drawn.emplace_back(&path, std::make_shared<const GeometryInputs>(inputs));
            }
        }
        return store.Prepare(scene, drawn, warnings, isCancelled, &closed);
    }
    std::size_t Count() const {
        std::size_t count = 0;
        store.ForEach([&](const std::string&, const PlannedGeometry&) { ++count; });
        return count;
    }

    SceneDescription scene;
    GeometryInputs inputs; ///< but for the geometry
    Warnings warnings;
    GeometryStore store;
    ClosedMeshes closed;
};

TEST_F(GeometryStoreTest, EditsThatLeaveTheDescriptionPrepareNothing) {
    scene.geometry["/a"].geometry = Triangle(1.0F);
    scene.geometry["/b"].geometry = Triangle(2.0F);
    ASSERT_TRUE(Prepare());
    EXPECT_EQ(store.NumPrepared(), 2U);
    const ChunkPages* chunk = store.Find("/a").chunks[0].get();
    scene.geometry["/a"].placement.worldFromObject[3][0] = 5.0;
    scene.geometry["/a"].materialPath = "/m";
    scene.geometry["/a"].doubleSided = true;
    scene.geometry["/b"].placement.visible = false;
    ASSERT_TRUE(Prepare());
    EXPECT_EQ(store.NumPrepared(), 2U);
    EXPECT_EQ(Count(), 2U); // hidden, but kept
    EXPECT_EQ(store.Find("/a").chunks[0].get(), chunk);
    scene.geometry["/b"].placement.visible = true;
    ASSERT_TRUE(Prepare());
    EXPECT_EQ(store.NumPrepared(), 2U);
}

TEST_F(GeometryStoreTest, InputsThatServeAreSharedAndOthersAreCopied) {
    for (const char* path : {"/a", "/b", "/d"}) {
        scene.geometry[path].geometry = Triangle(1.0F);
    }
    inputs.primvars = {"st"};
    ASSERT_TRUE(Prepare());
    GeometryStore::InputsReader reader(store);
    GeometryInputs wanted; // reads less than what is prepared
    wanted.geometry = scene.geometry["/a"].geometry;
    const auto served = reader.Get("/a", wanted);
    EXPECT_EQ(served->primvars, inputs.primvars);
    wanted.geometry = scene.geometry["/b"].geometry;
    wanted.chunkBytes = 8192;
    const auto copied = reader.Get("/b", wanted);
    EXPECT_EQ(copied->chunkBytes, 8192U);
    EXPECT_EQ(copied->geometry, wanted.geometry);
    EXPECT_EQ(reader.Get("/c", wanted)->chunkBytes, 8192U); // there is none
    wanted.chunkBytes = inputs.chunkBytes;
    wanted.geometry = scene.geometry["/d"].geometry;
    EXPECT_EQ(reader.Get("/d", wanted)->primvars, inputs.primvars);
    EXPECT_TRUE(reader.Get("/e", wanted)->primvars.empty());
}

TEST_F(GeometryStoreTest, CountsItsBytesAsPrimsComeAndGo) {
    EXPECT_EQ(store.Bytes(), 0U);
    scene.geometry["/a"].geometry = Triangle(1.0F);
    ASSERT_TRUE(Prepare());
    const std::uint64_t ofOne = store.Bytes();
    EXPECT_GT(ofOne, 0U);
    scene.geometry["/b"].geometry = Triangle(2.0F);
    ASSERT_TRUE(Prepare());
    EXPECT_EQ(store.Bytes(), 2 * ofOne);
    inputs.chunkBytes = 8192; // all are planned anew
    ASSERT_TRUE(Prepare());
    EXPECT_EQ(store.Bytes(), 2 * ofOne);
    scene.geometry["/a"].geometry = Triangle(3.0F);
    ASSERT_TRUE(Prepare());
    EXPECT_EQ(store.Bytes(), 2 * ofOne);
    scene.geometry.erase("/b");
    ASSERT_TRUE(Prepare());
    EXPECT_EQ(store.Bytes(), ofOne);
    store.SetPageStore(nullptr);
    EXPECT_EQ(store.Bytes(), 0U);
}

TEST_F(GeometryStoreTest, NewDescriptionsAndOptionsPrepareAgain) {
    scene.geometry["/a"].geometry = Triangle(1.0F);
    scene.geometry["/b"].geometry = Triangle(2.0F);
    ASSERT_TRUE(Prepare());
    const std::uint64_t before = store.Find("/a").chunks[0]->Id(HDS_PAGE_GEOMETRY);
    scene.geometry["/a"].geometry = Triangle(3.0F);
    ASSERT_TRUE(Prepare());
    EXPECT_EQ(store.NumPrepared(), 3U);
    EXPECT_NE(store.Find("/a").chunks[0]->Id(HDS_PAGE_GEOMETRY), before);
    EXPECT_EQ(store.Find("/a").bounds.max.x - store.Find("/a").bounds.min.x, 3.0F);
    inputs.chunkBytes = 8192;
    ASSERT_TRUE(Prepare());
    EXPECT_EQ(store.NumPrepared(), 5U);
    inputs.dicing.Edit().emplace();
    ASSERT_TRUE(Prepare());
    EXPECT_EQ(store.NumPrepared(), 7U);
    inputs.displacements = {{0.1F, ""}};
    ASSERT_TRUE(Prepare());
    ASSERT_TRUE(Prepare());
    EXPECT_EQ(store.NumPrepared(), 9U);
}

TEST_F(GeometryStoreTest, OnlyPrimvarsThatAreReadAreInPages) {
    auto mesh = std::make_shared<GeometryDescription>(*Triangle(1.0F));
    for (const char* name : {"displayColor", "st"}) {
        Primvar primvar;
        primvar.name = name;
        primvar.numComponents = 2;
        primvar.values = std::vector<float>{1.0F, 2.0F};
        mesh->primvars.push_back(primvar);
    }
    scene.geometry["/a"].geometry = mesh;
    ASSERT_TRUE(Prepare());
    EXPECT_TRUE(store.Find("/a").attributes.empty());
    inputs.primvars = {"st"};
    ASSERT_TRUE(Prepare());
    ASSERT_EQ(store.Find("/a").attributes.size(), 1U);
    EXPECT_EQ(store.Find("/a").attributes[0].name, "st");
    inputs.primvars = {"displayColor", "st"};
    ASSERT_TRUE(Prepare());
    EXPECT_EQ(store.Find("/a").attributes.size(), 2U);
    EXPECT_EQ(store.NumPrepared(), 3U);
    // What is more than enough is kept.
    inputs.primvars = {};
    ASSERT_TRUE(Prepare());
    EXPECT_EQ(store.NumPrepared(), 3U);
}

TEST_F(GeometryStoreTest, WhoPlansLooksForHoles) {
    const auto shared = scene.geometry["/a"].geometry = scene.geometry["/b"].geometry =
        Triangle(1.0F);
    const auto notAsked = scene.geometry["/c"].geometry = Triangle(2.0F);
    closed.Ask(shared);
    ASSERT_TRUE(Prepare());
    EXPECT_EQ(closed.Look(shared), nullptr) << "not looked at by then";
    EXPECT_FALSE(closed.IsClosed(shared));
    closed.Ask(notAsked); // a material is edited: all is planned
    ASSERT_TRUE(Prepare());
    EXPECT_NE(closed.Look(notAsked), nullptr);
}

TEST_F(GeometryStoreTest, RemovedMeshesLeaveAndHiddenOnesAreNotPrepared) {
    scene.geometry["/a"].geometry = Triangle(1.0F);
    scene.geometry["/b"].geometry = Triangle(2.0F);
    scene.geometry["/b"].placement.visible = false;
    ASSERT_TRUE(Prepare());
    EXPECT_EQ(Count(), 1U);
    scene.geometry.erase("/a");
    ASSERT_TRUE(Prepare());
    EXPECT_EQ(Count(), 0U);
}

TEST_F(GeometryStoreTest, CancellingKeepsWhatIsPrepared) {
    for (int i = 0; i < 64; ++i) {
        scene.geometry["/" + std::to_string(i)].geometry = Triangle(1.0F + static_cast<float>(i));
    }
    int asked = 0;
    EXPECT_FALSE(Prepare([&] { return ++asked > 1; }));
    EXPECT_LT(store.NumPrepared(), 64U);
    const std::uint64_t before = store.NumPrepared();
    ASSERT_TRUE(Prepare());
    EXPECT_EQ(store.NumPrepared(), 64U);
    EXPECT_LE(before, 64U);
    EXPECT_EQ(Count(), 64U);
}

TEST_F(GeometryStoreTest, TrianglesComeBackFromTheDescription) {
    scene.geometry["/a"].geometry = Triangle(1.0F);
    ASSERT_TRUE(Prepare());
    const ChunkGeometry& triangles = store.Triangles("/a");
    ASSERT_EQ(triangles.triangles.size(), store.Find("/a").numTriangles);
    EXPECT_EQ(&store.Triangles("/a"), &triangles);
}

} // namespace
} // namespace hds
