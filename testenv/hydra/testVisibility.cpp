// SPDX-License-Identifier: Apache-2.0
// What is drawn: visibility, render tags, cull styles, clip planes.
#include "hydraTest.h"

#include <pxr/imaging/hd/camera.h>
#include <pxr/imaging/hd/changeTracker.h>
#include <pxr/imaging/hd/rprim.h>

#include <cmath>
#include <set>

namespace hydraHost {

namespace {

using Visibility = HydraTest;

const std::vector<AovRequest> kAovs{HdAovTokens->color, HdAovTokens->primId};

/// The prims that have a pixel.
std::set<SdfPath> SeenPrims(Host& host) {
    std::set<SdfPath> prims;
    if (!host.RenderUntilConverged()) {
        ADD_FAILURE() << "no convergence";
        return prims;
    }
    const Image image = host.Read(HdAovTokens->primId);
    for (int y = 0; y < image.height; ++y) {
        for (int x = 0; x < image.width; ++x) {
            if (image.Int(x, y) >= 0) {
                prims.insert(host.Index().GetRprimPathFromPrimId(image.Int(x, y)));
            }
        }
    }
    return prims;
}

const SdfPath kQuad("/quad");
const SdfPath kCube("/cube");
const SdfPath kNgons("/ngons");

TEST_F(Visibility, EditsHideAndShow) {
    Host host(ThreeMeshes(), Quick(kAovs));
    EXPECT_EQ(SeenPrims(host), (std::set<SdfPath>{kQuad, kCube, kNgons}));
    GprimData cube = host.Scene().Data().gprims.at(kCube);
    cube.isVisible = false;
    host.Scene().SetGprim(kCube, cube, HdChangeTracker::DirtyVisibility);
    EXPECT_EQ(SeenPrims(host), (std::set<SdfPath>{kQuad, kNgons}));
    cube.isVisible = true;
    host.Scene().SetGprim(kCube, cube, HdChangeTracker::DirtyVisibility);
    EXPECT_EQ(SeenPrims(host), (std::set<SdfPath>{kQuad, kCube, kNgons}));
}

TEST_F(Visibility, CollectionsOfRenderPassesAreWhatIsDrawn) {
    Host host(ThreeMeshes(), Quick(kAovs));
    const std::set<SdfPath> all{kQuad, kCube, kNgons};
    const auto seen = [&host](const SdfPathVector& roots, const SdfPathVector& excluded) {
        HdRprimCollection collection(HdTokens->geometry, HdReprSelector(HdReprTokens->refined));
        collection.SetRootPaths(roots);
        collection.SetExcludePaths(excluded);
        host.SetCollection(collection);
        return SeenPrims(host);
    };
    const SdfPath root = SdfPath::AbsoluteRootPath();
    EXPECT_EQ(SeenPrims(host), all);
    EXPECT_EQ(seen({kQuad, kNgons}, {}), (std::set<SdfPath>{kQuad, kNgons}));
    EXPECT_EQ(seen({root}, {kNgons}), (std::set<SdfPath>{kQuad, kCube}));
    EXPECT_EQ(seen({root, kQuad}, {}), all);
    EXPECT_EQ(seen({SdfPath("/qua")}, {SdfPath("/cub")}), std::set<SdfPath>());
    EXPECT_EQ(seen({kQuad, kCube}, {kQuad}), (std::set<SdfPath>{kCube}));
}

TEST_F(Visibility, PrimEditedWhileInvisibleShowsTheEdit) {
    const HostOptions options = Quick(kAovs);
    SceneData scene = ThreeMeshes();
    scene.gprims.at(kCube).isVisible = false;
    Host host(scene, options);
    EXPECT_EQ(SeenPrims(host), (std::set<SdfPath>{kQuad, kNgons}));
    GprimData cube = scene.gprims.at(kCube);
    cube.transform = Translation(1.0, 0.7, 0.0);
    host.Scene().SetGprim(kCube, cube, HdChangeTracker::DirtyTransform);
    host.Frame();
    cube.isVisible = true;
    host.Scene().SetGprim(kCube, cube, HdChangeTracker::DirtyVisibility);
    EXPECT_EQ(host.Render(), RenderFresh(host, options));
}

TEST_F(Visibility, RenderTagsChooseWithoutEdits) {
    SceneData scene = ThreeMeshes();
    scene.gprims.at(kCube).renderTag = HdRenderTagTokens->guide;
    scene.gprims.at(kNgons).renderTag = HdRenderTagTokens->proxy;
    Host host(scene, Quick(kAovs));
    EXPECT_EQ(SeenPrims(host), (std::set<SdfPath>{kQuad}));
    host.Task().SetRenderTags({HdRenderTagTokens->geometry, HdRenderTagTokens->guide});
    EXPECT_EQ(SeenPrims(host), (std::set<SdfPath>{kQuad, kCube}));
    host.Task().SetRenderTags({HdRenderTagTokens->proxy});
    EXPECT_EQ(SeenPrims(host), (std::set<SdfPath>{kNgons}));
    host.Task().SetRenderTags({HdRenderTagTokens->geometry});
    EXPECT_EQ(SeenPrims(host), (std::set<SdfPath>{kQuad}));
}

TEST_F(Visibility, RenderTagEditMovesAPrim) {
    Host host(ThreeMeshes(), Quick(kAovs));
    EXPECT_EQ(SeenPrims(host).size(), 3U);
    GprimData cube = host.Scene().Data().gprims.at(kCube);
    cube.renderTag = HdRenderTagTokens->guide;
    host.Scene().SetGprim(kCube, cube, HdChangeTracker::DirtyRenderTag);
    EXPECT_EQ(SeenPrims(host), (std::set<SdfPath>{kQuad, kNgons}));
}

/// A quad before the camera.
struct CullCase {
    HdCullStyle style;
    bool isDoubleSided;
    bool isFrontSeen;
    bool isBackSeen;
};

TEST_F(Visibility, CullStylesAreHydras) {
    const CullCase cases[] = {
        {HdCullStyleNothing, false, true, true},
        {HdCullStyleBack, false, true, false},
        {HdCullStyleFront, false, false, true},
        {HdCullStyleBackUnlessDoubleSided, false, true, false},
        {HdCullStyleBackUnlessDoubleSided, true, true, true},
        {HdCullStyleFrontUnlessDoubleSided, false, false, true},
        {HdCullStyleFrontUnlessDoubleSided, true, true, true},
        {HdCullStyleBack, true, true, false},
        {HdCullStyleDontCare, false, true, true},
    };
    const GfMatrix4d away = GfMatrix4d(1.0).SetRotate(GfRotation(GfVec3d(0, 1, 0), 180.0));
    const GfMatrix4d mirrored = GfMatrix4d(1.0).SetScale(GfVec3d(-1, 1, 1));
    SceneData scene = EmptyScene();
    scene.gprims[kQuad] = MakeGrid(1.0F, 1.0F);
    Host host(scene, Quick(kAovs));
    for (const CullCase& cullCase : cases) {
        SCOPED_TRACE(int(cullCase.style) * 10 + int(cullCase.isDoubleSided));
        GprimData quad = MakeGrid(1.0F, 1.0F);
        quad.cullStyle = cullCase.style;
        quad.isDoubleSided = cullCase.isDoubleSided;
        host.Scene().SetGprim(kQuad, quad);
        EXPECT_EQ(SeenPrims(host).size(), size_t(cullCase.isFrontSeen));
        quad.transform = away;
        host.Scene().SetGprim(kQuad, quad, HdChangeTracker::DirtyTransform);
        EXPECT_EQ(SeenPrims(host).size(), size_t(cullCase.isBackSeen));
        // A mirror keeps the outside of a surface outside: Hydra flips the winding with it.
        quad.transform = mirrored;
        host.Scene().SetGprim(kQuad, quad, HdChangeTracker::DirtyTransform);
        EXPECT_EQ(SeenPrims(host).size(), size_t(cullCase.isFrontSeen));
        quad.transform = GfMatrix4d(1.0);
        quad.mesh =
            HdMeshTopology(TfToken("none"), HdTokens->leftHanded, quad.mesh.GetFaceVertexCounts(),
                           quad.mesh.GetFaceVertexIndices());
        host.Scene().SetGprim(kQuad, quad);
        EXPECT_EQ(SeenPrims(host).size(), size_t(cullCase.isBackSeen));
    }
}

TEST_F(Visibility, CullStyleOfTheRenderCountsWhereThePrimHasNone) {
    SceneData scene = EmptyScene();
    scene.gprims[kQuad] = MakeGrid(1.0F, 1.0F);
    scene.gprims.at(kQuad).isDoubleSided = false;
    Host host(scene, Quick(kAovs));
    host.Task().State().SetCullStyle(HdCullStyleFront);
    EXPECT_TRUE(SeenPrims(host).empty());
    host.Task().State().SetCullStyle(HdCullStyleBack);
    EXPECT_EQ(SeenPrims(host).size(), 1U);
}

TEST_F(Visibility, ClipPlanesCutInCameraSpace) {
    SceneData scene = EmptyScene();
    scene.gprims[kQuad] = MakeGrid(1.5F, 1.0F);
    scene.gprims[kQuad].transform = Translation(7.0, 0.0, 0.0);
    CameraData& camera = scene.cameras.at(SdfPath("/camera"));
    camera.transform = camera.transform * Translation(7.0, 0.0, 0.0);
    camera.params[HdCameraTokens->clipPlanes] =
        VtValue(std::vector<GfVec4d>{GfVec4d(1.0, 0.0, 0.0, 0.25)});
    Host host(scene, Quick(kAovs));
    ASSERT_TRUE(host.RenderUntilConverged());
    const Image image = host.Read(HdAovTokens->primId);
    const int quadId = host.Index().GetRprim(kQuad)->GetPrimId();
    // The plane is at x = -0.25 in camera space, 5 before it: 64 pixels show 5 units there.
    for (int x = 14; x < 50; ++x) {
        const double xCamera = (x + 0.5 - 32.0) * 5.0 / 64.0;
        if (std::abs(xCamera + 0.25) > 0.05) {
            ASSERT_EQ(image.Int(x, 24), xCamera > -0.25 ? quadId : -1) << x;
        }
    }
    CameraData unclipped = host.Scene().Data().cameras.at(SdfPath("/camera"));
    unclipped.params[HdCameraTokens->clipPlanes] = VtValue(std::vector<GfVec4d>());
    host.Scene().SetCamera(SdfPath("/camera"), unclipped, HdCamera::DirtyClipPlanes);
    ASSERT_TRUE(host.RenderUntilConverged());
    EXPECT_EQ(host.Read(HdAovTokens->primId).Int(16, 24), quadId);
}

} // namespace

} // namespace hydraHost
