// SPDX-License-Identifier: Apache-2.0
// What dicing sees of a camera: all of the picture, whatever part of it is drawn, and its way.
#include "hdStream/integrator/dicingCamera.h"

#include <glm/geometric.hpp>
#include <glm/gtc/matrix_transform.hpp>
#include <gtest/gtest.h>

namespace hds {
namespace {

RenderOptions MakeOptions() {
    RenderOptions options;
    options.imageWidth = 160;
    options.imageHeight = 120;
    options.displayWindow = {0.0, 0.0, 160.0, 120.0};
    return options;
}

double PixelsPerUnit(const DicingCamera& camera) {
    return camera.imageSize.x / (camera.windowMax.x - camera.windowMin.x);
}

TEST(DicingCamera, SeesWhatLiesBesideTheDisplayWindow) {
    const DicingCamera plain = MakeDicingCamera(MakeOptions());
    EXPECT_EQ(plain.imageSize, glm::dvec2(160.0, 120.0));
    RenderOptions options = MakeOptions();
    options.imageWidth = 320; // to the right, and a little at the top
    options.imageHeight = 140;
    options.dataWindowMin = {0, -20};
    const DicingCamera overscan = MakeDicingCamera(options);
    const glm::dvec2 size = plain.windowMax - plain.windowMin;
    EXPECT_EQ(overscan.imageSize, glm::dvec2(320.0, 140.0));
    EXPECT_NEAR(overscan.windowMin.x, plain.windowMin.x, 1e-6);
    EXPECT_NEAR(overscan.windowMax.x, plain.windowMax.x + size.x, 1e-6);
    EXPECT_NEAR(overscan.windowMin.y, plain.windowMin.y, 1e-6);
    EXPECT_NEAR(overscan.windowMax.y, plain.windowMax.y + size.y / 6.0, 1e-6);
    EXPECT_NEAR(PixelsPerUnit(overscan) / PixelsPerUnit(plain), 1.0, 1e-9);
}

TEST(DicingCamera, IsThatOfThePictureForItsParts) {
    const DicingCamera plain = MakeDicingCamera(MakeOptions());
    RenderOptions crop = MakeOptions();
    crop.imageWidth = 10;
    crop.imageHeight = 20;
    crop.dataWindowMin = {30, 40};
    EXPECT_TRUE(MakeDicingCamera(crop) == plain);
    crop.uncroppedWindow = {0.0, 0.0, 160.0, 120.0};
    EXPECT_TRUE(MakeDicingCamera(crop) == plain);
    // Of a picture with overscan, within the display window and beside it.
    RenderOptions whole = MakeOptions();
    whole.imageWidth = 320;
    crop.uncroppedWindow = {0.0, 0.0, 320.0, 120.0};
    EXPECT_TRUE(MakeDicingCamera(crop) == MakeDicingCamera(whole));
    crop.dataWindowMin = {300, 40};
    EXPECT_TRUE(MakeDicingCamera(crop) == MakeDicingCamera(whole));
    EXPECT_FALSE(MakeDicingCamera(crop) == plain);
}

TEST(DicingCamera, HasAWayWhileTheShutterIsOpen) {
    RenderOptions options = MakeOptions();
    for (const double time : {0.0, 1.0}) {
        options.camera.samples.push_back(
            {time, glm::translate(glm::dmat4(1.0), {4.0 * time, 0.0, 0.0})});
    }
    EXPECT_TRUE(MakeDicingCamera(options).path.empty());
    options.shutter = {0.0, 1.0};
    const DicingCamera camera = MakeDicingCamera(options);
    ASSERT_EQ(camera.path.size(), kDicingSteps + 1);
    EXPECT_EQ(camera.path.front()[3].x, 0.0);
    EXPECT_EQ(camera.path[kDicingSteps / 4][3].x, 1.0);
    EXPECT_EQ(camera.path.back()[3].x, 4.0);
}

} // namespace
} // namespace hds
