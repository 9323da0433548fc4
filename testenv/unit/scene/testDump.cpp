// SPDX-License-Identifier: Apache-2.0
// The dump is a function of the scene's values alone: not of order, owners, or the sign of zero.
#include "hdStream/scene/dump.h"

#include <gtest/gtest.h>

namespace hds {
namespace {

MeshPrim Triangle(float z) {
    MeshPrim prim;
    prim.mesh.points = std::vector<float>{0, 0, z, 1, 0, z, 0, 1, z};
    prim.mesh.faceVertexCounts = std::vector<std::int32_t>{3};
    prim.mesh.faceVertexIndices = std::vector<std::int32_t>{0, 1, 2};
    return prim;
}

TEST(Dump, EqualValuesGiveEqualText) {
    SceneDescription a;
    a.meshes["/A"] = Triangle(0.0F);
    a.meshes["/B"] = Triangle(1.0F);
    SceneDescription b;
    b.meshes["/B"] = Triangle(1.0F);
    b.meshes["/A"] = Triangle(-0.0F);
    EXPECT_EQ(DumpScene(a), DumpScene(b));
    Primvar x{"x", Interpolation::Constant, 1, std::vector<float>{1.0F}, {}};
    Primvar y{"y", Interpolation::Constant, 1, std::vector<float>{2.0F}, {}};
    a.meshes["/A"].mesh.primvars = {x, y};
    b.meshes["/A"].mesh.primvars = {y, x};
    EXPECT_EQ(DumpScene(a), DumpScene(b));
}

TEST(Dump, EveryDifferenceShows) {
    SceneDescription base;
    base.meshes["/A"] = Triangle(0.0F);
    base.lights["/L"];
    base.cameras["/C"];
    const std::string text = DumpScene(base);
    const auto changed = [&](auto edit) {
        SceneDescription scene = base;
        edit(&scene);
        return DumpScene(scene) != text;
    };
    EXPECT_TRUE(changed([](SceneDescription* s) { s->meshes["/A"] = Triangle(1e-30F); }));
    EXPECT_TRUE(changed([](SceneDescription* s) { s->meshes["/A"].mesh.leftHanded = true; }));
    EXPECT_TRUE(changed([](SceneDescription* s) { s->meshes["/A"].placement.visible = false; }));
    EXPECT_TRUE(changed([](SceneDescription* s) { s->meshes["/A"].materialPath = "/m"; }));
    EXPECT_TRUE(changed([](SceneDescription* s) { s->lights["/L"].light.intensity = 2.0F; }));
    EXPECT_TRUE(changed([](SceneDescription* s) { s->cameras["/C"].fStop = 2.0; }));
    EXPECT_TRUE(changed([](SceneDescription* s) { s->upAxis = "Z"; }));
    // Long arrays are hashed: one bit in the middle shows.
    std::vector<float> points(3000, 1.0F);
    base.meshes["/A"].mesh.points = points;
    const std::string longText = DumpScene(base);
    points[1500] = 1.0000001F;
    base.meshes["/A"].mesh.points = points;
    EXPECT_NE(DumpScene(base), longText);
}

} // namespace
} // namespace hds
