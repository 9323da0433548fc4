// SPDX-License-Identifier: Apache-2.0
// The dump is a function of the scene's values alone: not of order, owners, or the sign of zero.
#include "hdStream/scene/dump.h"

#include <gtest/gtest.h>

#include <utility>

namespace hds {
namespace {

GeometryDescription Triangle(float z) {
    GeometryDescription mesh;
    mesh.points = std::vector<float>{0, 0, z, 1, 0, z, 0, 1, z};
    mesh.faceVertexCounts = std::vector<std::int32_t>{3};
    mesh.faceVertexIndices = std::vector<std::int32_t>{0, 1, 2};
    return mesh;
}

void SetGeometry(SceneDescription* scene, const std::string& path, GeometryDescription mesh) {
    scene->geometry[path].geometry = std::make_shared<const GeometryDescription>(std::move(mesh));
}

TEST(Dump, EqualValuesGiveEqualText) {
    SceneDescription a;
    SetGeometry(&a, "/A", Triangle(0.0F));
    SetGeometry(&a, "/B", Triangle(1.0F));
    SceneDescription b;
    SetGeometry(&b, "/B", Triangle(1.0F));
    SetGeometry(&b, "/A", Triangle(-0.0F));
    EXPECT_EQ(DumpScene(a), DumpScene(b));
    const Primvar x{"x", Interpolation::Constant, 1, std::vector<float>{1.0F}, {}};
    const Primvar y{"y", Interpolation::Constant, 1, std::vector<float>{2.0F}, {}};
    GeometryDescription forward = Triangle(0.0F);
    forward.primvars = {x, y};
    GeometryDescription backward = Triangle(0.0F);
    backward.primvars = {y, x};
    SetGeometry(&a, "/A", forward);
    SetGeometry(&b, "/A", backward);
    EXPECT_EQ(DumpScene(a), DumpScene(b));
}

TEST(Dump, WhatNobodySeesIsLeftOut) {
    SceneDescription base;
    SetGeometry(&base, "/A", Triangle(0.0F));
    const std::string text = DumpScene(base);
    base.geometry["/A"].materialPath = "/m";
    EXPECT_EQ(DumpScene(base), text);
    base.materials["/m"] = std::make_shared<const MaterialNetwork>(); // no surface
    EXPECT_EQ(DumpScene(base), text);
    SetGeometry(&base, "/B", Triangle(0.0F));
    base.geometry["/B"].placement.visible = false;
    EXPECT_EQ(DumpScene(base), text);
    base.geometry["/B"].placement.visible = true;
    EXPECT_NE(DumpScene(base), text);
}

TEST(Dump, EveryDifferenceShows) {
    SceneDescription base;
    SetGeometry(&base, "/A", Triangle(0.0F));
    base.geometry["/A"].placement.instancerPath = "/I";
    MaterialNetwork material;
    material.terminals["surface"];
    base.materials["/m"] = std::make_shared<const MaterialNetwork>(material);
    base.lights["/L"];
    base.cameras["/C"];
    const std::string text = DumpScene(base);
    const auto changed = [&](auto edit) {
        SceneDescription scene = base;
        edit(&scene);
        return DumpScene(scene) != text;
    };
    const auto meshChanged = [&](auto edit) {
        return changed([&](SceneDescription* s) { edit(&s->geometry["/A"]); });
    };
    EXPECT_TRUE(changed([](SceneDescription* s) { SetGeometry(s, "/A", Triangle(1e-30F)); }));
    EXPECT_TRUE(changed([](SceneDescription* s) {
        GeometryDescription mesh = Triangle(0.0F);
        mesh.leftHanded = true;
        SetGeometry(s, "/A", mesh);
    }));
    EXPECT_TRUE(meshChanged([](GeometryPrim* p) { p->placement.visible = false; }));
    EXPECT_TRUE(meshChanged([](GeometryPrim* p) { p->placement.instances = std::vector<int>{2}; }));
    EXPECT_TRUE(meshChanged([](GeometryPrim* p) { p->materialPath = "/m"; }));
    EXPECT_TRUE(meshChanged([](GeometryPrim* p) { p->doubleSided = true; }));
    EXPECT_TRUE(meshChanged([](GeometryPrim* p) { p->cullStyle = CullStyle::Back; }));
    EXPECT_TRUE(changed([](SceneDescription* s) { s->lights["/L"].light.intensity = 2.0F; }));
    EXPECT_TRUE(changed([](SceneDescription* s) { s->cameras["/C"].fStop = 2.0F; }));
    EXPECT_TRUE(changed([](SceneDescription* s) {
        s->cameras["/C"].clippingPlanes = {glm::dvec4(0.0, 0.0, -1.0, 1.0)};
    }));
    // Long arrays are hashed: one bit in the middle shows.
    std::vector<float> points(3000, 1.0F);
    GeometryDescription longMesh = Triangle(0.0F);
    longMesh.points = points;
    SetGeometry(&base, "/A", longMesh);
    const std::string longText = DumpScene(base);
    points[1500] = 1.0000001F;
    longMesh.points = points;
    SetGeometry(&base, "/A", longMesh);
    EXPECT_NE(DumpScene(base), longText);
}

} // namespace
} // namespace hds
