// SPDX-License-Identifier: Apache-2.0
// Framing: windows, conform policies, pixel aspect, projections.
#include "hydraTest.h"

#include <pxr/base/gf/range1f.h>
#include <pxr/imaging/hd/camera.h>

namespace hydraHost {

namespace {

using Framing = HydraTest;

void ExpectDepths(Host& host) {
    ASSERT_TRUE(host.RenderUntilConverged());
    ExpectFloats(host.Read(HdAovTokens->depth), Oracle(host), 0, 2e-6,
                 [](const OracleHit& hit) { return hit.isHit ? hit.depth : 1.0; });
}

const std::vector<AovRequest> kAovs{HdAovTokens->color, HdAovTokens->depth};

TEST_F(Framing, DataWindowSmallerThanTheBufferHasTheBitsOfTheWhole) {
    Host host(ThreeMeshes(), Quick(kAovs));
    ASSERT_TRUE(host.RenderUntilConverged());
    const Image whole = host.Read();
    const Image wholeDepth = host.Read(HdAovTokens->depth);
    // y down: rows 8 to 31 of 48 are rows 16 to 39 upwards.
    host.SetFraming(CameraUtilFraming(GfRange2f(GfVec2f(0, 0), GfVec2f(64, 48)),
                                      GfRect2i(GfVec2i(12, 8), 40, 24)));
    ASSERT_TRUE(host.RenderUntilConverged());
    const Image part = host.Read();
    const Image partDepth = host.Read(HdAovTokens->depth);
    for (int y = 0; y < 48; ++y) {
        for (int x = 0; x < 64; ++x) {
            if (x >= 12 && x < 52 && y >= 16 && y < 40) {
                ASSERT_EQ(partDepth.Float(x, y), wholeDepth.Float(x, y)) << x << " " << y;
                for (int component = 0; component < 4; ++component) {
                    ASSERT_EQ(part.Float(x, y, component), whole.Float(x, y, component))
                        << x << " " << y;
                }
            } else {
                ASSERT_EQ(partDepth.Float(x, y), 1.0F) << x << " " << y;
            }
        }
    }
}

TEST_F(Framing, DisplayWindowLargerThanTheBufferIsACropOfTheWhole) {
    Host whole(ThreeMeshes(), Quick(kAovs));
    const Image wholeColor = whole.Render();
    const Image wholeDepth = whole.Read(HdAovTokens->depth);
    HostOptions options = Quick(kAovs);
    options.width = 30;
    options.height = 20;
    Host crop(ThreeMeshes(), options);
    // The buffer shows columns 20 to 49 and, y down, rows 10 to 29 of the display window.
    crop.SetFraming(CameraUtilFraming(GfRange2f(GfVec2f(-20, -10), GfVec2f(44, 38)),
                                      GfRect2i(GfVec2i(0, 0), 30, 20)));
    const Image cropColor = crop.Render();
    const Image cropDepth = crop.Read(HdAovTokens->depth);
    ASSERT_EQ(cropColor.width, 30);
    for (int y = 0; y < 20; ++y) {
        for (int x = 0; x < 30; ++x) {
            const int wholeY = y + 48 - 30;
            ASSERT_EQ(cropDepth.Float(x, y), wholeDepth.Float(x + 20, wholeY)) << x << " " << y;
            for (int component = 0; component < 4; ++component) {
                ASSERT_EQ(cropColor.Float(x, y, component),
                          wholeColor.Float(x + 20, wholeY, component))
                    << x << " " << y;
            }
        }
    }
}

TEST_F(Framing, DisplayWindowSmallerThanTheBufferIsAnOverscan) {
    Host host(ThreeMeshes(), Quick(kAovs));
    host.SetFraming(CameraUtilFraming(GfRange2f(GfVec2f(10, 6), GfVec2f(54, 39)),
                                      GfRect2i(GfVec2i(0, 0), 64, 48)));
    ExpectDepths(host);
}

/// A bent floor of 8 x 8 faces, from the horizon to below the camera.
SceneData BentFloor() {
    SceneData scene = EmptyScene();
    GprimData floor = MakeGrid(5.0F, 8.0F, 8, 8);
    VtVec3fArray points = floor.FindPrimvar(HdTokens->points)->value.Get<VtVec3fArray>();
    for (std::size_t i = 0; i < points.size(); ++i) {
        points[i] = GfVec3f(points[i][0], i % 2 == 0 ? -1.5F : -1.1F, -3.0F - points[i][1]);
    }
    scene.gprims[SdfPath("/floor")] = MakeMesh(
        {points.cbegin(), points.cend()},
        {floor.mesh.GetFaceVertexCounts().cbegin(), floor.mesh.GetFaceVertexCounts().cend()},
        {floor.mesh.GetFaceVertexIndices().cbegin(), floor.mesh.GetFaceVertexIndices().cend()},
        "catmullClark");
    return scene;
}

TEST_F(Framing, DataWindowOfAnOverscanHasTheBitsOfTheWhole) {
    HostOptions options = Quick(kAovs);
    options.settings[TfToken("enableInteractive")] = VtValue(false); // diced for what is seen
    const GfRange2f display(GfVec2f(10, 6), GfVec2f(54, 30));
    Host whole(BentFloor(), options);
    whole.SetFraming(CameraUtilFraming(display, GfRect2i(GfVec2i(0, 0), 64, 48)));
    const Image wholeDepth = whole.Render(HdAovTokens->depth);
    // Inside of the display window, and beside it.
    for (const GfRect2i& window :
         {GfRect2i(GfVec2i(16, 6), 24, 24), GfRect2i(GfVec2i(2, 14), 12, 16)}) {
        Host host(BentFloor(), options);
        host.SetFraming(CameraUtilFraming(display, window));
        const Image part = host.Render(HdAovTokens->depth);
        int numHits = 0;
        for (int row = window.GetMinY(); row <= window.GetMaxY(); ++row) {
            const int y = 47 - row;
            for (int x = window.GetMinX(); x <= window.GetMaxX(); ++x) {
                ASSERT_EQ(part.Float(x, y), wholeDepth.Float(x, y)) << x << " " << y;
                numHits += part.Float(x, y) < 1.0F ? 1 : 0;
            }
        }
        EXPECT_GT(numHits, 20);
    }
}

TEST_F(Framing, ConformPoliciesAreHydras) {
    for (const CameraUtilConformWindowPolicy policy :
         {CameraUtilMatchVertically, CameraUtilMatchHorizontally, CameraUtilFit, CameraUtilCrop,
          CameraUtilDontConform}) {
        SCOPED_TRACE(int(policy));
        HostOptions options = Quick(kAovs);
        options.width = 40;
        options.height = 56;
        Host host(ThreeMeshes(), options);
        host.Task().State().SetOverrideWindowPolicy(policy);
        ExpectDepths(host);
        host.SetSize(72, 24);
        ExpectDepths(host);
    }
}

TEST_F(Framing, CamerasOwnPolicyCounts) {
    SceneData scene = ThreeMeshes();
    scene.cameras.at(SdfPath("/camera")).params[HdCameraTokens->windowPolicy] =
        VtValue(CameraUtilCrop);
    HostOptions options = Quick(kAovs);
    options.width = 72;
    Host host(scene, options);
    ExpectDepths(host);
}

TEST_F(Framing, PixelAspectRatioCounts) {
    for (const float ratio : {0.5F, 2.0F}) {
        SCOPED_TRACE(ratio);
        Host host(ThreeMeshes(), Quick(kAovs));
        host.SetFraming(CameraUtilFraming(GfRange2f(GfVec2f(0, 0), GfVec2f(64, 48)),
                                          GfRect2i(GfVec2i(0, 0), 64, 48), ratio));
        ExpectDepths(host);
    }
}

TEST_F(Framing, ViewportStandsInForAFraming) {
    Host host(ThreeMeshes(), Quick(kAovs));
    host.SetFraming(CameraUtilFraming());
    host.Task().State().SetViewport(GfVec4d(0, 0, 64, 48));
    ExpectDepths(host);
}

TEST_F(Framing, ApertureOffsetsShiftTheImage) {
    SceneData scene = ThreeMeshes();
    CameraData& camera = scene.cameras.at(SdfPath("/camera"));
    camera.params[HdCameraTokens->horizontalApertureOffset] = VtValue(0.4F);
    camera.params[HdCameraTokens->verticalApertureOffset] = VtValue(-0.2F);
    Host host(scene, Quick(kAovs));
    ExpectDepths(host);
}

TEST_F(Framing, OrthographicCamera) {
    SceneData scene = ThreeMeshes();
    scene.cameras[SdfPath("/camera")] = MakeOrthographicCamera(GfVec3d(0.1, 0.2, 5.0), 2.0);
    Host host(scene, Quick(kAovs));
    ExpectDepths(host);
}

TEST_F(Framing, ClippingRangeCuts) {
    SceneData scene = ThreeMeshes();
    scene.cameras.at(SdfPath("/camera")).params[HdCameraTokens->clippingRange] =
        VtValue(GfRange1f(4.6F, 5.1F));
    Host host(scene, Quick(kAovs));
    ExpectDepths(host);
}

TEST_F(Framing, SizeEditsRenderAnew) {
    const HostOptions options = Quick(kAovs);
    Host host(ThreeMeshes(), options);
    const Image first = host.Render();
    host.SetSize(48, 64);
    ExpectDepths(host);
    host.SetSize(64, 48);
    EXPECT_EQ(host.Render(), first);
}

} // namespace

} // namespace hydraHost
