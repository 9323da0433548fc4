// SPDX-License-Identifier: Apache-2.0
// The film back covers what UsdGeomCamera's formulas say, conformed to the display window.
#include "hdStream/integrator/cameraFrame.h"

#include <glm/gtc/matrix_transform.hpp>
#include <gtest/gtest.h>

#include <cmath>

namespace hds {
namespace {

RenderOptions OptionsOf(std::uint32_t width, std::uint32_t height) {
    RenderOptions options;
    options.imageWidth = width;
    options.imageHeight = height;
    options.displayWindow = {0.0, 0.0, static_cast<double>(width), static_cast<double>(height)};
    options.camera.horizontalAperture = 3.6F;
    options.camera.verticalAperture = 2.4F;
    options.camera.focalLength = 5.0F;
    return options;
}

TEST(CameraFrame, PerspectiveFilmAtDistanceOne) {
    const auto params = MakeFrameParams(OptionsOf(300, 200), glm::dvec3(0.0), 0);
    EXPECT_FLOAT_EQ(params.filmOrigin[0], -0.36F); // -3.6 / 2 / 5
    EXPECT_FLOAT_EQ(params.filmOrigin[1], 0.24F);
    EXPECT_FLOAT_EQ(params.filmStep[0], 0.72F / 300);
    EXPECT_FLOAT_EQ(params.filmStep[1], -0.48F / 200);
}

TEST(CameraFrame, TheApertureGrowsToTheImage) {
    const auto simd8 = MakeFrameParams(OptionsOf(400, 200), glm::dvec3(0.0), 0);
    EXPECT_FLOAT_EQ(simd8.filmOrigin[1], 0.24F); // the height stays
    EXPECT_FLOAT_EQ(simd8.filmOrigin[0], -0.48F);
    const auto tall = MakeFrameParams(OptionsOf(200, 200), glm::dvec3(0.0), 0);
    EXPECT_FLOAT_EQ(tall.filmOrigin[0], -0.36F); // the width stays
    EXPECT_FLOAT_EQ(tall.filmOrigin[1], 0.36F);
}

TEST(CameraFrame, PixelAspectWidensPixels) {
    RenderOptions options = OptionsOf(150, 200);
    options.pixelAspectRatio = 2.0; // 150 simd8 pixels are as broad as 300
    const auto params = MakeFrameParams(options, glm::dvec3(0.0), 0);
    EXPECT_FLOAT_EQ(params.filmStep[0], 0.72F / 150);
    EXPECT_FLOAT_EQ(params.filmStep[1], -0.48F / 200);
}

TEST(CameraFrame, OffsetsShiftTheWindow) {
    RenderOptions options = OptionsOf(300, 200);
    options.camera.horizontalApertureOffset = 0.5F;
    options.camera.verticalApertureOffset = -0.2F;
    const auto params = MakeFrameParams(options, glm::dvec3(0.0), 0);
    EXPECT_FLOAT_EQ(params.filmOrigin[0], -0.36F + 0.1F);
    EXPECT_FLOAT_EQ(params.filmOrigin[1], 0.24F - 0.04F);
}

TEST(CameraFrame, OrthographicAndLensInSceneUnits) {
    RenderOptions options = OptionsOf(300, 200);
    options.camera.orthographic = true;
    EXPECT_FLOAT_EQ(MakeFrameParams(options, glm::dvec3(0.0), 0).filmOrigin[0], -1.8F);
    options.camera.orthographic = false;
    options.camera.fStop = 2.0F;
    options.camera.focusDistance = 10.0F;
    EXPECT_FLOAT_EQ(MakeFrameParams(options, glm::dvec3(0.0), 0).lensRadius,
                    1.25F); // 5 / 2 / 2
}

TEST(CameraFrame, ConformPoliciesFitTheApertureAsUsdRenderSays) {
    struct Case {
        ConformPolicy policy;
        float halfWidth, halfHeight; ///< of the film at distance 1, for an image twice as simd8
    };
    const Case cases[] = {{ConformPolicy::ExpandAperture, 0.48F, 0.24F},
                          {ConformPolicy::CropAperture, 0.36F, 0.18F},
                          {ConformPolicy::AdjustApertureWidth, 0.48F, 0.24F},
                          {ConformPolicy::AdjustApertureHeight, 0.36F, 0.18F},
                          {ConformPolicy::AdjustPixelAspectRatio, 0.36F, 0.24F}};
    for (const Case& expected : cases) {
        RenderOptions options = OptionsOf(400, 200);
        options.conformPolicy = expected.policy;
        const auto params = MakeFrameParams(options, glm::dvec3(0.0), 0);
        EXPECT_FLOAT_EQ(params.filmOrigin[0], -expected.halfWidth);
        EXPECT_FLOAT_EQ(params.filmOrigin[1], expected.halfHeight);
        EXPECT_FLOAT_EQ(params.filmStep[0] * 400.0F, 2.0F * expected.halfWidth);
        EXPECT_FLOAT_EQ(params.filmStep[1] * 200.0F, -2.0F * expected.halfHeight);
    }
}

TEST(CameraFrame, ADataWindowChangesNothingButTheFirstPixel) {
    RenderOptions options = OptionsOf(300, 200);
    const auto full = MakeFrameParams(options, glm::dvec3(0.0), 0);
    options.imageWidth = 50;
    options.imageHeight = 40;
    options.dataWindowMin = {-10, 120};
    const auto crop = MakeFrameParams(options, glm::dvec3(0.0), 0);
    for (int i = 0; i < 2; ++i) {
        EXPECT_EQ(crop.filmOrigin[i], full.filmOrigin[i]);
        EXPECT_EQ(crop.filmStep[i], full.filmStep[i]);
    }
    EXPECT_EQ(crop.dataWindowMin[0], -10);
    EXPECT_EQ(crop.dataWindowMin[1], 120);
}

TEST(CameraFrame, TheDisplayWindowHoldsTheAperture) {
    RenderOptions options = OptionsOf(300, 200);
    options.displayWindow = {100.0, 50.0, 250.0, 150.0}; // the rest is overscan
    const auto params = MakeFrameParams(options, glm::dvec3(0.0), 0);
    EXPECT_FLOAT_EQ(params.filmOrigin[0] + 100.0F * params.filmStep[0], -0.36F);
    EXPECT_FLOAT_EQ(params.filmOrigin[0] + 250.0F * params.filmStep[0], 0.36F);
    EXPECT_FLOAT_EQ(params.filmOrigin[1] + 50.0F * params.filmStep[1], 0.24F);
    EXPECT_FLOAT_EQ(params.filmOrigin[1] + 150.0F * params.filmStep[1], -0.24F);
}

TEST(CameraFrame, ClippingPlanesAreCarriedToTheWorld) {
    RenderOptions options = OptionsOf(300, 200);
    options.camera.worldFromCamera = glm::rotate(
        glm::translate(glm::dmat4(1.0), glm::dvec3(10.0, -4.0, 7.0)), 0.7, glm::dvec3(1, 2, 3));
    const glm::dvec4 plane(0.3, -0.2, -1.0, -5.0);
    options.camera.clippingPlanes = {plane};
    const glm::dvec3 centre(2.0, 3.0, -1.0);
    const auto params = MakeFrameParams(options, centre, 0);
    ASSERT_EQ(params.numClipPlanes, 1U);
    for (const glm::dvec3& point :
         {glm::dvec3(0.0), glm::dvec3(1.0, 2.0, -30.0), glm::dvec3(-4.0, 8.0, -3.0)}) {
        const glm::dvec4 world = options.camera.worldFromCamera * glm::dvec4(point, 1.0);
        double ours = params.clipPlanes[0][3];
        for (int i = 0; i < 3; ++i) {
            ours += params.clipPlanes[0][i] * (world[i] - centre[i]);
        }
        EXPECT_NEAR(ours, glm::dot(plane, glm::dvec4(point, 1.0)), 1e-5);
    }
}

TEST(CameraFrame, TheCentreIsTakenOffInDouble) {
    RenderOptions options = OptionsOf(300, 200);
    options.camera.worldFromCamera =
        glm::translate(glm::dmat4(1.0), glm::dvec3(1e9 + 0.25, 0.0, 0.0));
    const auto params = MakeFrameParams(options, glm::dvec3(1e9, 0.0, 0.0), 0);
    EXPECT_EQ(params.worldFromCamera[3], 0.25F);
}

/// A box of edge 2 around the origin.
const MediaBounds kBox{glm::dvec3(-1.0), glm::dvec3(1.0)};

TEST(CameraFrame, CamerasInTheBoxOfMediaLookForThem) {
    RenderOptions options = OptionsOf(300, 200);
    const auto length = [&](double z, bool moves) {
        options.camera.worldFromCamera = glm::translate(glm::dmat4(1.0), glm::dvec3(0.0, 0.0, z));
        return MediaProbeLength(MakeFrameParams(options, glm::dvec3(0.0), 0), kBox, moves);
    };
    // From outside of the box, whatever the direction.
    EXPECT_GT(length(0.5, false), 0.5 + std::sqrt(3.0));
    EXPECT_EQ(length(1.5, false), 0.0F);
    EXPECT_GT(length(1.5, true), 1.5 + std::sqrt(3.0)); // the box may come to the camera
    options.camera.fStop = 1.0F;
    options.camera.focusDistance = 10.0F;
    options.camera.worldFromCamera =
        glm::translate(glm::dmat4(1.0), glm::dvec3(3.0, 0.0, 0.0)); // a lens of radius 2.5
    EXPECT_GT(MediaProbeLength(MakeFrameParams(options, glm::dvec3(0.0), 0), kBox, false), 0.0F);
}

TEST(CameraFrame, NobodyLooksForMediaWhereThereAreNone) {
    const auto params = MakeFrameParams(OptionsOf(300, 200), glm::dvec3(0.0), 0);
    EXPECT_EQ(MediaProbeLength(params, MediaBounds(), true), 0.0F);
}

TEST(CameraFrame, OrthographicCamerasLookForMediaOverTheirWholeFilm) {
    RenderOptions options = OptionsOf(300, 200);
    options.camera.orthographic = true;
    const auto length = [&](double x) {
        options.camera.worldFromCamera = glm::translate(glm::dmat4(1.0), glm::dvec3(x, 0.0, 0.0));
        return MediaProbeLength(MakeFrameParams(options, glm::dvec3(0.0), 0), kBox, false);
    };
    EXPECT_GT(length(2.5), 0.0F); // the film is 3.6 wide
    EXPECT_EQ(length(3.5), 0.0F);
}

} // namespace
} // namespace hds
