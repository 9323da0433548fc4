// SPDX-License-Identifier: Apache-2.0
// Render passes of USD stages, as UsdImaging's scene indices show them. Oracles: the same stage
// with prims deactivated, invisible, or with primvars of visibility, in a host without a pass;
// where both front ends must agree, the flags that translate/test_renderPasses.py asks for.
#include "hydraTest.h"

#include <pxr/base/tf/stringUtils.h>
#include <pxr/imaging/hdsi/sceneGlobalsSceneIndex.h>
#include <pxr/usd/usd/stage.h>
#include <pxr/usd/usdGeom/imageable.h>
#include <pxr/usdImaging/usdImaging/sceneIndices.h>
#include <pxr/usdImaging/usdImaging/stageSceneIndex.h>

#include <fstream>
#include <regex>
#include <set>
#include <sstream>

namespace hydraHost {

namespace {

using RenderPasses = HydraTest;

const std::vector<AovRequest> kAovs{HdAovTokens->color, TfToken("alpha"), HdAovTokens->cameraDepth};
const char* const kStage = R"(#usda 1.0
def Xform "World" {
    def Mesh "A" {
        int[] faceVertexCounts = [4]
        int[] faceVertexIndices = [0, 1, 2, 3]
        point3f[] points = [(-1.8, -1, 0), (-0.4, -1, 0), (-0.4, 0.9, 0), (-1.8, 0.9, 0)]
        color3f[] primvars:displayColor = [(0.9, 0.2, 0.1)]
    }
    def Cube "B" {
        double size = 0.8
        double3 xformOp:translate = (0.3, 0.2, -0.4)
        uniform token[] xformOpOrder = ["xformOp:translate"]
    }
    def SphereLight "Lamp" {
        float inputs:intensity = 40
        float inputs:radius = 0.3
        double3 xformOp:translate = (0.8, 1.1, 0.6)
        uniform token[] xformOpOrder = ["xformOp:translate"]
    }
}
class Xform "Shape" {
    def Cube "Body" { double size = 0.3 }
    def Sphere "Head" {
        double radius = 0.2
        double3 xformOp:translate = (0, 0.3, 0)
        uniform token[] xformOpOrder = ["xformOp:translate"]
    }
}
def Xform "I1" (instanceable = true; references = </Shape>) {
    double3 xformOp:translate = (1.2, -0.9, 0); uniform token[] xformOpOrder = ["xformOp:translate"]
}
def Xform "I2" (instanceable = true; references = </Shape>) {
    double3 xformOp:translate = (0.6, -0.9, 0); uniform token[] xformOpOrder = ["xformOp:translate"]
}
def Xform "I3" (instanceable = true; references = </Shape>) {
    double3 xformOp:translate = (0.0, -0.9, 0); uniform token[] xformOpOrder = ["xformOp:translate"]
}
def PointInstancer "Many" {
    rel prototypes = [</Many/P>, </Elsewhere/Q>]
    int[] protoIndices = [0, 1]
    point3f[] positions = [(1.4, 0.4, 0), (1.4, -0.2, 0)]
    def Xform "P" { def Cube "Box" { double size = 0.3 } }
}
def Xform "Elsewhere" { # behind the camera; as a prototype Q is where its instancer has it
    double3 xformOp:translate = (0, 0, 50)
    uniform token[] xformOpOrder = ["xformOp:translate"]
    def Cube "Q" { double size = 0.25 }
}
)";

/// A pass: the body of a UsdRenderPass with the collections that 25.02 does not apply by itself.
std::string Pass(const std::string& name, const std::string& body) {
    return "def RenderPass \"" + name +
           "\" (prepend apiSchemas = [\"CollectionAPI:cameraVisibility\", \"CollectionAPI:matte\", "
           "\"CollectionAPI:prune\"]) { uniform bool collection:cameraVisibility:includeRoot = "
           "1\n" +
           body + "\n}\n";
}

/// A host that shows a stage below a dome, before a camera.
class StageHost {
public:
    explicit StageHost(const std::string& further = {}) : _stage(UsdStage::CreateInMemory()) {
        // A brace needs a line of its own.
        const std::string text = TfStringReplace(kStage + further, "}", "\n}\n");
        EXPECT_TRUE(_stage->GetRootLayer()->ImportFromString(text));
        UsdImagingCreateSceneIndicesInfo info;
        info.stage = _stage;
        _indices = UsdImagingCreateSceneIndices(info);
        _globals = HdsiSceneGlobalsSceneIndex::New(_indices.finalSceneIndex);
        _host = std::make_unique<Host>(EmptyScene(), Quick(kAovs));
        _host->Index().InsertSceneIndex(_globals, SdfPath::AbsoluteRootPath(), false);
    }
    ~StageHost() {
        if (_host) {
            _host->Index().RemoveSceneIndex(_globals);
        }
    }

    UsdStage& Stage() { return *_stage; }
    void Choose(const char* pass) { _globals->SetActiveRenderPassPrimPath(SdfPath(pass)); }
    void Choose() { _globals->SetActiveRenderPassPrimPath(SdfPath()); }

    /// All AOVs, one behind the other.
    std::vector<float> Pixels() {
        _indices.stageSceneIndex->ApplyPendingUpdates();
        EXPECT_TRUE(_host->RenderUntilConverged());
        std::vector<float> pixels;
        for (const AovRequest& aov : kAovs) {
            const Image image = _host->Read(aov.name);
            for (int y = 0; y < image.height; ++y) {
                for (int x = 0; x < image.width; ++x) {
                    for (int i = 0; i < (aov.name == HdAovTokens->color ? 4 : 1); ++i) {
                        pixels.push_back(image.Float(x, y, i));
                    }
                }
            }
        }
        return pixels;
    }

    /// The scene as text.
    std::string Dump() {
        Pixels();
        const std::string file = ::testing::TempDir() + "/renderPass.txt";
        EXPECT_TRUE(_host->Delegate().InvokeCommand(TfToken("dumpScene"),
                                                    {{TfToken("file"), VtValue(file)}}));
        std::ifstream stream(file);
        std::stringstream text;
        text << stream.rdbuf();
        return text.str();
    }

private:
    UsdStageRefPtr _stage;
    UsdImagingSceneIndices _indices;
    HdsiSceneGlobalsSceneIndexRefPtr _globals;
    std::unique_ptr<Host> _host;
};

std::vector<float> PixelsOf(const std::function<void(UsdStage&)>& edit) {
    StageHost host;
    edit(host.Stage());
    return host.Pixels();
}

std::vector<float> PixelsOfPass(const std::string& body) {
    StageHost host(Pass("Pass", body));
    host.Choose("/Pass");
    return host.Pixels();
}

std::vector<float> Deactivated(const std::vector<const char*>& paths) {
    return PixelsOf([&](UsdStage& stage) {
        for (const char* path : paths) {
            stage.GetPrimAtPath(SdfPath(path)).SetActive(false);
        }
    });
}

std::vector<float> Invisible(const std::vector<const char*>& paths) {
    return PixelsOf([&](UsdStage& stage) {
        for (const char* path : paths) {
            UsdGeomImageable(stage.GetPrimAtPath(SdfPath(path))).MakeInvisible();
        }
    });
}

std::vector<float> WithPrimvars(const char* name, float value,
                                const std::vector<const char*>& paths) {
    return PixelsOf([&](UsdStage& stage) {
        for (const char* path : paths) {
            stage.GetPrimAtPath(SdfPath(path))
                .CreateAttribute(TfToken(std::string("primvars:") + name), SdfValueTypeNames->Float)
                .Set(value);
        }
    });
}

TEST_F(RenderPasses, PassesThatDoNothingAndNoPassAreTheSame) {
    const std::vector<float> plain = PixelsOf([](UsdStage&) {});
    EXPECT_EQ(PixelsOfPass(""), plain);
    EXPECT_NE(Deactivated({"/World/A"}), plain);
}

TEST_F(RenderPasses, PrunedIsDeactivated) {
    EXPECT_EQ(PixelsOfPass("rel collection:prune:includes = [</World/A>, </Many>]"),
              Deactivated({"/World/A", "/Many"}));
    EXPECT_EQ(PixelsOfPass("rel collection:prune:includes = [</World/Lamp>, </I2>]"),
              Deactivated({"/World/Lamp", "/I2"}));
    EXPECT_EQ(PixelsOfPass(
                  "pathExpression collection:prune:membershipExpression = \"/I1 /I2 /I3 //Lamp\""),
              Deactivated({"/I1", "/I2", "/I3", "/World/Lamp"}));
}

TEST_F(RenderPasses, WhatIsNotRenderedIsInvisible) {
    EXPECT_EQ(
        PixelsOfPass("rel collection:renderVisibility:excludes = [</World/B>, </World/Lamp>]"),
        Invisible({"/World/B", "/World/Lamp"}));
    EXPECT_EQ(PixelsOfPass("rel collection:renderVisibility:excludes = [</I1>, </Many>]"),
              Invisible({"/I1", "/Many"}));
}

TEST_F(RenderPasses, TheCameraSeesWhatIsLeft) {
    const char* const primvar = "hdstream:visibility:camera";
    EXPECT_EQ(PixelsOfPass("rel collection:cameraVisibility:excludes = </World/A>"),
              WithPrimvars(primvar, 0.0F, {"/World/A"}));
    EXPECT_EQ(PixelsOfPass("rel collection:cameraVisibility:excludes = </I2>"),
              WithPrimvars(primvar, 0.0F, {"/I2"}));
    EXPECT_EQ(PixelsOfPass("rel collection:cameraVisibility:excludes = [</World/B>, </Many>]"),
              WithPrimvars(primvar, 0.0F, {"/World/B", "/Many/P/Box", "/Elsewhere/Q"}));
    const std::vector<float> whole = PixelsOf([](UsdStage&) {});
    const std::vector<float> hidden =
        PixelsOfPass("rel collection:cameraVisibility:excludes = </World/Lamp>");
    EXPECT_NE(hidden, whole);
    EXPECT_NE(hidden, Deactivated({"/World/Lamp"})); // it still lights
}

TEST_F(RenderPasses, MattesAreHeldOut) {
    const char* const primvar = "hdstream:holdout";
    EXPECT_EQ(PixelsOfPass("rel collection:matte:includes = [</World/B>, </Many>]"),
              WithPrimvars(primvar, 1.0F, {"/World/B", "/Many/P/Box", "/Elsewhere/Q"}));
    EXPECT_EQ(PixelsOfPass("rel collection:matte:includes = [</I1>, </I3>]"),
              WithPrimvars(primvar, 1.0F, {"/I1", "/I3"}));
    // What is the same in all instances may be said of a prim inside.
    EXPECT_EQ(PixelsOfPass("pathExpression collection:matte:membershipExpression = \"//Head\""),
              WithPrimvars(primvar, 1.0F, {"/Shape/Head"}));
    // What is not does not count.
    EXPECT_EQ(PixelsOfPass("rel collection:matte:includes = </I2/Head>"),
              PixelsOf([](UsdStage&) {}));
}

TEST_F(RenderPasses, PrototypesElsewhereHaveTheMembershipOfTheirInstancer) {
    const std::vector<float> plain = PixelsOf([](UsdStage&) {});
    EXPECT_EQ(PixelsOfPass("rel collection:matte:includes = </Elsewhere/Q>"), plain);
    EXPECT_EQ(PixelsOfPass("rel collection:matte:includes = </Many/P>"),
              WithPrimvars("hdstream:holdout", 1.0F, {"/Many/P/Box"}));
}

TEST_F(RenderPasses, HostsChooseAndStagesChange) {
    StageHost host(Pass("First", "rel collection:prune:includes = </World/A>") +
                   Pass("Second", "rel collection:renderVisibility:excludes = [</World/B>, </I2>]\n"
                                  "rel collection:matte:includes = </I1>"));
    StageHost second(Pass("Second",
                          "rel collection:renderVisibility:excludes = [</World/B>, </I2>]\n"
                          "rel collection:matte:includes = </I1>"));
    second.Choose("/Second");
    const std::vector<float> plain = host.Pixels();
    host.Choose("/First");
    EXPECT_EQ(host.Pixels(), Deactivated({"/World/A"}));
    host.Choose("/Second");
    EXPECT_EQ(host.Pixels(), second.Pixels());
    host.Choose();
    EXPECT_EQ(host.Pixels(), plain);
    host.Choose("/First");
    host.Pixels();
    host.Stage().RemovePrim(SdfPath("/First"));
    EXPECT_EQ(host.Pixels(), plain);
}

} // namespace

} // namespace hydraHost
