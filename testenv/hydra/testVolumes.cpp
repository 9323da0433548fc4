// SPDX-License-Identifier: Apache-2.0
// Volumes and their fields: edits give the bits of a fresh delegate, bad ones are named.
#include "hydraTest.h"

#include <pxr/imaging/hd/changeTracker.h>
#include <pxr/imaging/hd/field.h>
#include <pxr/usd/sdf/assetPath.h>

#include <functional>

namespace hydraHost {

namespace {

const SdfPath kSmoke("/smoke");
const SdfPath kField("/field");
const SdfPath kOther("/other");

FieldData MakeField(const char* grid, const char* file = HDSTREAM_TEST_GRIDS) {
    FieldData field;
    field.params[HdFieldTokens->filePath] = VtValue(SdfAssetPath(file, file));
    field.params[HdFieldTokens->fieldName] = VtValue(TfToken(grid));
    return field;
}

SceneData Smoke() {
    SceneData scene;
    scene.fields[kField] = MakeField("density");
    scene.fields[kOther] = MakeField("flame");
    GprimData smoke;
    smoke.type = HdPrimTypeTokens->volume;
    smoke.transform = GfMatrix4d(1.0).SetScale(3.0) * Translation(-2.0, -2.0, -2.0);
    smoke.volumeFields = {{TfToken("density"), TfToken("openvdbAsset"), kField}};
    scene.gprims[kSmoke] = smoke;
    scene.lights[SdfPath("/dome")] = MakeDome(GfVec3f(0.5F, 0.6F, 0.7F));
    scene.cameras[SdfPath("/camera")] = MakeCamera(GfVec3d(0, 0, 6));
    return scene;
}

std::function<void(SyntheticScene&)> VolumeEdit(HdDirtyBits bits,
                                                std::function<void(GprimData&)> change) {
    return [=](SyntheticScene& scene) {
        GprimData volume = scene.Data().gprims.at(kSmoke);
        change(volume);
        scene.SetGprim(kSmoke, volume, bits);
    };
}

struct EditCase {
    const char* name;
    std::function<void(SyntheticScene&)> edit;
};

std::vector<EditCase> Cases() {
    using Tracker = HdChangeTracker;
    return {
        {"transform", VolumeEdit(Tracker::DirtyTransform,
                                 [](GprimData& v) { v.transform *= Translation(0.5, 0.1, 0.0); })},
        {"visibility",
         VolumeEdit(Tracker::DirtyVisibility, [](GprimData& v) { v.isVisible = false; })},
        {"purpose", VolumeEdit(Tracker::DirtyRenderTag,
                               [](GprimData& v) { v.renderTag = HdRenderTagTokens->guide; })},
        {"fieldOfVolume", VolumeEdit(Tracker::DirtyVolumeField,
                                     [](GprimData& v) { v.volumeFields[0].fieldId = kOther; })},
        {"gridOfField", [](SyntheticScene& scene) { scene.SetField(kField, MakeField("flame")); }},
        {"removed", [](SyntheticScene& scene) { scene.Remove(kSmoke); }},
    };
}

class Volumes : public HydraTest, public ::testing::WithParamInterface<size_t> {};

TEST_P(Volumes, EditsGiveTheBitsOfAFreshDelegate) {
    const EditCase editCase = Cases()[GetParam()];
    SCOPED_TRACE(editCase.name);
    Host host(Smoke(), Quick());
    const Image before = host.Render();
    ASSERT_GT(before.width, 0);
    editCase.edit(host.Scene());
    const Image after = host.Render();
    EXPECT_NE(after, before) << "the edit shows nothing, so the test proves nothing";
    EXPECT_EQ(after, RenderFresh(host, Quick()));
}

INSTANTIATE_TEST_SUITE_P(All, Volumes, ::testing::Range(size_t(0), Cases().size()),
                         [](const ::testing::TestParamInfo<size_t>& paramInfo) {
                             return std::string(Cases()[paramInfo.param].name);
                         });

using MovingVolumes = HydraTest;

// With a shutter that opens later, and a transform whose samples change, as from the start.
TEST_F(MovingVolumes, AreBlurred) {
    SceneData scene = Smoke();
    GprimData& smoke = scene.gprims[kSmoke];
    const GfMatrix4d place = smoke.transform;
    smoke.transformSamples = {{-0.25F, place * Translation(-0.8, 0, 0)},
                              {0.0F, place},
                              {0.5F, place * Translation(1.6, 0.6, 0)}};
    const HostOptions options = Quick({HdAovTokens->color}, 8);
    Host host(scene, options);
    const Image still = host.Render();

    SetShutter(host, -0.25, 0.5);
    const Image blurred = host.Render();
    EXPECT_NE(blurred, still);
    EXPECT_EQ(blurred, RenderFresh(host, options));

    GprimData turned = host.Scene().Data().gprims.at(kSmoke);
    turned.transformSamples[0.5F] = place * Translation(0, -1.6, 0);
    host.Scene().SetGprim(kSmoke, turned, HdChangeTracker::DirtyTransform);
    const Image other = host.Render();
    EXPECT_NE(other, blurred);
    EXPECT_EQ(other, RenderFresh(host, options));
}

using BadVolumes = HydraTest;

TEST_F(BadVolumes, AreNamed) {
    SceneData scene = Smoke();
    scene.fields[kField] = MakeField("density", "/nowhere/missing.vdb");
    Host host(scene, Quick());
    ASSERT_GT(host.Render().width, 0);
    EXPECT_EQ(NumWarnings(host, "missing.vdb"), 1);
    EXPECT_EQ(NumWarnings(host, "/smoke: field 'density'"), 1);
}

} // namespace

} // namespace hydraHost
