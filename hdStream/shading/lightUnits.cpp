// SPDX-License-Identifier: Apache-2.0
// Radiometric meaning of UsdLux inputs.
#include "hdStream/shading/lightUnits.h"

#include <glm/geometric.hpp>
#include <glm/gtc/constants.hpp>
#include <glm/matrix.hpp>

#include <algorithm>
#include <cmath>

namespace hds {

namespace {

constexpr double kPi = 3.14159265358979323846;

/// Knots of UsdLuxBlackbodyTemperatureAsRgb: 1000 K to 10000 K in steps of 500 K, largest component
/// 1 (from J. Walker, "Colour Rendering of Spectra").
constexpr int kNumKnots = 19;
constexpr double kBlackbody[kNumKnots][3] = {
    {1.000000, 0.027490, 0.000000}, {1.000000, 0.149664, 0.000000}, {1.000000, 0.256644, 0.008095},
    {1.000000, 0.372033, 0.067450}, {1.000000, 0.476725, 0.153601}, {1.000000, 0.570376, 0.259196},
    {1.000000, 0.653480, 0.377155}, {1.000000, 0.726878, 0.501606}, {1.000000, 0.791543, 0.628050},
    {1.000000, 0.848462, 0.753228}, {1.000000, 0.898581, 0.874905}, {1.000000, 0.942771, 0.991642},
    {0.906947, 0.890456, 1.000000}, {0.828247, 0.841838, 1.000000}, {0.765791, 0.801896, 1.000000},
    {0.715255, 0.768579, 1.000000}, {0.673683, 0.740423, 1.000000}, {0.638992, 0.716359, 1.000000},
    {0.609681, 0.695588, 1.000000}};

/// Knots beyond the ends repeat the end.
glm::dvec3 Knot(int i) {
    const double* knot = kBlackbody[std::clamp(i, 0, kNumKnots - 1)];
    return {knot[0], knot[1], knot[2]};
}

/// Area of the image of a sphere: the mean of |cofactor(M) n| over unit normals, times 4 pi r^2.
/// Gauss-Legendre would be exact sooner, but midpoints in cos(theta) and phi are enough: the
/// integrand is smooth and the result is used to 6 digits.
double EllipsoidArea(const glm::dmat3& m, double radius) {
    const double s = glm::length(m[0]);
    const glm::dmat3 gram = glm::transpose(m) * m;
    const double skew = std::abs(gram[0][1]) + std::abs(gram[0][2]) + std::abs(gram[1][2]) +
                        std::abs(gram[1][1] - s * s) + std::abs(gram[2][2] - s * s);
    if (skew <= 1e-12 * s * s) {
        return 4.0 * kPi * radius * radius * s * s;
    }
    const glm::dmat3 cofactor(glm::cross(m[1], m[2]), glm::cross(m[2], m[0]),
                              glm::cross(m[0], m[1]));
    constexpr int kSteps = 512;
    double sum = 0.0;
    for (int i = 0; i < kSteps; ++i) {
        const double z = (i + 0.5) / kSteps * 2.0 - 1.0;
        const double r = std::sqrt(1.0 - z * z);
        for (int j = 0; j < kSteps; ++j) {
            const double phi = 2.0 * kPi * (j + 0.5) / kSteps;
            sum += glm::length(cofactor * glm::dvec3(r * std::cos(phi), r * std::sin(phi), z));
        }
    }
    return 4.0 * kPi * radius * radius * sum / (double(kSteps) * kSteps);
}

/// Lateral area of the image of a cylinder about x.
double CylinderArea(const glm::dmat3& m, double radius, double length) {
    constexpr int kSteps = 4096;
    double sum = 0.0;
    for (int i = 0; i < kSteps; ++i) {
        const double phi = 2.0 * kPi * (i + 0.5) / kSteps;
        sum += glm::length(glm::cross(m[0], -std::sin(phi) * m[1] + std::cos(phi) * m[2]));
    }
    return 2.0 * kPi * radius * length * sum / kSteps;
}

} // namespace

glm::dvec3 BlackbodyRgb(double kelvin) {
    const double position = std::clamp((kelvin - 1000.0) / 500.0, 0.0, double(kNumKnots - 1));
    const int segment = int(std::floor(position));
    const double t = position - segment;
    const glm::dvec3 p0 = Knot(segment - 1);
    const glm::dvec3 p1 = Knot(segment);
    const glm::dvec3 p2 = Knot(segment + 1);
    const glm::dvec3 p3 = Knot(segment + 2);
    const glm::dvec3 tangent1 = 0.5 * (p2 - p0);
    const glm::dvec3 tangent2 = 0.5 * (p3 - p1);
    const double t2 = t * t;
    const double t3 = t2 * t;
    glm::dvec3 rgb = (2.0 * t3 - 3.0 * t2 + 1.0) * p1 + (t3 - 2.0 * t2 + t) * tangent1 +
                     (3.0 * t2 - 2.0 * t3) * p2 + (t3 - t2) * tangent2;
    rgb /= glm::dot(rgb, glm::dvec3(0.2126, 0.7152, 0.0722));
    return glm::max(rgb, glm::dvec3(0.0));
}

bool IsFading(const LightShadow& shadow) {
    return shadow.enable && shadow.distance > 0.0F && shadow.falloff > 0.0F;
}

float LightFactor(float value) {
    return std::isfinite(value) ? std::max(value, 0.0F) : 0.0F;
}

glm::dvec3 LightEmission(const LightDescription& light) {
    glm::dvec3 emission(light.color[0], light.color[1], light.color[2]);
    emission *= double(light.intensity) * std::exp2(double(light.exposure));
    if (light.enableColorTemperature) {
        emission *= BlackbodyRgb(light.colorTemperature);
    }
    return emission;
}

double LightArea(const LightDescription& light, const glm::dmat3& worldFromLight) {
    const glm::dmat3& m = worldFromLight;
    const double radius = light.radius;
    switch (light.type) {
    case LightType::Sphere:
        return EllipsoidArea(m, radius);
    case LightType::Rect:
        return glm::length(glm::cross(m[0], m[1])) * light.width * light.height;
    case LightType::Disk:
        return glm::length(glm::cross(m[0], m[1])) * kPi * radius * radius;
    case LightType::Cylinder:
        return CylinderArea(m, radius, light.length);
    default:
        return 0.0;
    }
}

double DistantHalfAngle(const LightDescription& light) {
    return std::clamp(double(light.angle) * 0.5 * kPi / 180.0, 0.0, kPi);
}

double DistantIrradiance(double halfAngle) {
    if (!(halfAngle > 0.0)) {
        return 1.0;
    }
    const double sine = std::sin(halfAngle);
    return kPi * (halfAngle <= 0.5 * kPi ? sine * sine : 2.0 - sine * sine);
}

shared::HdsLightControls LightControls(const LightDescription& description) {
    const LightShadow& shadow = description.shadow;
    shared::HdsLightControls controls{};
    controls.diffuse = LightFactor(description.diffuse);
    controls.specular = LightFactor(description.specular);
    controls.shadowDistance = !shadow.enable            ? 0.0F
                              : shadow.distance >= 0.0F ? shadow.distance
                                                        : HDS_LIGHT_FAR;
    controls.shadowFade =
        IsFading(shadow) ? 1.0F / std::min(shadow.falloff, shadow.distance) : 0.0F;
    controls.shadowGamma = LightFactor(shadow.falloffGamma);
    for (int i = 0; i < 3; ++i) {
        controls.shadowColor[i] = LightFactor(shadow.color[i]);
    }
    return controls;
}

} // namespace hds
