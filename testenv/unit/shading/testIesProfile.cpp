// SPDX-License-Identifier: Apache-2.0
// LM-63 files: what is read, how symmetries are completed, means, and files that are none.
#include "hdStream/shading/iesProfile.h"

#include <gtest/gtest.h>

#include <cmath>

namespace hds {
namespace {

constexpr double kPi = 3.14159265358979323846;

/// A file of LM-63-1995 with these angles and values, multiplier 2, ballast factors 0.5 and 1.
std::string FileOf(const std::string& polars, const std::string& azimuths,
                   const std::string& values, int numPolars, int numAzimuths,
                   const std::string& type = "1") {
    return "IESNA:LM-63-1995\r\n[TEST] none\r\n[MANUFAC] no TILT= here\r\nTILT=NONE\r\n1 -1 2.0 " +
           std::to_string(numPolars) + " " + std::to_string(numAzimuths) + " " + type +
           " 2 0.1 0.1 0\r\n0.5 1.0 30\r\n" + polars + "\r\n" + azimuths + "\r\n" + values + "\r\n";
}

IesProfile Parse(const std::string& text) {
    std::string error;
    IesProfile profile = ParseIesProfile(text, &error);
    EXPECT_EQ(error, "");
    return profile;
}

float Value(const IesProfile& profile, std::size_t azimuth, std::size_t polar) {
    return profile.candela[azimuth * profile.polars.size() + polar];
}

TEST(IesProfileTest, OneAzimuthIsTheSameAllAround) {
    const IesProfile profile = Parse(FileOf("0 45 90", "0", "10, 20 3e1", 3, 1));
    ASSERT_EQ(profile.polars.size(), 3U);
    ASSERT_EQ(profile.azimuths.size(), 2U);
    EXPECT_NEAR(profile.polars[1], kPi / 4.0, 1e-6);
    EXPECT_NEAR(profile.azimuths[1], 2.0 * kPi, 1e-6);
    EXPECT_FLOAT_EQ(Value(profile, 0, 1), 20.0F); // times 2 times 0.5
    EXPECT_FLOAT_EQ(Value(profile, 1, 2), 30.0F);
}

TEST(IesProfileTest, QuadrantsAreMirrored) {
    const IesProfile profile = Parse(FileOf("0 90", "0 30 90", "1 2\n3 4\n5 6", 2, 3));
    const double degrees[] = {0, 30, 90, 150, 180, 210, 270, 330, 360};
    const float expected[] = {2, 4, 6, 4, 2, 4, 6, 4, 2};
    ASSERT_EQ(profile.azimuths.size(), 9U);
    for (std::size_t i = 0; i < 9; ++i) {
        EXPECT_NEAR(profile.azimuths[i], degrees[i] * kPi / 180.0, 1e-6);
        EXPECT_FLOAT_EQ(Value(profile, i, 1), expected[i]) << degrees[i];
    }
}

TEST(IesProfileTest, HalvesAreMirrored) {
    const IesProfile profile = Parse(FileOf("0 90", "0 60 180", "1 2 3 4 5 6", 2, 3));
    const double degrees[] = {0, 60, 180, 300, 360};
    const float expected[] = {2, 4, 6, 4, 2};
    ASSERT_EQ(profile.azimuths.size(), 5U);
    for (std::size_t i = 0; i < 5; ++i) {
        EXPECT_NEAR(profile.azimuths[i], degrees[i] * kPi / 180.0, 1e-6);
        EXPECT_FLOAT_EQ(Value(profile, i, 1), expected[i]) << degrees[i];
    }
    const IesProfile other = Parse(FileOf("0 90", "90 180 270", "1 2 3 4 5 6", 2, 3));
    const float ofOther[] = {4, 2, 4, 6, 4}; // at 0, 90, 180, 270, 360
    ASSERT_EQ(other.azimuths.size(), 5U);
    for (std::size_t i = 0; i < 5; ++i) {
        EXPECT_FLOAT_EQ(Value(other, i, 1), ofOther[i]) << i;
    }
}

/// No column at 180 degrees: what is there, and at 0, is half-way between its neighbours.
TEST(IesProfileTest, HalvesOfAnOddNumberOfStepsAreMirrored) {
    const IesProfile profile = Parse(FileOf("0 90", "90 150 210 270", "1 2 3 4 5 8 7 9", 2, 4));
    const double degrees[] = {0, 30, 90, 150, 210, 270, 330, 360};
    const float expected[] = {6, 4, 2, 4, 8, 9, 8, 6};
    ASSERT_EQ(profile.azimuths.size(), 8U);
    for (std::size_t i = 0; i < 8; ++i) {
        EXPECT_NEAR(profile.azimuths[i], degrees[i] * kPi / 180.0, 1e-6);
        EXPECT_FLOAT_EQ(Value(profile, i, 1), expected[i]) << degrees[i];
    }
}

/// Of uneven steps too: what is at 0 degrees is what a line gives at 180.
TEST(IesProfileTest, HalvesOfUnevenStepsAreMirrored) {
    const IesProfile profile = Parse(FileOf("0 90", "90 120 200 270", "0 10 0 20 0 60 0 10", 2, 4));
    ASSERT_FLOAT_EQ(profile.azimuths.front(), 0.0F);
    EXPECT_FLOAT_EQ(Value(profile, 0, 1), 20.0F + 60.0F / 80.0F * 40.0F);
}

TEST(IesProfileTest, WholeCirclesEndWhereTheyBegin) {
    EXPECT_EQ(Parse(FileOf("0 90", "0 120 240 360", "1 2 3 4 5 6 1 2", 2, 4)).azimuths.size(), 4U);
    const IesProfile open = Parse(FileOf("0 90", "0 120 240", "1 2 3 4 5 6", 2, 3));
    ASSERT_EQ(open.azimuths.size(), 4U);
    EXPECT_FLOAT_EQ(Value(open, 3, 1), 2.0F);
}

/// Mean intensities in closed form: a constant; cos^1 as linear pieces is close to 1/2 of a
/// hemisphere; 1 - 2 polar / pi over the hemisphere has the mean 1 - 2 / pi.
TEST(IesProfileTest, MeanIntensity) {
    EXPECT_NEAR(Parse(FileOf("0 90 180", "0", "7 7 7", 3, 1)).MeanIntensity(), 7.0, 1e-6);
    EXPECT_NEAR(Parse(FileOf("0 90", "0", "7 7", 2, 1)).MeanIntensity(), 7.0, 1e-6)
        << "of a hemisphere";
    EXPECT_NEAR(Parse(FileOf("0 90", "0", "1 0", 2, 1)).MeanIntensity(), 1.0 - 2.0 / kPi, 1e-6);
    EXPECT_NEAR(Parse(FileOf("0 90 180", "0", "0 0 4", 3, 1)).MeanIntensity(),
                2.0 * (1.0 - 2.0 / kPi), 1e-6);
    EXPECT_NEAR(Parse(FileOf("0 90", "0 180", "1 1 3 3", 2, 2)).MeanIntensity(), 2.0, 1e-6);
}

TEST(IesProfileTest, TiltDataAreSkipped) {
    std::string text = FileOf("0 90", "0", "10 20", 2, 1);
    text.replace(text.find("TILT=NONE"), 9, "TILT=INCLUDE\n1\n3\n0 45 90\n1 0.9 0.8");
    EXPECT_FLOAT_EQ(Value(Parse(text), 0, 1), 20.0F);
}

TEST(IesProfileTest, BadFilesAreNamed) {
    const auto errorOf = [](const std::string& text) {
        std::string error;
        ParseIesProfile(text, &error);
        return error;
    };
    const std::string good = FileOf("0 90", "0", "10 20", 2, 1);
    EXPECT_EQ(errorOf(""), "it has no line TILT=");
    EXPECT_EQ(errorOf("\x89PNG\r\n"), "it has no line TILT=");
    EXPECT_EQ(errorOf("TILT=NONE\n1 2 3"), "its header is incomplete");
    EXPECT_EQ(errorOf("TILT=INCLUDE\n1 3 0"), "its TILT data are incomplete");
    EXPECT_EQ(errorOf(FileOf("0 90", "0", "10 20", 2, 1, "3")), "its photometric type is not C");
    EXPECT_EQ(errorOf(FileOf("0 90", "0", "10", 2, 1)),
              "it ends before its last value, or has a word among the values");
    EXPECT_EQ(errorOf(FileOf("0 90", "0", "10 nan", 2, 1)),
              "it ends before its last value, or has a word among the values");
    EXPECT_EQ(errorOf(FileOf("0 90", "0", "", 100000, 1)), "its header is incomplete");
    EXPECT_EQ(errorOf(FileOf("0 90", "0", "", 60000, 60000)),
              "its numbers of angles are out of range");
    EXPECT_EQ(errorOf(FileOf("90 0", "0", "10 20", 2, 1)),
              "its angles are not in ascending order, or out of range");
    EXPECT_EQ(errorOf(FileOf("0 90", "10 20", "1 2 3 4", 2, 2)),
              "its horizontal angles do not go from 0 to 0, 90, 180 or 360 degrees");
    const std::string tooClose = "its angles are not in ascending order, or out of range";
    EXPECT_EQ(errorOf(FileOf("0 1e-60 90", "0", "3 2 1", 3, 1)), tooClose);
    EXPECT_EQ(errorOf(FileOf("0 90", "0 180 180.000001", "1 2 3 4 5 6", 2, 3)), tooClose);
    EXPECT_EQ(errorOf(FileOf("0 90", "0", "1e39 1", 2, 1)), "its values are out of range");
    std::string endless = FileOf("0 90", "0", "1 0", 2, 1);
    endless.replace(endless.find("2.0"), 3, "1e300");
    endless.replace(endless.find("0.5"), 3, "1e300");
    EXPECT_EQ(errorOf(endless), "its values are out of range");
    for (std::size_t length = 0; length + 4 < good.size(); ++length) {
        EXPECT_NE(errorOf(good.substr(0, length)), "") << length; // cut anywhere
    }
}

} // namespace
} // namespace hds
