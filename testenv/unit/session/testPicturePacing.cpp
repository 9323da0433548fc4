// SPDX-License-Identifier: Apache-2.0
// When pictures are due, by a scripted clock.
#include "hdStream/session/picturePacing.h"

#include <gtest/gtest.h>

namespace hds::test {
namespace {

TEST(PicturePacing, FinerStridesAreDueAtOnce) {
    PicturePacing pacing(0.1);
    double now = 5.0;
    for (const std::uint32_t stride : {8U, 4U, 2U, 1U}) {
        EXPECT_TRUE(pacing.IsDue(now, stride));
        pacing.Made(now, now + 0.001, stride);
        now += 0.001;
        EXPECT_FALSE(pacing.IsDue(now, stride));
        EXPECT_EQ(pacing.Stride(), stride);
    }
}

TEST(PicturePacing, PicturesAreApartAndTakeATenthOfTheTime) {
    PicturePacing pacing(0.25);
    pacing.Made(0.0, 0.0, 1);
    EXPECT_FALSE(pacing.IsDue(0.2, 1));
    EXPECT_TRUE(pacing.IsDue(0.25, 1));
    pacing.Made(0.25, 0.75, 1);
    EXPECT_FALSE(pacing.IsDue(5.5, 1));
    EXPECT_TRUE(pacing.IsDue(5.75, 1));
}

TEST(PicturePacing, ALongFirstPictureDelaysNothing) {
    PicturePacing pacing(0.125);
    pacing.Made(1.0, 3.25, 1); // the driver compiles
    EXPECT_TRUE(pacing.IsDue(3.375, 1));
    pacing.Made(3.375, 3.375, 1);
    EXPECT_TRUE(pacing.IsDue(3.5, 1));
}

} // namespace
} // namespace hds::test
