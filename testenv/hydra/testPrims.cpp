// SPDX-License-Identifier: Apache-2.0
// The life of prims: added, removed, added again; primvars that vanish; computed primvars.
#include "hydraTest.h"

#include <pxr/base/gf/quatf.h>
#include <pxr/base/gf/quath.h>
#include <pxr/imaging/hd/changeTracker.h>
#include <pxr/imaging/hd/extComputation.h>

namespace hydraHost {

namespace {

using Prims = HydraTest;

const SdfPath kCube("/cube");
const SdfPath kNgons("/ngons");

TEST_F(Prims, AddedLaterEqualsThereFromTheStart) {
    const HostOptions options = Quick();
    const SceneData all = ThreeMeshes();
    SceneData some = all;
    some.gprims.erase(kCube);
    some.materials.erase(SdfPath("/materials/green"));
    Host host(some, options);
    ASSERT_TRUE(host.RenderUntilConverged());
    // The binding comes before its material.
    host.Scene().SetGprim(kCube, all.gprims.at(kCube));
    host.Frame();
    host.Scene().SetMaterial(SdfPath("/materials/green"),
                             all.materials.at(SdfPath("/materials/green")));
    EXPECT_EQ(host.Render(), RenderFresh(host, options));
}

TEST_F(Prims, AddedAgainUnderTheSamePathIsTheNewPrim) {
    const HostOptions options = Quick();
    Host host(ThreeMeshes(), options);
    const Image before = host.Render();
    host.Scene().Remove(kCube);
    GprimData other = MakeGrid(0.6F, 0.6F);
    other.transform = Translation(1.0, 0.5, 0.0);
    host.Scene().SetGprim(kCube, other);
    const Image after = host.Render();
    EXPECT_NE(after, before);
    EXPECT_EQ(after, RenderFresh(host, options));
}

TEST_F(Prims, RemovedAndAddedAgainHasTheFirstBits) {
    Host host(ThreeMeshes(), Quick());
    const Image before = host.Render();
    const GprimData cube = host.Scene().Data().gprims.at(kCube);
    host.Scene().Remove(kCube);
    EXPECT_NE(host.Render(), before);
    host.Scene().SetGprim(kCube, cube);
    EXPECT_EQ(host.Render(), before);
}

// At a time of the shutter a prim is as at so many times that: the picture of another shutter.
TEST_F(Prims, BlurScaleIsAnotherShutter) {
    SceneData scene = EmptyScene();
    GprimData cube = MakeCube(0.3F);
    cube.transformSamples = {{-0.5F, Translation(-1.0, 0.2, 0.0)},
                             {0.5F, Translation(1.0, 0.0, 0.0)}};
    cube.transform = Translation(0.0, 0.1, 0.0);
    scene.gprims[kCube] = cube;
    const HostOptions options = Quick({HdAovTokens->color}, 8);
    Host host(scene, options);
    SetShutter(host, -0.25, 0.25);
    const Image half = host.Render();
    SetShutter(host, -0.5, 0.5);
    const Image whole = host.Render();
    EXPECT_NE(half, whole);
    for (const auto& [scale, expected] : {std::pair(0.5F, &half), std::pair(1.0F, &whole),
                                          std::pair(-1.0F, &whole), std::pair(0.5F, &half)}) {
        cube.SetPrimvar("blurScale", HdInterpolationConstant, VtValue(scale));
        host.Scene().SetGprim(kCube, cube, HdChangeTracker::DirtyPrimvar);
        EXPECT_EQ(host.Render(), *expected) << scale;
    }
    cube.SetPrimvar("blurScale", HdInterpolationConstant, VtValue(0.0F));
    host.Scene().SetGprim(kCube, cube, HdChangeTracker::DirtyPrimvar);
    const Image still = host.Render();
    EXPECT_NE(still, half);
    EXPECT_EQ(still, RenderFresh(host, options));
}

TEST_F(Prims, RemovedMaterialLeavesItsPrimsDrawn) {
    const HostOptions options = Quick();
    Host host(ThreeMeshes(), options);
    const Image before = host.Render();
    host.Scene().Remove(SdfPath("/materials/green"));
    const Image after = host.Render();
    EXPECT_NE(after, before);
    EXPECT_EQ(after, RenderFresh(host, options));
}

/// A grid of two faces, of the materials of these names.
SceneData TwoSubsets(const char* left, const char* right) {
    const SdfPath materials("/materials");
    SceneData scene = EmptyScene();
    scene.materials[materials.AppendChild(TfToken("subsetMaterialXNeg"))] =
        MakeMaterial(GfVec3f(0.8F, 0.1F, 0.1F));
    GprimData grid = MakeGrid(1.2F, 1.0F, 2, 1);
    HdGeomSubsets subsets;
    for (const char* name : {left, right}) {
        const SdfPath path("/grid/face" + std::to_string(subsets.size()));
        const SdfPath material = *name ? materials.AppendChild(TfToken(name)) : SdfPath();
        subsets.push_back(
            {HdGeomSubset::TypeFaceSet, path, material, VtIntArray{int(subsets.size())}});
    }
    grid.mesh.SetGeomSubsets(subsets);
    scene.gprims[SdfPath("/grid")] = grid;
    return scene;
}

TEST_F(Prims, CardsWithoutTextureHaveNoMaterialAndNoWarning) {
    Host host(TwoSubsets("subsetMaterialXPos", "subsetMaterialXNeg"), Quick());
    const Image image = host.Render();
    EXPECT_EQ(NumWarnings(host, ""), 0);
    EXPECT_EQ(image, Host(TwoSubsets("", "subsetMaterialXNeg"), Quick()).Render());
    EXPECT_NE(image, Host(TwoSubsets("", ""), Quick()).Render());
}

TEST_F(Prims, OtherMissingMaterialsAreAWarning) {
    for (const char* name : {"subsetMaterialWPos", "subsetMaterialXPositive", "red"}) {
        Host host(TwoSubsets(name, "subsetMaterialXNeg"), Quick());
        host.Render();
        EXPECT_EQ(NumWarnings(host, std::string("/materials/") + name + " does not exist"), 1);
    }
}

TEST_F(Prims, RemovedPrimvarVanishes) {
    const TfToken aov("primvars:displayColor");
    const HostOptions options = Quick({HdAovTokens->color, aov});
    SceneData scene = EmptyScene();
    const GprimData plain = MakeGrid(1.2F, 1.0F);
    GprimData painted = plain;
    painted.SetPrimvar("displayColor", HdInterpolationConstant,
                       VtValue(VtVec3fArray{GfVec3f(1.0F, 0.0F, 0.0F)}),
                       HdPrimvarRoleTokens->color);
    scene.gprims[SdfPath("/grid")] = painted;
    Host host(scene, options);
    const Image before = host.Render(aov);
    ASSERT_EQ(before.width, 64);
    EXPECT_EQ(before.Float(32, 24), 1.0F);
    host.Scene().SetGprim(SdfPath("/grid"), plain, HdChangeTracker::DirtyPrimvar);
    const Image after = host.Render(aov);
    EXPECT_EQ(after, RenderFresh(host, options, aov));
    EXPECT_NE(after.Float(32, 24), 1.0F);
}

TEST_F(Prims, InvisibleFacesAreHoles) {
    const auto render = [](const VtIntArray& holes, const VtIntArray& invisible) {
        SceneData scene = EmptyScene();
        GprimData grid = MakeGrid(1.2F, 1.0F, 2, 2);
        grid.mesh.SetHoleIndices(holes);
        grid.mesh.SetInvisibleFaces(invisible);
        scene.gprims[SdfPath("/grid")] = grid;
        return Host(scene, Quick()).Render();
    };
    const Image expected = render({0, 3}, {});
    EXPECT_EQ(render({}, {3, 0}), expected);
    EXPECT_EQ(render({0}, {3, 0}), expected);
    EXPECT_NE(render({0}, {}), expected);
}

TEST_F(Prims, RemovedNormalsVanish) {
    const HostOptions options = Quick({HdAovTokens->color, HdAovTokens->normal});
    SceneData scene = EmptyScene();
    const GprimData plain = MakeGrid(1.2F, 1.0F);
    GprimData bent = plain;
    const GfVec3f normal = GfVec3f(0.6F, 0.0F, 0.8F);
    bent.SetPrimvar("normals", HdInterpolationVertex, VtValue(VtVec3fArray(4, normal)),
                    HdPrimvarRoleTokens->normal);
    scene.gprims[SdfPath("/grid")] = bent;
    Host host(scene, options);
    EXPECT_NEAR(host.Render(HdAovTokens->normal).Float(32, 24, 0), 0.6F, 1e-5F);
    host.Scene().SetGprim(SdfPath("/grid"), plain, HdChangeTracker::DirtyNormals);
    EXPECT_NEAR(host.Render(HdAovTokens->normal).Float(32, 24, 0), 0.0F, 1e-6F);
}

TEST_F(Prims, InterpolationMayChange) {
    const TfToken aov("primvars:displayColor");
    const HostOptions options = Quick({HdAovTokens->color, aov});
    SceneData scene = EmptyScene();
    GprimData grid = MakeGrid(1.2F, 1.0F, 2, 1);
    grid.SetPrimvar("displayColor", HdInterpolationConstant,
                    VtValue(VtVec3fArray(1, GfVec3f(0.5F))), HdPrimvarRoleTokens->color);
    scene.gprims[SdfPath("/grid")] = grid;
    Host host(scene, options);
    ASSERT_TRUE(host.RenderUntilConverged());
    grid.SetPrimvar("displayColor", HdInterpolationUniform,
                    VtValue(VtVec3fArray{GfVec3f(0.25F), GfVec3f(0.75F)}),
                    HdPrimvarRoleTokens->color);
    host.Scene().SetGprim(SdfPath("/grid"), grid, HdChangeTracker::DirtyPrimvar);
    const Image image = host.Render(aov);
    EXPECT_EQ(image.Float(24, 24), 0.25F);
    EXPECT_EQ(image.Float(40, 24), 0.75F);
    // Too short an array is a warning, never a crash.
    grid.SetPrimvar("displayColor", HdInterpolationVertex, VtValue(VtVec3fArray(2, GfVec3f(0.5F))),
                    HdPrimvarRoleTokens->color);
    host.Scene().SetGprim(SdfPath("/grid"), grid, HdChangeTracker::DirtyPrimvar);
    EXPECT_TRUE(host.RenderUntilConverged());
}

TEST_F(Prims, ComputedPointsEqualAuthoredOnes) {
    const HostOptions options = Quick();
    const SdfPath computation("/computation");
    const TfToken rest("rest");
    const TfToken output("skinned");
    const GprimData authored = ThreeMeshes().gprims.at(kNgons);
    const auto points =
        const_cast<GprimData&>(authored).FindPrimvar(HdTokens->points)->value.Get<VtVec3fArray>();

    SceneData scene = ThreeMeshes();
    ComputationData data;
    data.inputs[rest] = VtValue(points);
    data.inputs[TfToken("shift")] = VtValue(GfVec3f(0.0F));
    data.output = output;
    data.numElements = points.size();
    data.run = [rest](const std::map<TfToken, VtValue>& inputs) {
        VtVec3fArray moved = inputs.at(rest).Get<VtVec3fArray>();
        for (GfVec3f& point : moved) {
            point += inputs.at(TfToken("shift")).Get<GfVec3f>();
        }
        return VtValue(moved);
    };
    scene.computations[computation] = data;
    GprimData computed = authored;
    computed.primvars.clear();
    computed.computedPrimvars = {HdExtComputationPrimvarDescriptor(
        HdTokens->points, HdInterpolationVertex, HdPrimvarRoleTokens->point, computation, output,
        HdTupleType{HdTypeFloatVec3, 1})};
    scene.gprims[kNgons] = computed;
    Host host(scene, options);
    Host plain(ThreeMeshes(), options);
    const Image first = host.Render();
    EXPECT_EQ(first, plain.Render());

    data.inputs[TfToken("shift")] = VtValue(GfVec3f(0.3F, 0.2F, 0.1F));
    host.Scene().SetComputation(computation, data, HdExtComputation::DirtySceneInput);
    host.Scene().SetGprim(kNgons, computed, HdChangeTracker::DirtyPoints);
    const Image moved = host.Render();
    EXPECT_NE(moved, first);
    EXPECT_EQ(moved, RenderFresh(host, options));
}

/// Some delegates list normals of meshes whose points are computed: each edit carries those at
/// rest.
TEST_F(Prims, NormalsAtRestAreCarriedWhereOnlyPointsChange) {
    const HostOptions options = Quick({TfToken("normal")});
    const SdfPath computation("/computation");
    const TfToken output("skinned");
    const auto turned = [](const VtVec3fArray& rest, float degrees) {
        ComputationData data;
        data.inputs[TfToken("rest")] = VtValue(rest);
        data.inputs[TfToken("degrees")] = VtValue(degrees);
        data.numElements = rest.size();
        data.output = TfToken("skinned");
        data.run = [](const std::map<TfToken, VtValue>& inputs) {
            const GfRotation turn(GfVec3d(0, 1, 0), inputs.at(TfToken("degrees")).Get<float>());
            VtVec3fArray moved = inputs.at(TfToken("rest")).Get<VtVec3fArray>();
            for (GfVec3f& point : moved) {
                point = GfVec3f(turn.TransformDir(GfVec3d(point)));
            }
            return VtValue(moved);
        };
        return data;
    };
    SceneData scene = EmptyScene();
    GprimData grid = MakeGrid(1.0F, 1.0F, 2, 2);
    const auto rest = grid.FindPrimvar(HdTokens->points)->value.Get<VtVec3fArray>();
    grid.SetPrimvar("normals", HdInterpolationVertex,
                    VtValue(VtVec3fArray(rest.size(), GfVec3f(0.0F, 0.6F, 0.8F))),
                    HdPrimvarRoleTokens->normal);
    grid.computedPrimvars = {HdExtComputationPrimvarDescriptor(
        HdTokens->points, HdInterpolationVertex, HdPrimvarRoleTokens->point, computation, output,
        HdTupleType{HdTypeFloatVec3, 1})};
    scene.gprims[SdfPath("/grid")] = grid;
    scene.computations[computation] = turned(rest, 10.0F);
    Host host(scene, options);
    const Image first = host.Render(TfToken("normal"));
    host.Scene().SetComputation(computation, turned(rest, 40.0F),
                                HdExtComputation::DirtySceneInput);
    host.Scene().SetGprim(SdfPath("/grid"), grid, HdChangeTracker::DirtyPoints);
    const Image moved = host.Render(TfToken("normal"));
    EXPECT_NE(moved, first);
    EXPECT_EQ(moved, RenderFresh(host, options, TfToken("normal")));
}

TEST_F(Prims, OrderOfInsertionDoesNotMatter) {
    const SceneData scene = ThreeMeshes();
    Host forward(scene, Quick());
    SceneData noGprims = scene;
    noGprims.gprims.clear();
    Host backward(noGprims, Quick());
    for (auto gprim = scene.gprims.rbegin(); gprim != scene.gprims.rend(); ++gprim) {
        backward.Scene().SetGprim(gprim->first, gprim->second);
        backward.Frame();
    }
    EXPECT_EQ(backward.Render(), forward.Render());
}

TEST_F(Prims, CurvesPointsAndBadMeshesAreAcceptedBesideMeshes) {
    SceneData scene = ThreeMeshes();
    GprimData curves;
    curves.type = HdPrimTypeTokens->basisCurves;
    curves.curves = HdBasisCurvesTopology(HdTokens->linear, TfToken(), HdTokens->nonperiodic,
                                          VtIntArray{3}, VtIntArray());
    curves.SetPrimvar(
        "points", HdInterpolationVertex,
        VtValue(VtVec3fArray{GfVec3f(-1, 1.2F, 0), GfVec3f(0, 1.3F, 0), GfVec3f(1, 1.2F, 0)}));
    scene.gprims[SdfPath("/curves")] = curves;
    GprimData dots = curves;
    dots.type = HdPrimTypeTokens->points;
    dots.SetPrimvar("points", HdInterpolationVertex, // outside of the balls that curves are made of
                    VtValue(VtVec3fArray{GfVec3f(-1, -1.2F, 0), GfVec3f(1, -1.2F, 0)}));
    scene.gprims[SdfPath("/dots")] = dots;
    scene.gprims[SdfPath("/empty")] = MakeMesh({}, {}, {});
    scene.gprims[SdfPath("/outOfRange")] = MakeMesh({{0, 0, 0}, {1, 0, 0}}, {3}, {0, 1, 7});
    scene.gprims[SdfPath("/counts")] = MakeMesh({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}, {4}, {0, 1, 2});
    Host host(scene, Quick());
    const Image all = host.Render();
    // Curves and points are drawn, and gone when they are removed.
    host.Scene().Remove(SdfPath("/dots"));
    const Image withCurves = host.Render();
    host.Scene().Remove(SdfPath("/curves"));
    const Image meshes = host.Render();
    EXPECT_NE(withCurves, all);
    EXPECT_NE(meshes, withCurves);
    EXPECT_EQ(meshes, Host(ThreeMeshes(), Quick()).Render());
}

/// A grey disk of standard deviation 0.5 that faces the camera, as UsdImaging hands splats over.
GprimData MakeSplat(bool isHalf) {
    GprimData splat;
    splat.type = TfToken("particleField");
    const auto set = [&](const char* name, const auto& floats, const auto& halfs) {
        splat.SetPrimvar(name, HdInterpolationVertex, isHalf ? VtValue(halfs) : VtValue(floats));
    };
    set("positions", VtVec3fArray{GfVec3f(0.25F, 0.5F, 0)}, VtVec3hArray{GfVec3h(0.25F, 0.5F, 0)});
    set("orientations", VtQuatfArray{GfQuatf(1, 0, 0, 0)}, VtQuathArray{GfQuath(1, 0, 0, 0)});
    set("scales", VtVec3fArray{GfVec3f(0.5F)}, VtVec3hArray{GfVec3h(0.5F)});
    set("opacities", VtFloatArray{1.0F}, VtHalfArray{GfHalf(1.0F)});
    set("radiance:sphericalHarmonicsCoefficients", VtVec3fArray{GfVec3f(1, 0, -1)},
        VtVec3hArray{GfVec3h(1, 0, -1)});
    splat.SetPrimvar("radiance:sphericalHarmonicsDegree", HdInterpolationConstant, VtValue(0));
    return splat;
}

TEST_F(Prims, SplatsAreDrawnFromFloatsAndHalfsAndMove) {
    const HostOptions options = Quick();
    const SdfPath path("/splat");
    SceneData scene = ThreeMeshes();
    const Image meshes = Host(scene, options).Render();
    scene.gprims[path] = MakeSplat(false);
    Host host(scene, options);
    const Image floats = host.Render();
    EXPECT_NE(floats, meshes);
    host.Scene().SetGprim(path, MakeSplat(true));
    EXPECT_EQ(host.Render(), floats);
    GprimData moved = MakeSplat(true);
    moved.SetPrimvar("positions", HdInterpolationVertex, VtValue(VtVec3fArray{GfVec3f(-0.5F)}));
    host.Scene().SetGprim(path, moved);
    const Image after = host.Render();
    EXPECT_NE(after, floats);
    EXPECT_EQ(after, RenderFresh(host, options));
    host.Scene().Remove(path);
    EXPECT_EQ(host.Render(), meshes);
}

} // namespace

} // namespace hydraHost
