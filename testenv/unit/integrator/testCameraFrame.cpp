// SPDX-License-Identifier: Apache-2.0
// The film back covers what UsdGeomCamera's formulas say, conformed by expanding the aperture.
#include "hdStream/integrator/cameraFrame.h"

#include <glm/gtc/matrix_transform.hpp>
#include <gtest/gtest.h>

namespace hds {
namespace {

RenderOptions OptionsOf(std::uint32_t width, std::uint32_t height) {
    RenderOptions options;
    options.imageWidth = width;
    options.imageHeight = height;
    options.camera.horizontalAperture = 36.0;
    options.camera.verticalAperture = 24.0;
    options.camera.focalLength = 50.0;
    return options;
}

TEST(CameraFrame, PerspectiveFilmAtDistanceOne) {
    const auto params = MakeFrameParams(OptionsOf(300, 200), glm::dvec3(0.0), 0);
    EXPECT_FLOAT_EQ(params.filmOrigin[0], -0.36F); // -36 / 2 / 50
    EXPECT_FLOAT_EQ(params.filmOrigin[1], 0.24F);
    EXPECT_FLOAT_EQ(params.filmStep[0], 0.72F / 300);
    EXPECT_FLOAT_EQ(params.filmStep[1], -0.48F / 200);
}

TEST(CameraFrame, TheApertureGrowsToTheImage) {
    const auto wide = MakeFrameParams(OptionsOf(400, 200), glm::dvec3(0.0), 0);
    EXPECT_FLOAT_EQ(wide.filmOrigin[1], 0.24F); // the height stays
    EXPECT_FLOAT_EQ(wide.filmOrigin[0], -0.48F);
    const auto tall = MakeFrameParams(OptionsOf(200, 200), glm::dvec3(0.0), 0);
    EXPECT_FLOAT_EQ(tall.filmOrigin[0], -0.36F); // the width stays
    EXPECT_FLOAT_EQ(tall.filmOrigin[1], 0.36F);
}

TEST(CameraFrame, PixelAspectWidensPixels) {
    RenderOptions options = OptionsOf(150, 200);
    options.pixelAspectRatio = 2.0; // 150 wide pixels are as broad as 300
    const auto params = MakeFrameParams(options, glm::dvec3(0.0), 0);
    EXPECT_FLOAT_EQ(params.filmStep[0], 0.72F / 150);
    EXPECT_FLOAT_EQ(params.filmStep[1], -0.48F / 200);
}

TEST(CameraFrame, OffsetsShiftTheWindow) {
    RenderOptions options = OptionsOf(300, 200);
    options.camera.horizontalApertureOffset = 5.0;
    options.camera.verticalApertureOffset = -2.0;
    const auto params = MakeFrameParams(options, glm::dvec3(0.0), 0);
    EXPECT_FLOAT_EQ(params.filmOrigin[0], -0.36F + 0.1F);
    EXPECT_FLOAT_EQ(params.filmOrigin[1], 0.24F - 0.04F);
}

TEST(CameraFrame, OrthographicInSceneUnitsAndLensInTenths) {
    RenderOptions options = OptionsOf(300, 200);
    options.camera.orthographic = true;
    EXPECT_FLOAT_EQ(MakeFrameParams(options, glm::dvec3(0.0), 0).filmOrigin[0], -1.8F);
    options.camera.orthographic = false;
    options.camera.fStop = 2.0;
    options.camera.focusDistance = 10.0;
    EXPECT_FLOAT_EQ(MakeFrameParams(options, glm::dvec3(0.0), 0).lensRadius,
                    1.25F); // 50 / 10 / 2 / 2
}

TEST(CameraFrame, TheCentreIsTakenOffInDouble) {
    RenderOptions options = OptionsOf(300, 200);
    options.camera.worldFromCamera =
        glm::translate(glm::dmat4(1.0), glm::dvec3(1e9 + 0.25, 0.0, 0.0));
    const auto params = MakeFrameParams(options, glm::dvec3(1e9, 0.0, 0.0), 0);
    EXPECT_EQ(params.worldFromCamera[3], 0.25F);
}

} // namespace
} // namespace hds
