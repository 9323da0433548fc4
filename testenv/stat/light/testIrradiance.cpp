// SPDX-License-Identifier: Apache-2.0
// The irradiance from each type of light, at points and orientations, equals its closed form (or a
// double-precision quadrature where there is none) within 0.5 %: once by sampling the light, once
// by rays that happen to find it. So does the power that leaves a light.
#include "testenv/device/light/lightFixture.h"

#include <algorithm>
#include <cmath>

namespace hds::test {
namespace {

constexpr double kPi = 3.14159265358979323846;
constexpr double kTolerance = 0.005; // of the requirement
constexpr std::uint32_t kSamples = 1 << 18;

/// Radiance 1 + y.
LightImage GradientImage() {
    LightImage image;
    image.width = 128;
    image.height = 64;
    for (std::uint32_t y = 0; y < image.height; ++y) {
        const float value = float(1.0 + std::cos(kPi * (y + 0.5) / image.height));
        image.rgb.insert(image.rgb.end(), std::size_t(image.width) * 3, value);
    }
    return image;
}

class IrradianceTest : public LightFixture {
protected:
    void Expect(const std::string& name, const glm::dvec3& point, const glm::dvec3& normal,
                double expected, bool canGather = true) {
        const std::array<double, 3> value = IrradianceAt(point, normal);
        EXPECT_NEAR(value[0], expected, kTolerance * expected) << name << ", by light sampling";
        // Cosine-weighted rays find a light of irradiance E with probability E / (pi L): where that
        // is rare, 1 / sqrt(hits) of stratified rays is above the tolerance.
        if (canGather && expected > 0.02) {
            EXPECT_NEAR(value[1], expected, kTolerance * expected) << name << ", by gathering";
            EXPECT_NEAR(value[2], expected, kTolerance * expected) << name << ", by both";
        }
    }

    /// Light samples of such a light leave to others what they find as well.
    void ExpectTogether(const std::string& name, const glm::dvec3& point, const glm::dvec3& normal,
                        double expected) {
        const std::array<double, 3> value = IrradianceAt(point, normal);
        EXPECT_NEAR(value[1], expected, kTolerance * expected) << name << ", by gathering";
        EXPECT_NEAR(value[2], expected, kTolerance * expected) << name << ", by both";
    }

    /// Of a dome with GradientImage: as it is, and where light samples alone find it.
    void ExpectOfGradient(const std::string& name, PlacedLight dome, const glm::dvec3& n) {
        const glm::dvec3 normal = glm::normalize(n);
        const glm::dvec3 up(dome.worldFromLight[1]);
        const double expected = kPi + 2.0 * kPi / 3.0 * glm::dot(normal, up);
        SetLights({dome}, GradientImage());
        ExpectTogether(name, {0, 0, 0}, normal, expected);
        dome.light.shadow.color = {0.5F, 0.5F, 0.5F};
        SetLights({dome}, GradientImage());
        Expect(name + ", alone", {0, 0, 0}, normal, expected);
    }

private:
    std::array<double, 3> IrradianceAt(const glm::dvec3& point, const glm::dvec3& normal) {
        std::vector<float> points;
        std::vector<float> normals;
        Append(points, point);
        Append(normals, glm::normalize(normal));
        return Irradiance(points, normals, kSamples)[0];
    }
};

/// Sphere of radiance 1 wholly above the horizon: pi (r / d)^2 cos.
TEST_F(IrradianceTest, Sphere) {
    PlacedLight light = MakeLight(LightType::Sphere);
    light.light.radius = 0.5F;
    light.worldFromLight = glm::translate(glm::dmat4(1.0), {1.0, 2.0, 3.0});
    light.worldFromLight = glm::scale(light.worldFromLight, glm::dvec3(2.0));
    SetLights({light});
    for (const double d : {1.5, 4.0, 40.0}) {
        for (const double angle : {0.0, 0.6}) {
            const glm::dvec3 normal(std::sin(angle), 0.0, std::cos(angle));
            Expect("sphere", glm::dvec3(1.0, 2.0, 3.0 - d), normal,
                   kPi / (d * d) * std::cos(angle));
        }
    }
}

/// Enough lights for the light tree, and one at infinity: irradiances add up.
TEST_F(IrradianceTest, ManyLights) {
    std::vector<PlacedLight> lights;
    double expected = 0.5;
    for (int i = 0; i < 144; ++i) {
        PlacedLight light = MakeLight(LightType::Sphere);
        light.light.radius = 0.1F;
        light.light.intensity = float(1 + i % 7);
        const glm::dvec3 center(i % 12 - 4.0, i / 12 - 6.0, 0.5 + 0.1 * (i % 5));
        light.worldFromLight = glm::translate(glm::dmat4(1.0), center);
        lights.push_back(light);
        const double d = glm::length(center);
        expected += (1 + i % 7) * kPi * 0.01 / (d * d) * center.z / d;
    }
    lights.push_back(MakeLight(LightType::Distant)); // shines along -z
    lights.back().light.normalize = true;
    lights.back().light.intensity = 0.5F;
    SetLights(lights);
    Expect("144 spheres and a sun", {0, 0, 0}, {0, 0, 1}, expected, false);
}

/// Small spheres in a grid with beams of their own: as many as a tree needs, chosen by estimates
/// that know the beams. What a sphere of radius r sends at distance d differs from what its middle
/// would send by about (r / d)^2.
TEST_F(IrradianceTest, ManyShapedLights) {
    std::vector<PlacedLight> lights;
    double expected = 0.0;
    for (int i = 0; i < 100; ++i) {
        PlacedLight light = MakeLight(LightType::Sphere);
        light.light.radius = 0.02F;
        light.light.shaping.focus = float(i % 5) * 3.0F;
        light.light.shaping.coneAngle = i % 2 == 0 ? 180.0F : 75.0F;
        light.light.shaping.coneSoftness = 1.0F;
        const glm::dvec3 center(0.5 * (i % 10) - 2.0, 0.5 * (i / 10) - 2.5, 1.0 + 0.1 * (i % 3));
        light.worldFromLight = glm::rotate(glm::translate(glm::dmat4(1.0), center), 0.1 * (i % 7),
                                           glm::dvec3(1.0, 0.3, 0.0));
        lights.push_back(light);
        const double d = glm::length(center);
        const double cosine =
            glm::dot(-center / d, -glm::dvec3(light.worldFromLight[2])); // off the axis
        const double cutoff = light.light.shaping.coneAngle * kPi / 180.0;
        const double t = std::min(std::acos(cosine) / cutoff, 1.0);
        expected += (1.0 - t * t * (3.0 - 2.0 * t)) *
                    std::pow(std::abs(cosine), light.light.shaping.focus) * kPi * 0.0004 / (d * d) *
                    center.z / d;
    }
    SetLights(lights);
    Expect("100 beams", {0, 0, 0}, {0, 0, 1}, expected, false);
}

/// Horizon-clipped sphere. Source: Snyder 1996, "Area Light Sources for Real-Time Graphics", the
/// partly visible case, here by quadrature over the cone in double.
TEST_F(IrradianceTest, SphereThatIsPartlyBelowTheHorizon) {
    PlacedLight light = MakeLight(LightType::Sphere);
    light.light.radius = 1.0F;
    SetLights({light});
    const double d = 1.5;
    const double axisAngle = 1.3;
    double expected = 0.0;
    constexpr int kSteps = 1000;
    const double oneMinusCos = 1.0 - std::sqrt(1.0 - 1.0 / (d * d));
    for (int i = 0; i < kSteps; ++i) {
        const double c = 1.0 - oneMinusCos * (i + 0.5) / kSteps;
        for (int j = 0; j < kSteps; ++j) {
            const double phi = 2.0 * kPi * (j + 0.5) / kSteps;
            const double cosine = c * std::cos(axisAngle) +
                                  std::sqrt(1.0 - c * c) * std::cos(phi) * std::sin(axisAngle);
            expected += std::max(cosine, 0.0) * 2.0 * kPi * oneMinusCos / (double(kSteps) * kSteps);
        }
    }
    Expect("clipped sphere", {0.0, 0.0, -d}, {std::sin(axisAngle), 0.0, std::cos(axisAngle)},
           expected);
}

/// Disk of radius r seen from its axis at distance d: pi r^2 / (r^2 + d^2).
TEST_F(IrradianceTest, DiskOnItsAxis) {
    PlacedLight light = MakeLight(LightType::Disk);
    light.light.radius = 0.7F;
    light.worldFromLight = glm::rotate(glm::dmat4(1.0), 0.8, {1.0, 2.0, 0.5});
    SetLights({light});
    const glm::dvec3 axis(light.worldFromLight[2]);
    for (const double d : {0.1, 1.0, 10.0}) {
        const double r2 = double(0.7F) * 0.7F;
        Expect("disk", -d * axis, axis, kPi * r2 / (r2 + d * d));
    }
    Expect("behind a disk", axis, -axis, 0.0);
}

/// Parallel disk and point off the axis: Naraghi 1988, "Radiation View Factors from Differential
/// Plane Sources to Disks": F = (1 - (1 + h^2 - r^2) / sqrt((1 + h^2 + r^2)^2 - 4 r^2)) / 2 with
/// lengths in units of the offset.
TEST_F(IrradianceTest, DiskOffItsAxis) {
    PlacedLight light = MakeLight(LightType::Disk);
    light.light.radius = 1.0F;
    SetLights({light});
    const double offset = 1.6;
    const double h = 0.9 / offset;
    const double r = 1.0 / offset;
    const double root = std::sqrt(std::pow(1.0 + h * h + r * r, 2.0) - 4.0 * r * r);
    Expect("disk off axis", {offset, 0.0, -0.9}, {0, 0, 1},
           kPi * 0.5 * (1.0 - (1.0 + h * h - r * r) / root));
}

/// Form factor of a polygon from a point: Lambert's formula, the sum over edges of the angle times
/// the cosine between the normal and the edge's plane. Valid above the horizon.
double PolygonIrradiance(const std::vector<glm::dvec3>& corners, const glm::dvec3& point,
                         const glm::dvec3& normal) {
    double sum = 0.0;
    for (std::size_t i = 0; i < corners.size(); ++i) {
        const glm::dvec3 a = glm::normalize(corners[i] - point);
        const glm::dvec3 b = glm::normalize(corners[(i + 1) % corners.size()] - point);
        sum += std::acos(glm::dot(a, b)) * glm::dot(glm::normalize(glm::cross(a, b)), normal);
    }
    return std::abs(0.5 * sum);
}

std::vector<glm::dvec3> RectCorners(const PlacedLight& light) {
    std::vector<glm::dvec3> corners;
    const double x = 0.5 * light.light.width;
    const double y = 0.5 * light.light.height;
    for (const glm::dvec2& c :
         {glm::dvec2(-x, -y), glm::dvec2(x, -y), glm::dvec2(x, y), glm::dvec2(-x, y)}) {
        corners.emplace_back(light.worldFromLight * glm::dvec4(c, 0.0, 1.0));
    }
    return corners;
}

/// The unit normal of the corners' plane that points away from `point`.
glm::dvec3 PlaneNormal(const std::vector<glm::dvec3>& corners, const glm::dvec3& point) {
    const glm::dvec3 n =
        glm::normalize(glm::cross(corners[1] - corners[0], corners[3] - corners[0]));
    return glm::dot(n, corners[0] - point) > 0.0 ? n : -n;
}

TEST_F(IrradianceTest, Rect) {
    std::vector<glm::dmat4> transforms(3, glm::dmat4(1.0));
    transforms[1] = glm::scale(
        glm::rotate(glm::translate(transforms[1], {3.0, -2.0, 1.0}), 0.7, {1.0, 1.0, 0.2}),
        {2.0, 0.5, 3.0});
    transforms[2][1] = glm::dvec4(0.6, 1.2, 0.0, 0.0); // sheared: a parallelogram
    for (const glm::dmat4& m : transforms) {
        PlacedLight light = MakeLight(LightType::Rect);
        light.light.width = 1.5F;
        light.light.height = 0.8F;
        light.worldFromLight = m;
        SetLights({light});
        const std::vector<glm::dvec3> corners = RectCorners(light);
        for (const glm::dvec3& p : {glm::dvec3(0.1, 0.2, -0.3), glm::dvec3(1.0, -0.5, -2.0),
                                    glm::dvec3(3.0, 3.0, -30.0)}) {
            const glm::dvec3 point(m * glm::dvec4(p, 1.0));
            // Lambert's formula needs the whole rect above the horizon: near it, face its plane.
            const glm::dvec3 towards =
                p.z > -1.0 ? PlaneNormal(corners, point)
                           : glm::normalize(0.5 * (corners[0] + corners[2]) - point);
            Expect("rect", point, towards, PolygonIrradiance(corners, point, towards));
        }
        Expect("behind a rect", glm::dvec3(m * glm::dvec4(0.0, 0.0, 1.0, 1.0)), -glm::dvec3(m[2]),
               0.0);
    }
}

/// A strip of light below the bound of sampling by solid angle, along either side, seen from below
/// its middle, from beside its end and from far along it.
TEST_F(IrradianceTest, LongThinRect) {
    for (const bool isUpright : {false, true}) {
        PlacedLight light = MakeLight(LightType::Rect);
        light.light.width = isUpright ? 0.004F : 12.0F;
        light.light.height = isUpright ? 12.0F : 0.004F;
        SetLights({light});
        const std::vector<glm::dvec3> corners = RectCorners(light);
        for (const glm::dvec3& p : {glm::dvec3(0.5, 0.3, -1.5), glm::dvec3(6.2, -0.2, -0.3),
                                    glm::dvec3(20.0, 1.0, -2.0)}) {
            const glm::dvec3 point = isUpright ? glm::dvec3(p.y, p.x, p.z) : p;
            const glm::dvec3 towards = PlaneNormal(corners, point);
            Expect("strip", point, towards, PolygonIrradiance(corners, point, towards));
        }
    }
}

TEST_F(IrradianceTest, MeshLight) {
    // The same square as two triangles, on both sides.
    EmissiveMesh mesh;
    mesh.name = "/mesh";
    mesh.radiance = glm::dvec3(1.0);
    const glm::dvec3 c[4] = {{-1, -1, 5}, {1, -1, 5}, {1, 1, 5}, {-1, 1, 5}};
    mesh.triangles.push_back({{c[0], c[1], c[2]}, 0});
    mesh.triangles.push_back({{c[0], c[2], c[3]}, 1});
    for (const bool twoSided : {false, true}) {
        mesh.twoSided = twoSided;
        Warnings warnings;
        SetTable(BuildLightTable({}, {mesh}, {}, warnings));
        const std::vector<glm::dvec3> corners(c, c + 4);
        const glm::dvec3 front(0.5, 0.3, 7.0);
        const glm::dvec3 back(0.5, 0.3, 3.0);
        Expect("front", front, {0, 0, -1}, PolygonIrradiance(corners, front, {0, 0, -1}), false);
        Expect("back", back, {0, 0, 1},
               twoSided ? PolygonIrradiance(corners, back, {0, 0, 1}) : 0.0, false);
    }
}

TEST_F(IrradianceTest, Distant) {
    for (const double angle : {0.53, 20.0, 120.0}) {
        PlacedLight light = MakeLight(LightType::Distant);
        light.light.angle = float(angle);
        light.worldFromLight = glm::rotate(glm::dmat4(1.0), 0.5, {1.0, 0.0, 0.0});
        SetLights({light});
        const glm::dvec3 axis(light.worldFromLight[2]);
        const double sine = std::sin(0.5 * double(float(angle)) * kPi / 180.0);
        const double facing = kPi * sine * sine;
        Expect("distant facing", {5, 6, 7}, axis, facing);
        if (angle < 90.0) {
            const glm::dvec3 tilted =
                glm::normalize(axis + 0.5 * glm::dvec3(light.worldFromLight[0]));
            Expect("distant tilted", {5, 6, 7}, tilted, facing * glm::dot(tilted, axis));
        }
        light.light.normalize = true;
        SetLights({light});
        Expect("normalized distant", {5, 6, 7}, axis, 1.0, angle > 1.0);
    }
}

TEST_F(IrradianceTest, DeltaLights) {
    PlacedLight sun = MakeLight(LightType::Distant);
    sun.light.angle = 0.0F;
    sun.light.intensity = 3.0F;
    SetLights({sun});
    Expect("parallel sun", {0, 0, 0}, {0, 0, 1}, 3.0, false);

    PlacedLight point = MakeLight(LightType::Sphere);
    point.light.treatAsPoint = true;
    point.light.radius = 0.5F;
    SetLights({point});
    Expect("point of a sphere", {0, 0, -4}, {0, 0, 1}, kPi * 0.25 / 16.0, false);
    point.light.normalize = true;
    point.light.radius = 0.0F;
    SetLights({point});
    Expect("normalized point", {0, 0, -4}, {0, 0, 1}, 0.25 / 16.0, false);
}

TEST_F(IrradianceTest, UniformDome) {
    SetLights({MakeLight(LightType::Dome)});
    Expect("dome", {1, 2, 3}, {0.3, -0.5, 0.8}, kPi);
}

/// An image of radiance 1 + y (the light's up axis): irradiance pi + 2 pi / 3 n.y.
TEST_F(IrradianceTest, GradientDome) {
    PlacedLight light = MakeLight(LightType::Dome);
    light.light.textureFile.authoredPath = "dome.exr";
    light.worldFromLight = glm::rotate(glm::dmat4(1.0), 1.1, {1.0, 0.4, 0.3});
    for (const glm::dvec3& n : {glm::dvec3(0, 1, 0), glm::dvec3(0.6, -0.2, 0.4)}) {
        ExpectOfGradient("gradient dome", light, n);
    }
}

/// Light samples of a uniform dome find what comes through its portals, as from rects of radiance
/// 1; those of domes that need them for all of it, and where no portal is in front, all of it.
TEST_F(IrradianceTest, DomeWithPortals) {
    PlacedLight window = MakeLight(LightType::Rect); // towards -z
    window.light.width = 2.0F;
    window.worldFromLight = glm::translate(glm::dmat4(1.0), {1.0, 0.5, 2.0});
    PlacedLight skylight = window;
    skylight.light.height = 0.5F;
    skylight.worldFromLight =
        glm::rotate(glm::translate(glm::dmat4(1.0), {-1.5, 0.0, 1.5}), 0.6, {0.0, 1.0, 0.0});
    PlacedLight dome = MakeLight(LightType::Dome);
    double through = 0.0;
    const glm::dvec3 normal = glm::normalize(glm::dvec3(0.1, -0.2, 1.0));
    for (const PlacedLight& rect : {window, skylight}) {
        dome.portals.push_back({rect.worldFromLight, rect.light.width, rect.light.height});
        through += PolygonIrradiance(RectCorners(rect), glm::dvec3(0.0), normal);
    }
    SetLights({dome});
    Expect("two portals", {0, 0, 0}, normal, through, false);
    Expect("behind the portals", {0, 0, 5}, {0, 0, 1}, kPi);
    SetLights({dome, MakeLight(LightType::Dome)});
    Expect("two portals, and a dome without", {0, 0, 0}, normal, through, false);
    dome.light.shadow.color = {0.5F, 0.5F, 0.5F}; // found by light samples alone
    SetLights({dome});
    Expect("a dome that is only sampled", {0, 0, 0}, normal, kPi);
    dome.light.shadow.color = {0.0F, 0.0F, 0.0F};
    dome.light.textureFile.authoredPath = "dome.exr";
    SetLights({dome}, GradientImage());
    Expect("a dome with an image", {0, 0, 0}, normal, kPi + 2.0 * kPi / 3.0 * normal.y);
}

/// Portals choose among the cells of an image that they show: around the pole, over the seam of its
/// longitudes, several and overlapping, nearly half of the sphere, in a turned dome. The whole
/// image is found all the same.
TEST_F(IrradianceTest, DomeWithAnImageAndPortals) {
    const auto portal = [](const glm::dvec3& at, double angle, const glm::dvec3& axis, float size) {
        const glm::dmat4 placed = glm::rotate(glm::translate(glm::dmat4(1.0), at), angle, axis);
        return LightPortal{placed, size, 0.7F * size};
    };
    const LightPortal overhead = portal({0.3, 2.0, 0.1}, -0.5 * kPi, {1, 0, 0}, 3.0F);
    const LightPortal below = portal({-0.2, -1.0, 0.1}, 0.5 * kPi, {1, 0, 0}, 2.0F);
    const LightPortal seam = portal({0.2, 0.5, -1.5}, kPi, {0, 1, 0}, 2.0F);
    const LightPortal wide = portal({0.0, 0.0, 0.2}, 0.0, {0, 1, 0}, 40.0F);
    const LightPortal side = portal({2.0, 0.4, 0.3}, 0.4 * kPi, {0, 1, 0}, 1.0F);
    const std::pair<const char*, std::vector<LightPortal>> cases[] = {
        {"overhead", {overhead}},          {"below", {below}},
        {"at the seam", {seam}},           {"wide", {wide}},
        {"three", {overhead, seam, side}}, {"twice the same", {side, side}}};
    PlacedLight dome = MakeLight(LightType::Dome);
    dome.light.textureFile.authoredPath = "dome.exr";
    dome.worldFromLight = glm::rotate(glm::dmat4(1.0), 0.8, glm::dvec3(1.0, 0.3, 0.2));
    const glm::dvec3 up(dome.worldFromLight[1]);
    for (const auto& [name, portals] : cases) {
        dome.portals = portals;
        SetLights({dome}, GradientImage());
        for (const glm::dvec3& n : {glm::dvec3(0, 1, 0), glm::dvec3(0.1, -0.5, -1.0)}) {
            const glm::dvec3 normal = glm::normalize(n);
            Expect(name, {0, 0, 0}, normal, kPi + 2.0 * kPi / 3.0 * glm::dot(normal, up));
        }
    }
}

/// A rect with an image of two columns, 2 and 0, and rows of 1 and 3 times that: bright where +x
/// and -y of the light are. By midpoints over the light.
TEST_F(IrradianceTest, RectWithAnImage) {
    const LightImage image{2, 2, {2, 2, 2, 0, 0, 0, 6, 6, 6, 0, 0, 0}, 0};
    PlacedLight light = MakeLight(LightType::Rect);
    light.light.width = 1.6F;
    light.light.height = 0.8F;
    light.light.textureFile.authoredPath = "panel.exr";
    light.worldFromLight = glm::rotate(glm::dmat4(1.0), 0.7, {0.2, 1.0, 0.4});
    SetLights({light}, image);
    constexpr int kSteps = 800;
    const auto lerpAt = [](double c, double first, double second) {
        return glm::mix(first, second, glm::clamp(2.0 * c - 0.5, 0.0, 1.0));
    };
    for (const glm::dvec3& local : {glm::dvec3(0.5, -0.2, -0.3), glm::dvec3(-2.0, 1.0, -1.5)}) {
        for (const glm::dvec3& facing : {glm::dvec3(0, 0, 1), glm::dvec3(0.7, -0.3, 1.0)}) {
            const glm::dvec3 normal = glm::normalize(facing);
            double expected = 0.0;
            for (int i = 0; i < kSteps; ++i) {
                for (int j = 0; j < kSteps; ++j) {
                    const double s = (i + 0.5) / kSteps; // from +x
                    const double t = (j + 0.5) / kSteps; // from +y
                    const glm::dvec3 v = glm::dvec3(1.6 * (0.5 - s), 0.8 * (0.5 - t), 0.0) - local;
                    const double squared = glm::dot(v, v);
                    expected += lerpAt(s, 2.0, 0.0) * lerpAt(t, 1.0, 3.0) * v.z *
                                std::max(glm::dot(v, normal), 0.0) / (squared * squared);
                }
            }
            const glm::dmat3 turn(light.worldFromLight);
            Expect("rect with an image", turn * local, turn * normal,
                   expected * 1.6 * 0.8 / (kSteps * kSteps));
        }
    }
}

/// Irradiance of a one-sided surface by midpoints over its parameters.
template <typename Surface>
double QuadratureIrradiance(const Surface& surface, const glm::dvec3& point,
                            const glm::dvec3& normal) {
    constexpr int kSteps = 1000;
    double sum = 0.0;
    for (int i = 0; i < kSteps; ++i) {
        for (int j = 0; j < kSteps; ++j) {
            glm::dvec3 areaNormal; // outward, length: area per unit of the parameters
            const glm::dvec3 p = surface((i + 0.5) / kSteps, (j + 0.5) / kSteps, &areaNormal);
            const glm::dvec3 v = p - point;
            const double squared = glm::dot(v, v);
            const double emitted = -glm::dot(v, areaNormal);
            const double received = glm::dot(v, normal);
            if (emitted > 0.0 && received > 0.0) {
                sum += emitted * received / (squared * squared);
            }
        }
    }
    return sum / (double(kSteps) * kSteps);
}

TEST_F(IrradianceTest, CylinderAlsoScaledAndSheared) {
    std::vector<glm::dmat4> transforms(3, glm::dmat4(1.0));
    transforms[1] = glm::scale(glm::rotate(transforms[1], 0.9, {0.2, 1.0, 0.4}), {3.0, 0.5, 1.5});
    transforms[2][1] = glm::dvec4(0.4, 1.0, 0.2, 0.0);
    for (const glm::dmat4& m : transforms) {
        PlacedLight light = MakeLight(LightType::Cylinder);
        light.light.radius = 0.4F;
        light.light.length = 2.0F;
        light.worldFromLight = m;
        SetLights({light});
        const double radius = 0.4F;
        const auto surface = [&](double s, double t, glm::dvec3* areaNormal) {
            const double phi = 2.0 * kPi * s;
            const glm::dvec3 p(2.0 * t - 1.0, radius * std::cos(phi), radius * std::sin(phi));
            const glm::dvec3 alongPhi(0.0, -std::sin(phi), std::cos(phi));
            const glm::dmat3 linear(m);
            *areaNormal = glm::cross(linear * alongPhi, linear * glm::dvec3(1, 0, 0)) *
                          (2.0 * kPi * radius * 2.0);
            *areaNormal *= glm::dot(*areaNormal, linear * p) > 0.0 ? 1.0 : -1.0;
            return glm::dvec3(m * glm::dvec4(p, 1.0));
        };
        for (const glm::dvec3& q :
             {glm::dvec3(0.0, 0.0, -0.6), glm::dvec3(1.7, 0.5, -1.0), glm::dvec3(2.0, 9.0, 4.0)}) {
            const glm::dvec3 point(m * glm::dvec4(q, 1.0));
            const glm::dvec3 normal = glm::normalize(-point);
            Expect("cylinder", point, normal, QuadratureIrradiance(surface, point, normal));
        }
    }
}

TEST_F(IrradianceTest, Ellipsoid) {
    PlacedLight light = MakeLight(LightType::Sphere);
    light.light.radius = 1.0F;
    glm::dmat4 m = glm::scale(glm::rotate(glm::dmat4(1.0), 0.6, {1.0, 0.3, 0.5}), {2.0, 0.5, 1.0});
    light.worldFromLight = m;
    SetLights({light});
    const glm::dmat3 linear(m);
    const auto surface = [&](double s, double t, glm::dvec3* areaNormal) {
        const double z = 2.0 * s - 1.0;
        const double phi = 2.0 * kPi * t;
        const double r = std::sqrt(1.0 - z * z);
        const glm::dvec3 n(r * std::cos(phi), r * std::sin(phi), z);
        *areaNormal =
            glm::transpose(glm::inverse(linear)) * n * (4.0 * kPi * glm::determinant(linear));
        return linear * n;
    };
    for (const glm::dvec3& point :
         {glm::dvec3(0.0, 0.0, -3.0), glm::dvec3(3.0, 1.0, 0.5), glm::dvec3(-1.0, 1.6, 0.0)}) {
        const glm::dvec3 normal = glm::normalize(-point);
        Expect("ellipsoid", point, normal, QuadratureIrradiance(surface, point, normal));
    }
}

/// Radiance 1 leaves a surface of area A with power pi A: integrated over a sphere around the
/// light.
TEST_F(IrradianceTest, PowerThatLeavesALight) {
    const glm::dmat4 m =
        glm::scale(glm::rotate(glm::dmat4(1.0), 0.4, {0.5, 1.0, 0.2}), glm::dvec3(1.5));
    for (const LightType type :
         {LightType::Sphere, LightType::Rect, LightType::Disk, LightType::Cylinder}) {
        PlacedLight light = MakeLight(type);
        light.worldFromLight = m;
        light.light.normalize = true;
        light.light.intensity = 2.0F;
        SetLights({light});
        constexpr std::size_t kPoints = 5000;
        constexpr double kRadius = 4.0;
        std::vector<float> points;
        std::vector<float> normals;
        for (std::size_t i = 0; i < kPoints; ++i) {
            // A Fibonacci lattice: equal areas.
            const double z = 1.0 - (2.0 * double(i) + 1.0) / kPoints;
            const double phi = double(i) * kPi * (3.0 - std::sqrt(5.0));
            const double r = std::sqrt(1.0 - z * z);
            const glm::dvec3 d(r * std::cos(phi), r * std::sin(phi), z);
            Append(points, kRadius * d);
            Append(normals, -d);
        }
        double power = 0.0;
        for (const auto& irradiance : Irradiance(points, normals, 128)) {
            power += irradiance[0] * 4.0 * kPi * kRadius * kRadius / kPoints;
        }
        // Normalized: the power is pi times the intensity, whatever the size.
        EXPECT_NEAR(power, 2.0 * kPi, kTolerance * 2.0 * kPi) << "type " << int(type);
    }
}

} // namespace
} // namespace hds::test
