// SPDX-License-Identifier: Apache-2.0
// Radiometric meaning of UsdLux inputs.
#include "hdStream/shading/lightUnits.h"

#include <gtest/gtest.h>

#include <glm/gtc/matrix_transform.hpp>

#include <cmath>

namespace hds {
namespace {

constexpr double kPi = 3.14159265358979323846;

TEST(LightUnitsTest, BlackbodyEqualsUsdLux) {
    // UsdLuxBlackbodyTemperatureAsRgb of OpenUSD 24.08 at knots: table / luminance; below and above
    // its range the ends.
    const struct {
        double kelvin;
        glm::dvec3 table;
    } rows[] = {{1000.0, {1.0, 0.027490, 0.0}},       {500.0, {1.0, 0.027490, 0.0}},
                {3000.0, {1.0, 0.476725, 0.153601}},  {6500.0, {1.0, 0.942771, 0.991642}},
                {10000.0, {0.609681, 0.695588, 1.0}}, {20000.0, {0.609681, 0.695588, 1.0}}};
    for (const auto& row : rows) {
        const glm::dvec3 rgb = BlackbodyRgb(row.kelvin);
        const double luminance = 0.2126 * row.table.x + 0.7152 * row.table.y + 0.0722 * row.table.z;
        for (int c = 0; c < 3; ++c) {
            EXPECT_NEAR(rgb[c], row.table[c] / luminance, 1e-9) << row.kelvin;
        }
    }
}

TEST(LightUnitsTest, BlackbodyInterpolatesWithUnitLuminanceAndNoNegatives) {
    for (double kelvin = 1000.0; kelvin <= 10000.0; kelvin += 37.0) {
        const glm::dvec3 rgb = BlackbodyRgb(kelvin);
        EXPECT_GE(rgb.z, 0.0);
        const double luminance = 0.2126 * rgb.x + 0.7152 * rgb.y + 0.0722 * rgb.z;
        EXPECT_NEAR(luminance, 1.0, 1e-3) << kelvin; // clamped blues near 1300 K add a little
        EXPECT_LT(glm::length(rgb - BlackbodyRgb(kelvin + 1.0)), 0.02);
    }
    // Halfway between the knots of 3000 K and 3500 K: the Catmull-Rom weights (-1, 9, 9, -1) / 16.
    const glm::dvec3 sum =
        (-glm::dvec3(1.0, 0.372033, 0.067450) + 9.0 * glm::dvec3(1.0, 0.476725, 0.153601) +
         9.0 * glm::dvec3(1.0, 0.570376, 0.259196) - glm::dvec3(1.0, 0.653480, 0.377155)) /
        16.0;
    const glm::dvec3 expected = sum / (0.2126 * sum.x + 0.7152 * sum.y + 0.0722 * sum.z);
    EXPECT_LT(glm::length(BlackbodyRgb(3250.0) - expected), 1e-9);
}

TEST(LightUnitsTest, EmissionMultipliesItsFactors) {
    LightDescription light;
    light.intensity = 2.0F;
    light.exposure = 3.0F;
    light.color = {1.0F, 0.5F, 0.25F};
    EXPECT_EQ(LightEmission(light), glm::dvec3(16.0, 8.0, 4.0));
    light.colorTemperature = 3000.0F;
    EXPECT_EQ(LightEmission(light), glm::dvec3(16.0, 8.0, 4.0)) << "temperature is not enabled";
    light.enableColorTemperature = true;
    EXPECT_NEAR(LightEmission(light).y, 8.0 * BlackbodyRgb(3000.0).y, 1e-12);
}

TEST(LightUnitsTest, AreasOfScaledShapes) {
    const glm::dmat3 scale(2.0, 0.0, 0.0, 0.0, 3.0, 0.0, 0.0, 0.0, 3.0);
    LightDescription light;
    light.radius = 0.5F;
    light.length = 2.0F;
    light.width = 2.0F;
    light.height = 0.25F;
    light.type = LightType::Rect;
    EXPECT_DOUBLE_EQ(LightArea(light, scale), 0.5 * 6.0);
    light.type = LightType::Disk;
    EXPECT_DOUBLE_EQ(LightArea(light, scale), kPi * 0.25 * 6.0);
    light.type = LightType::Cylinder;
    EXPECT_NEAR(LightArea(light, scale), 2.0 * kPi * 1.5 * 4.0, 1e-9);
    light.type = LightType::Sphere;
    EXPECT_DOUBLE_EQ(LightArea(light, glm::dmat3(3.0)), 4.0 * kPi * 2.25);
    // Oblate spheroid a = 1.5 (y, z), c = 1 (x): 2 pi a^2 (1 + (1 - e^2) / e atanh e).
    const double e = std::sqrt(1.0 - 1.0 / 2.25);
    const double expected = 2.0 * kPi * 2.25 * (1.0 + (1.0 - e * e) / e * std::atanh(e));
    EXPECT_NEAR(LightArea(light, scale), expected, 1e-5 * expected);
    EXPECT_DOUBLE_EQ(LightArea(LightDescription{}, scale), 0.0); // distant
}

TEST(LightUnitsTest, DistantIrradianceIsTheProjectedSolidAngle) {
    EXPECT_DOUBLE_EQ(DistantIrradiance(0.0), 1.0);
    EXPECT_NEAR(DistantIrradiance(kPi / 2.0), kPi, 1e-12);
    EXPECT_NEAR(DistantIrradiance(kPi), 2.0 * kPi, 1e-12);
    EXPECT_NEAR(DistantIrradiance(0.1), kPi * std::pow(std::sin(0.1), 2.0), 1e-15);
    LightDescription light;
    light.angle = 720.0F;
    EXPECT_DOUBLE_EQ(DistantHalfAngle(light), kPi);
    light.angle = -5.0F;
    EXPECT_DOUBLE_EQ(DistantHalfAngle(light), 0.0);
}

} // namespace
} // namespace hds
