// SPDX-License-Identifier: Apache-2.0
// Shared parts of the render delegate's tests.
#include "hydraTest.h"

#include <pxr/base/tf/stringUtils.h>
#include <pxr/imaging/hd/camera.h>

#include <cmath>

namespace hydraHost {

void HydraTest::SetUp() {
    if (!HasRenderer(RendererId())) {
        FAIL() << "no renderer plug-in " << RendererId() << ", or it does not load";
    }
}

HdRenderSettingsMap QuickSettings(int samples) {
    HdRenderSettingsMap settings;
    settings[TfToken("samples")] = VtValue(samples);
    settings[TfToken("maxDepth")] = VtValue(1);
    settings[TfToken("pixelFilter")] = VtValue(std::string("box"));
    settings[TfToken("pixelFilterWidth")] = VtValue(1.0);
    settings[TfToken("noCache")] = VtValue(true);
    return settings;
}

HostOptions Quick(const std::vector<AovRequest>& aovs, int samples) {
    HostOptions options;
    options.settings = QuickSettings(samples);
    options.aovs = aovs;
    return options;
}

SceneData EmptyScene() {
    SceneData scene;
    scene.cameras[SdfPath("/camera")] = MakeCamera(GfVec3d(0.0, 0.0, 5.0));
    scene.lights[SdfPath("/dome")] = MakeDome(GfVec3f(1.0F));
    return scene;
}

SceneData ThreeMeshes() {
    SceneData scene = EmptyScene();
    // Not the dome that a scene without lights gets.
    scene.lights[SdfPath("/dome")] = MakeDome(GfVec3f(0.6F, 0.7F, 0.9F));
    const auto addMaterial = [&scene](const char* name, const GfVec3f& diffuse) {
        const SdfPath path = SdfPath("/materials").AppendChild(TfToken(name));
        scene.materials[path] = MakeMaterial(diffuse);
        return path;
    };
    GprimData quad = MakeGrid(0.9F, 0.8F, 3, 2);
    quad.transform = GfMatrix4d(1.0).SetRotate(GfRotation(GfVec3d(1, 2, 0), 35.0)) *
                     Translation(-1.1, 0.6, -0.3);
    quad.material = addMaterial("red", GfVec3f(0.8F, 0.1F, 0.1F));
    scene.gprims[SdfPath("/quad")] = quad;

    GprimData cube = MakeCube(0.5F);
    cube.transform = GfMatrix4d(1.0).SetRotate(GfRotation(GfVec3d(1, 1, 0.3), 50.0)) *
                     Translation(1.1, 0.5, 0.2);
    cube.material = addMaterial("green", GfVec3f(0.1F, 0.7F, 0.2F));
    scene.gprims[SdfPath("/cube")] = cube;

    // A pentagon, a triangle beside it, and a hexagon: elementId must count authored faces.
    GprimData ngons = MakeMesh({{-1, -0.3F, 0},
                                {-0.2F, -0.5F, 0},
                                {0.1F, 0.1F, 0},
                                {-0.3F, 0.5F, 0},
                                {-0.9F, 0.4F, 0},
                                {0.5F, -0.4F, 0},
                                {1.2F, -0.5F, 0},
                                {1.4F, 0, 0},
                                {1.1F, 0.5F, 0},
                                {0.6F, 0.5F, 0}},
                               {5, 3, 6}, {0, 1, 2, 3, 4, 1, 5, 2, 2, 5, 6, 7, 8, 9});
    ngons.transform = Translation(-0.1, -1.0, 0.1);
    ngons.material = addMaterial("blue", GfVec3f(0.1F, 0.2F, 0.9F));
    scene.gprims[SdfPath("/ngons")] = ngons;
    return scene;
}

namespace {

/// Calls `compare` for each unambiguous pixel and checks that they are most. It returns what is
/// wrong, or nothing.
void ForPixels(const Image& image, const Oracle& oracle,
               const std::function<std::string(int, int, const OracleHit&)>& compare) {
    ASSERT_GT(image.width * image.height, 0) << "no image";
    int numCompared = 0;
    int numWrong = 0;
    for (int y = 0; y < image.height; ++y) {
        for (int x = 0; x < image.width; ++x) {
            const OracleHit hit = oracle.Trace(x, y);
            if (hit.isAmbiguous) {
                continue;
            }
            ++numCompared;
            const std::string wrong = compare(x, y, hit);
            if (!wrong.empty() && ++numWrong <= 5) {
                ADD_FAILURE() << "pixel (" << x << ", " << y << ") " << wrong << "; hit "
                              << (hit.isHit ? hit.prim.GetString() : "nothing") << " instance "
                              << hit.instance << " face " << hit.face;
            }
        }
    }
    EXPECT_EQ(numWrong, 0) << "of " << numCompared << " pixels";
    EXPECT_GT(numCompared, image.width * image.height / 2);
}

std::string Mismatch(double value, double expected) {
    return TfStringPrintf("is %.9g, expected %.9g", value, expected);
}

} // namespace

void ExpectInts(const Image& image, const Oracle& oracle,
                const std::function<int(const OracleHit&)>& expected) {
    ForPixels(image, oracle, [&](int x, int y, const OracleHit& hit) {
        const int value = image.Int(x, y);
        return value == expected(hit) ? std::string() : Mismatch(value, expected(hit));
    });
}

void ExpectFloats(const Image& image, const Oracle& oracle, int component, double tolerance,
                  const std::function<double(const OracleHit&)>& expected) {
    ForPixels(image, oracle, [&](int x, int y, const OracleHit& hit) {
        const double value = double(image.Float(x, y, component));
        const double wanted = expected(hit);
        const bool isRight = value == wanted || std::abs(value - wanted) <= tolerance;
        return isRight ? std::string() : Mismatch(value, wanted);
    });
}

void SetShutter(Host& host, double open, double close) {
    const SdfPath path("/camera");
    CameraData camera = host.Scene().Data().cameras.at(path);
    camera.params[HdCameraTokens->shutterOpen] = VtValue(open);
    camera.params[HdCameraTokens->shutterClose] = VtValue(close);
    host.Scene().SetCamera(path, camera, HdCamera::DirtyParams);
}

int NumWarnings(Host& host, const std::string& text) {
    int count = 0;
    const VtDictionary stats = host.Delegate().GetRenderStats();
    const VtValue* lines = stats.GetValueAtPath("warnings");
    if (lines && lines->IsHolding<std::vector<VtValue>>()) {
        for (const VtValue& line : lines->UncheckedGet<std::vector<VtValue>>()) {
            count += line.Get<std::string>().find(text) != std::string::npos;
        }
    }
    return count;
}

Image RenderFresh(Host& host, const HostOptions& options, const TfToken& aov) {
    Host fresh(host.Scene().Data(), options);
    return fresh.Render(aov);
}

} // namespace hydraHost
