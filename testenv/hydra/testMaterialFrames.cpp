// SPDX-License-Identifier: Apache-2.0
// Materials that ask for the frame: they show the one that the scene's globals say, also when
// nothing else changes with it. A card glows with it.
#include "hydraTest.h"

#include <pxr/imaging/hd/retainedSceneIndex.h>
#include <pxr/imaging/hdsi/sceneGlobalsSceneIndex.h>

#include <cfloat>
#include <memory>

namespace hydraHost {

namespace {

constexpr float kScale = 1.0F / 64.0F; // of what the card emits
const SdfPath kLook("/look");

HdMaterialNetworkMap Look(const char* id) {
    HdMaterialNode asking;
    asking.path = SdfPath("/Asking");
    asking.identifier = TfToken(id);
    HdMaterialNode surface;
    surface.path = SdfPath("/Surface");
    surface.identifier = TfToken("ND_surface_unlit");
    surface.parameters = {{TfToken("emission_color"), VtValue(GfVec3f(kScale))}};
    HdMaterialNetworkMap map;
    HdMaterialNetwork& network = map.map[HdMaterialTerminalTokens->surface];
    network.nodes = {asking, surface};
    network.relationships = {{asking.path, TfToken("out"), surface.path, TfToken("emission")}};
    map.terminals.push_back(surface.path);
    return map;
}

SceneData Card(const char* id) {
    SceneData scene = EmptyScene();
    scene.materials[kLook] = Look(id);
    scene.gprims[SdfPath("/card")] = MakeGrid(2.0F, 2.0F);
    scene.gprims[SdfPath("/card")].material = kLook;
    return scene;
}

class MaterialFrames : public HydraTest {
protected:
    void Begin(const char* id) {
        _globals = HdsiSceneGlobalsSceneIndex::New(HdRetainedSceneIndex::New());
        _host = std::make_unique<Host>(Card(id), Quick());
        _host->Index().InsertSceneIndex(_globals, SdfPath::AbsoluteRootPath(), false);
    }
    void TearDown() override {
        if (_host) {
            _host->Index().RemoveSceneIndex(_globals);
        }
    }
    void SetFrame(double frame) { _globals->SetCurrentFrame(frame); }

    /// What the card's middle emits, without the scale.
    float Shown() {
        const Image image = _host->Render();
        return image.Float(image.width / 2, image.height / 2, 0) / kScale;
    }
    int NumUnknown() { return NumWarnings(*_host, "the frame, which is not known"); }

    HdsiSceneGlobalsSceneIndexRefPtr _globals;
    std::unique_ptr<Host> _host;
};

TEST_F(MaterialFrames, AreThoseOfTheScene) {
    Begin("ND_frame_float");
    for (const double frame : {3.0, 4.0, 4.0, 10.5, 3.0}) {
        SetFrame(frame);
        EXPECT_FLOAT_EQ(Shown(), static_cast<float>(frame));
    }
    EXPECT_EQ(NumUnknown(), 0);
}

TEST_F(MaterialFrames, GiveTheTimeInSeconds) {
    Begin("ND_time_float");
    for (const double frame : {12.0, 36.0}) {
        SetFrame(frame);
        EXPECT_FLOAT_EQ(Shown(), static_cast<float>(frame / 24.0));
    }
}

TEST_F(MaterialFrames, AreZeroWithAWarningWhereTheHostDoesNotTell) {
    Begin("ND_frame_float");
    EXPECT_EQ(Shown(), 0.0F);
    EXPECT_EQ(NumUnknown(), 1);
    SetFrame(-DBL_MAX); // OpenUSD's earliest time
    EXPECT_EQ(Shown(), 0.0F);
    EXPECT_EQ(NumUnknown(), 1);
    SetFrame(5.0);
    EXPECT_FLOAT_EQ(Shown(), 5.0F);
}

TEST_F(MaterialFrames, AreLookedForInWhatAMaterialIsNow) {
    Begin("ND_frame_float");
    SetFrame(2.0);
    EXPECT_FLOAT_EQ(Shown(), 2.0F);
    _host->Scene().SetMaterial(kLook, Look("ND_time_float"));
    EXPECT_FLOAT_EQ(Shown(), 2.0F / 24.0F);
    SetFrame(48.0);
    EXPECT_FLOAT_EQ(Shown(), 2.0F);
}

} // namespace

} // namespace hydraHost
