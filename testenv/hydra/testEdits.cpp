// SPDX-License-Identifier: Apache-2.0
// Edits give the bits of a fresh delegate, and cheap ones prepare no geometry.
#include "hydraTest.h"

#include <pxr/imaging/hd/camera.h>
#include <pxr/imaging/hd/changeTracker.h>
#include <pxr/imaging/hd/light.h>

#include <algorithm>

namespace hydraHost {

namespace {

const SdfPath kQuad("/quad");
const SdfPath kCube("/cube");
const SdfPath kNgons("/ngons");
const SdfPath kCamera("/camera");
const SdfPath kDome("/dome");

/// Changes a gprim and marks the bits.
std::function<void(SyntheticScene&)> GprimEdit(const SdfPath& path, HdDirtyBits bits,
                                               std::function<void(GprimData&)> change) {
    return [=](SyntheticScene& scene) {
        GprimData gprim = scene.Data().gprims.at(path);
        change(gprim);
        scene.SetGprim(path, gprim, bits);
    };
}

struct EditCase {
    const char* name;
    bool isCheap; ///< may prepare no geometry
    std::function<void(SyntheticScene&)> edit;
};

void MoveCamera(SyntheticScene& scene) {
    CameraData camera = scene.Data().cameras.at(kCamera);
    camera.transform =
        GfMatrix4d(1.0).SetRotate(GfRotation(GfVec3d(0, 0, 1), 20.0)) * Translation(0.3, -0.1, 4.0);
    scene.SetCamera(kCamera, camera, HdCamera::DirtyTransform);
}

void ZoomCamera(SyntheticScene& scene) {
    CameraData camera = scene.Data().cameras.at(kCamera);
    camera.params[HdCameraTokens->focalLength] = VtValue(3.0F);
    scene.SetCamera(kCamera, camera, HdCamera::DirtyParams);
}

void DimDome(SyntheticScene& scene) {
    LightData dome = scene.Data().lights.at(kDome);
    dome.params[HdLightTokens->intensity] = VtValue(0.5F);
    scene.SetLight(kDome, dome, HdLight::DirtyParams);
}

void HideDome(SyntheticScene& scene) {
    LightData dome = scene.Data().lights.at(kDome);
    dome.isVisible = false;
    scene.SetLight(kDome, dome, HdLight::DirtyParams);
}

void AddLight(SyntheticScene& scene) {
    LightData light;
    light.type = HdPrimTypeTokens->sphereLight;
    light.transform = Translation(1.0, 2.0, 3.0);
    light.params = {{HdLightTokens->radius, VtValue(0.5F)},
                    {HdLightTokens->intensity, VtValue(4.0F)},
                    {HdLightTokens->color, VtValue(GfVec3f(1.0F))}};
    scene.SetLight(SdfPath("/lamp"), light);
}

void EditMaterial(SyntheticScene& scene) {
    scene.SetMaterial(SdfPath("/materials/green"), MakeMaterial(GfVec3f(0.9F, 0.8F, 0.1F)));
}

void Subset(GprimData& gprim) {
    HdMeshTopology mesh = gprim.mesh;
    mesh.SetGeomSubsets({{HdGeomSubset::TypeFaceSet, SdfPath("/quad/subset"),
                          SdfPath("/materials/blue"), VtIntArray{0, 3}}});
    gprim.mesh = mesh;
}

void MovePoints(GprimData& gprim) {
    VtVec3fArray points = gprim.FindPrimvar(HdTokens->points)->value.Get<VtVec3fArray>();
    points[0] += GfVec3f(0.2F, -0.1F, 0.3F);
    gprim.SetPrimvar("points", HdInterpolationVertex, VtValue(points), HdPrimvarRoleTokens->point);
}

void Flatten(GprimData& gprim) {
    const HdMeshTopology& old = gprim.mesh;
    gprim.mesh = HdMeshTopology(
        TfToken("none"), HdTokens->rightHanded, VtIntArray{4, 4},
        VtIntArray(old.GetFaceVertexIndices().cbegin(), old.GetFaceVertexIndices().cbegin() + 8));
}

void PaintVertices(GprimData& gprim) {
    VtVec3fArray colors(10, GfVec3f(0.1F));
    colors[3] = GfVec3f(1.0F, 0.0F, 0.0F);
    gprim.SetPrimvar("displayColor", HdInterpolationVertex, VtValue(colors),
                     HdPrimvarRoleTokens->color);
    gprim.material = SdfPath();
}

std::vector<EditCase> Cases() {
    using Tracker = HdChangeTracker;
    return {
        {"transform", true,
         GprimEdit(kCube, Tracker::DirtyTransform,
                   [](GprimData& g) { g.transform = Translation(0.8, 0.6, 0.4); })},
        {"visibility", true,
         GprimEdit(kCube, Tracker::DirtyVisibility, [](GprimData& g) { g.isVisible = false; })},
        {"material", true, EditMaterial},
        {"binding", true,
         GprimEdit(kCube, Tracker::DirtyMaterialId,
                   [](GprimData& g) { g.material = SdfPath("/materials/red"); })},
        {"unbinding", true,
         GprimEdit(kCube, Tracker::DirtyMaterialId, [](GprimData& g) { g.material = SdfPath(); })},
        {"binding to nothing", true,
         GprimEdit(kCube, Tracker::DirtyMaterialId,
                   [](GprimData& g) { g.material = SdfPath("/materials/none"); })},
        {"culling", true,
         GprimEdit(kCube, Tracker::DirtyCullStyle,
                   [](GprimData& g) { g.cullStyle = HdCullStyleFront; })},
        {"camera transform", true, MoveCamera},
        {"camera parameters", true, ZoomCamera},
        {"light intensity", true, DimDome},
        {"light visibility", true, HideDome},
        {"light added", true, AddLight},
        {"light removed", true, [](SyntheticScene& scene) { scene.Remove(kDome); }},
        {"prim removed", true, [](SyntheticScene& scene) { scene.Remove(kNgons); }},
        {"subset with a material", false, GprimEdit(kQuad, Tracker::DirtyTopology, Subset)},
        {"points", false, GprimEdit(kNgons, Tracker::DirtyPoints, MovePoints)},
        {"topology", false, GprimEdit(kQuad, Tracker::DirtyTopology, Flatten)},
        {"displayColor", false,
         GprimEdit(kNgons, Tracker::DirtyPrimvar | Tracker::DirtyMaterialId, PaintVertices)},
        {"everything", false,
         GprimEdit(kCube, Tracker::AllDirty,
                   [](GprimData& g) {
                       g = MakeCube(0.8F);
                       g.isDoubleSided = false;
                   })},
    };
}

class Edits : public HydraTest, public ::testing::WithParamInterface<size_t> {};

TEST_P(Edits, GiveTheBitsOfAFreshDelegate) {
    const EditCase editCase = Cases()[GetParam()];
    SCOPED_TRACE(editCase.name);
    const HostOptions options = Quick();
    Host host(ThreeMeshes(), options);
    const Image before = host.Render();
    ASSERT_GT(before.width, 0);
    editCase.edit(host.Scene());
    const Image after = host.Render();
    EXPECT_NE(after, before) << "the edit shows nothing, so the test proves nothing";
    EXPECT_EQ(after, RenderFresh(host, options));
    if (editCase.isCheap) {
        EXPECT_EQ(host.Statistic("geometry.chunksBuilt"), 0.0);
    }
}

TEST_P(Edits, GiveTheBitsOfResidentGeometryWhileItStreams) {
    const EditCase editCase = Cases()[GetParam()];
    SCOPED_TRACE(editCase.name);
    HostOptions options = Quick();
    options.settings[TfToken("residency")] = VtValue(std::string("stream"));
    options.settings[TfToken("geometryMemory")] = VtValue(std::string("70%"));
    options.settings[TfToken("chunkBytes")] = VtValue(4096);
    Host host(ThreeMeshes(), options);
    ASSERT_GT(host.Render().width, 0);
    EXPECT_GT(host.Statistic("geometry.uploads"), 0.0);
    EXPECT_LT(host.Statistic("geometry.budget"), host.Statistic("geometry.bytesTotal"));
    editCase.edit(host.Scene());
    EXPECT_EQ(host.Render(), RenderFresh(host, Quick()));
}

INSTANTIATE_TEST_SUITE_P(All, Edits, ::testing::Range(size_t(0), Cases().size()),
                         [](const ::testing::TestParamInfo<size_t>& paramInfo) {
                             std::string name = Cases()[paramInfo.param].name;
                             name.erase(std::remove(name.begin(), name.end(), ' '), name.end());
                             return name;
                         });

using EditsWhileRendering = HydraTest;

TEST_F(EditsWhileRendering, ShowInTheEnd) {
    // Edits land in every state of the render: before it begins, while it runs, after it.
    const HostOptions options = Quick({HdAovTokens->color}, 8);
    Host host(ThreeMeshes(), options);
    for (const EditCase& editCase : Cases()) {
        if (editCase.name == std::string("prim removed") ||
            editCase.name == std::string("light removed")) {
            continue;
        }
        editCase.edit(host.Scene());
        host.Frame();
    }
    EXPECT_EQ(host.Render(), RenderFresh(host, options));
}

TEST_F(EditsWhileRendering, UndoneEditGivesTheFirstBits) {
    Host host(ThreeMeshes(), Quick());
    const Image first = host.Render();
    const GprimData cube = host.Scene().Data().gprims.at(kCube);
    GprimData moved = cube;
    moved.transform = Translation(0.2, 0.2, 0.2);
    host.Scene().SetGprim(kCube, moved, HdChangeTracker::DirtyTransform);
    ASSERT_NE(host.Render(), first);
    host.Scene().SetGprim(kCube, cube, HdChangeTracker::DirtyTransform);
    EXPECT_EQ(host.Render(), first);
}

} // namespace

} // namespace hydraHost
