// SPDX-License-Identifier: Apache-2.0
// Camera rays against closed forms in double precision: the direction of each pixel in every
// projection, lenses that are in focus, lenses that change over the shutter, vignetting.
#include "hdStream/integrator/cameraFrame.h"
#include "testenv/support/deviceFixture.h"

#include <glm/geometric.hpp>
#include <glm/gtc/matrix_transform.hpp>

#include <cmath>
#include <functional>

namespace hds::test {
namespace {

const char* const kSource = R"(
#include "integrator/camera.clh"
kernel void rays(constant const HdsFrameParams* frame, global const float* in, global float* out,
                 uint count) {
    const uint i = (uint)get_global_id(0);
    if (i >= count) return;
    global const float* one = in + 5 * i;
    const HdsTransform pose = camera_pose(frame, one[4]);
    const HdsLens lens = camera_lens(frame, one[4]);
    const float2 point = camera_aperture(frame, vload2(1, one));
    const HdsCameraRay ray = camera_generate(frame, &pose, &lens, vload2(0, one), point);
    vstore3(ray.origin, 0, out + 10 * i);
    vstore3(ray.direction, 1, out + 10 * i);
    out[10 * i + 6] = ray.tMin;
    out[10 * i + 7] = ray.tMax;
    out[10 * i + 8] = ray.weight;
    out[10 * i + 9] = ray.cone.y;
}
kernel void project(constant const HdsFrameParams* frame, global const float* in,
                    global float* out, uint count) {
    const uint i = (uint)get_global_id(0);
    if (i < count) vstore2(lens_project(frame, vload3(i, in)), i, out);
}
)";

constexpr double kPi = 3.14159265358979323846;
constexpr std::uint32_t kWidth = 64;
constexpr std::uint32_t kHeight = 48;

/// A ray is asked for by a place on the picture, one on the lens and a time.
struct Wanted {
    float x, y, lensX = 0.5F, lensY = 0.5F, time = 0.0F;
};
struct Ray {
    glm::dvec3 origin, direction;
    double tMin, tMax, weight, cone;
};

RenderOptions Options() {
    RenderOptions options;
    options.imageWidth = kWidth;
    options.imageHeight = kHeight;
    options.displayWindow = {0.0, 0.0, double(kWidth), double(kHeight)};
    options.camera.horizontalAperture = 4.8F;
    options.camera.verticalAperture = 3.6F;
    options.camera.focalLength = 3.5F;
    options.camera.nearClip = 0.5F;
    options.camera.farClip = 100.0F;
    options.camera.worldFromCamera = glm::rotate(
        glm::translate(glm::dmat4(1.0), glm::dvec3(0.5, -0.25, 2.0)), 0.7, glm::dvec3(1, 2, 3));
    return options;
}

/// The middle of each pixel.
std::vector<Wanted> Middles() {
    std::vector<Wanted> all;
    for (std::uint32_t y = 0; y < kHeight; ++y) {
        for (std::uint32_t x = 0; x < kWidth; ++x) {
            all.push_back({float(x) + 0.5F, float(y) + 0.5F});
        }
    }
    return all;
}

class CameraTest : public DeviceFixture {
protected:
    std::vector<Ray> Rays(const RenderOptions& options, const std::vector<Wanted>& wanted) {
        const Buffer frame = Upload(
            std::vector<shared::HdsFrameParams>{MakeFrameParams(options, glm::dvec3(0.0), 0)});
        const Buffer in = Upload(wanted);
        const Buffer out = Allocate(wanted.size() * 10 * sizeof(float));
        auto program = Build(kSource);
        program->GetKernel("rays").Launch(wanted.size(), frame, in, out,
                                          std::uint32_t(wanted.size()));
        const auto numbers = Download<float>(out, wanted.size() * 10);
        std::vector<Ray> rays;
        for (std::size_t i = 0; i < wanted.size(); ++i) {
            const float* n = numbers.data() + 10 * i;
            rays.push_back({{n[0], n[1], n[2]}, {n[3], n[4], n[5]}, n[6], n[7], n[8], n[9]});
        }
        return rays;
    }

    /// At each time rays are those of a still camera with the lens and the film of that time.
    void ExpectTheLensOfEachTime(const RenderOptions& options);

    /// Film coordinates of directions in camera space.
    std::vector<float> Project(const RenderOptions& options, const std::vector<float>& points) {
        const Buffer frame = Upload(
            std::vector<shared::HdsFrameParams>{MakeFrameParams(options, glm::dvec3(0.0), 0)});
        const std::size_t count = points.size() / 3;
        const Buffer in = Upload(points);
        const Buffer out = Allocate(count * 2 * sizeof(float));
        Build(kSource)->GetKernel("project").Launch(count, frame, in, out, std::uint32_t(count));
        return Download<float>(out, count * 2);
    }
};

/// The direction in camera space of a point of the picture, its borders being 0 and 1 from the left
/// and from above; a zero vector where nothing is seen. Written apart from the kernels: with
/// inverse functions of the angle, in double precision.
glm::dvec3 Expected(const RenderOptions& options, double u, double v) {
    const CameraPrim& camera = options.camera;
    const CameraLens& lens = camera.lens;
    if (lens.projection == CameraProjection::Film) {
        return glm::normalize(glm::dvec3((u - 0.5) * double(camera.horizontalAperture),
                                         (0.5 - v) * double(camera.verticalAperture),
                                         -double(camera.focalLength)));
    }
    if (lens.projection == CameraProjection::Latlong) {
        const double longitude =
            (lens.longitudes[0] + u * (lens.longitudes[1] - lens.longitudes[0])) * kPi / 180.0;
        const double latitude =
            (lens.latitudes[1] + v * (lens.latitudes[0] - lens.latitudes[1])) * kPi / 180.0;
        return {std::sin(longitude) * std::cos(latitude), std::sin(latitude),
                -std::cos(longitude) * std::cos(latitude)};
    }
    const double x = (2.0 * u - 1.0) * kWidth / kHeight;
    const double y = 1.0 - 2.0 * v;
    const double radius = std::hypot(x, y);
    if (radius > 1.0) {
        return glm::dvec3(0.0);
    }
    const double half = 0.5 * double(lens.fieldOfView) * kPi / 180.0;
    const double angle = lens.projection == CameraProjection::FisheyeEquidistant ? radius * half
                         : lens.projection == CameraProjection::FisheyeEquisolid
                             ? 2.0 * std::asin(radius * std::sin(half / 2.0))
                             : 2.0 * std::atan(radius * std::tan(half / 2.0));
    return {std::sin(angle) * x / radius, std::sin(angle) * y / radius, -std::cos(angle)};
}

RenderOptions WithProjection(CameraProjection projection, float fieldOfView = 180.0F) {
    RenderOptions options = Options();
    options.camera.lens.projection = projection;
    options.camera.lens.fieldOfView = fieldOfView;
    return options;
}

std::vector<RenderOptions> AllProjections() {
    std::vector<RenderOptions> all{Options(), WithProjection(CameraProjection::Latlong)};
    all.push_back(all.back());
    all.back().camera.lens.longitudes = {-100.0F, 40.0F};
    all.back().camera.lens.latitudes = {-30.0F, 75.0F};
    for (const float degrees : {30.0F, 180.0F, 250.0F, 340.0F}) {
        all.push_back(WithProjection(CameraProjection::FisheyeEquidistant, degrees));
        all.push_back(WithProjection(CameraProjection::FisheyeEquisolid, degrees));
        all.push_back(WithProjection(CameraProjection::FisheyeStereographic, degrees));
    }
    all.push_back(WithProjection(CameraProjection::FisheyeEquisolid, 358.0F));
    return all;
}

TEST_F(CameraTest, EveryPixelLooksWhereTheClosedFormSays) {
    for (const RenderOptions& options : AllProjections()) {
        const glm::dmat3 turn(options.camera.worldFromCamera);
        const std::vector<Wanted> wanted = Middles();
        const std::vector<Ray> rays = Rays(options, wanted);
        std::size_t numSeen = 0;
        for (std::size_t i = 0; i < rays.size(); ++i) {
            const glm::dvec3 expected =
                turn * Expected(options, wanted[i].x / kWidth, wanted[i].y / kHeight);
            if (glm::length(expected) < 0.5) {
                ASSERT_EQ(rays[i].weight, 0.0);
                ASSERT_EQ(rays[i].tMax, 0.0) << "the ray sees nothing";
                continue;
            }
            ++numSeen;
            ASSERT_EQ(rays[i].weight, 1.0);
            ASSERT_LT(glm::distance(rays[i].direction, expected), 1e-6)
                << TextOf(options.camera.lens.projection) << " " << wanted[i].x << " "
                << wanted[i].y << " " << options.camera.lens.fieldOfView;
            ASSERT_LT(glm::distance(rays[i].origin, glm::dvec3(options.camera.worldFromCamera[3])),
                      1e-6);
            const bool isOnFilm = options.camera.lens.projection == CameraProjection::Film;
            const double cosine = isOnFilm ? -(glm::transpose(turn) * expected).z : 1.0;
            ASSERT_NEAR(rays[i].tMin * cosine, 0.5, 1e-5);
            ASSERT_NEAR(rays[i].tMax * cosine, 100.0, 1e-3);
        }
        EXPECT_GT(numSeen, rays.size() / 2);
    }
}

TEST_F(CameraTest, PointsAreSeenWhereTheirRaysComeFrom) {
    for (const RenderOptions& options : AllProjections()) {
        if (options.camera.lens.projection == CameraProjection::Film) {
            continue;
        }
        const shared::HdsFrameParams params = MakeFrameParams(options, glm::dvec3(0.0), 0);
        std::vector<float> points;
        std::vector<Wanted> seen;
        for (const Wanted& one : Middles()) {
            const glm::dvec3 d = Expected(options, one.x / kWidth, one.y / kHeight);
            if (glm::length(d) > 0.5) {
                seen.push_back(one);
                for (int axis = 0; axis < 3; ++axis) {
                    points.push_back(float(7.0 * d[axis]));
                }
            }
        }
        const std::vector<float> film = Project(options, points);
        for (std::size_t i = 0; i < seen.size(); ++i) {
            const double x = (film[2 * i] - params.filmOrigin[0]) / params.filmStep[0];
            const double y = (film[2 * i + 1] - params.filmOrigin[1]) / params.filmStep[1];
            ASSERT_NEAR(x, seen[i].x, 2e-3) << TextOf(options.camera.lens.projection);
            ASSERT_NEAR(y, seen[i].y, 2e-3);
        }
    }
}

/// All of the lens at a few places of the picture.
std::vector<Wanted> Lenses() {
    std::vector<Wanted> all;
    for (const float x : {20.5F, 32.0F, 40.25F}) {
        for (const float y : {12.0F, 30.5F}) {
            for (int u = 0; u < 9; ++u) {
                for (int v = 0; v < 9; ++v) {
                    all.push_back({x, y, float(u) / 9.0F, float(v) / 9.0F});
                }
            }
        }
    }
    return all;
}

TEST_F(CameraTest, RaysThroughTheLensMeetInFocus) {
    std::vector<RenderOptions> all = AllProjections();
    all.push_back(Options());
    all.back().camera.orthographic = true;
    for (RenderOptions& options : all) {
        for (const int blades : {0, 5}) {
            CameraPrim& camera = options.camera;
            camera.fStop = 4.0F;
            camera.focusDistance = 6.0F;
            camera.lens.apertureBlades = blades;
            camera.lens.apertureRatio = 2.0F;
            const std::vector<Wanted> wanted = Lenses();
            const std::vector<Ray> rays = Rays(options, wanted);
            RenderOptions pinhole = options;
            pinhole.camera.fStop = 0.0F;
            const std::vector<Ray> middles = Rays(pinhole, wanted);
            double widest = 0.0;
            for (std::size_t i = 0; i < rays.size(); ++i) {
                if (middles[i].weight == 0.0) {
                    continue;
                }
                const Ray& middle = middles[i];
                // A film has a plane of focus, a panorama a sphere.
                const double depth = middle.tMin / double(camera.nearClip);
                const glm::dvec3 focus = middle.origin + 6.0 * depth * middle.direction;
                const glm::dvec3 way = focus - rays[i].origin;
                ASSERT_LT(glm::length(glm::cross(way, rays[i].direction)), 2e-6 * glm::length(way));
                widest = std::max(widest, glm::distance(rays[i].origin, middle.origin));
                if (camera.lens.projection != CameraProjection::Film) {
                    const glm::dvec3 on = rays[i].origin - middle.origin;
                    ASSERT_NEAR(glm::dot(on, middle.direction), 0.0, 1e-6);
                }
            }
            EXPECT_GT(widest, 0.3);
            EXPECT_LE(widest, 0.4375 * (1.0 + 1e-6)); // 3.5 / 4 / 2
        }
    }
}

TEST_F(CameraTest, AnAnamorphicApertureIsNarrow) {
    RenderOptions options = Options();
    options.camera.worldFromCamera = glm::dmat4(1.0);
    options.camera.fStop = 2.0F;
    options.camera.focusDistance = 10.0F;
    options.camera.lens.apertureRatio = 2.5F;
    double x = 0.0;
    double y = 0.0;
    for (const Ray& ray : Rays(options, Lenses())) {
        x = std::max(x, std::abs(ray.origin.x));
        y = std::max(y, std::abs(ray.origin.y));
        EXPECT_LE(std::hypot(2.5 * ray.origin.x, ray.origin.y), 0.875 * (1.0 + 1e-6));
    }
    EXPECT_NEAR(x, 0.875 / 2.5, 0.004); // no sample lies on the very border
    EXPECT_NEAR(y, 0.875, 0.004);
}

TEST_F(CameraTest, VignettingIsTheFourthPowerOfTheCosine) {
    for (const float strength : {1.0F, 0.4F}) {
        RenderOptions options = Options();
        options.camera.lens.vignetting = strength;
        const std::vector<Ray> rays = Rays(options, Middles());
        const std::vector<Wanted> wanted = Middles();
        for (std::size_t i = 0; i < rays.size(); ++i) {
            const double cosine = -Expected(options, wanted[i].x / kWidth, wanted[i].y / kHeight).z;
            ASSERT_NEAR(rays[i].weight, 1.0 + strength * (std::pow(cosine, 4.0) - 1.0), 1e-6);
        }
        options.camera.orthographic = true;
        EXPECT_EQ(Rays(options, Middles())[0].weight, 1.0) << "its rays are all along the axis";
    }
}

void CameraTest::ExpectTheLensOfEachTime(const RenderOptions& options) {
    for (const double time : {-0.25, 0.1, 0.5, 0.75}) {
        RenderOptions still = options;
        still.shutter = {};
        still.camera.lensSamples.clear();
        const LensSample lens = LensAt(options.camera, time);
        still.camera.focalLength = lens.focalLength;
        still.camera.fStop = lens.fStop;
        still.camera.focusDistance = lens.focusDistance;
        still.camera.horizontalAperture = lens.horizontalAperture;
        still.camera.verticalAperture = lens.verticalAperture;
        still.camera.horizontalApertureOffset = lens.horizontalApertureOffset;
        still.camera.verticalApertureOffset = lens.verticalApertureOffset;
        std::vector<Wanted> wanted = Lenses();
        const std::vector<Ray> expected = Rays(still, wanted);
        for (Wanted& one : wanted) {
            one.time = float(time + 0.25);
        }
        const std::vector<Ray> found = Rays(options, wanted);
        for (std::size_t i = 0; i < found.size(); ++i) {
            ASSERT_LT(glm::distance(found[i].direction, expected[i].direction), 1e-3) << time;
            ASSERT_LT(glm::distance(found[i].origin, expected[i].origin), 1e-3) << time;
        }
    }
}

TEST_F(CameraTest, TheLensChangesOverTheShutter) {
    RenderOptions options = Options();
    options.shutter = {-0.25, 0.75};
    CameraPrim& camera = options.camera;
    camera.lensSamples = {{-1.0, 3.0F, 4.0F, 5.0F, 4.8F, 3.6F},
                          {0.0, 3.5F, 2.0F, 6.0F, 4.0F, 3.2F, 0.0F, 0.5F},
                          {1.0, 5.0F, 8.0F, 9.0F, 6.0F, 5.0F, -0.75F}};
    for (const bool isOrthographic : {false, true}) {
        camera.orthographic = isOrthographic;
        ExpectTheLensOfEachTime(options);
    }
    EXPECT_EQ(LensAt(camera, 0.5).focalLength, 4.25F);
    EXPECT_EQ(LensAt(camera, 0.5).verticalApertureOffset, 0.25F);
    EXPECT_EQ(LensAt(camera, 5.0).fStop, 8.0F);
    EXPECT_TRUE(LensChangesOver(camera, options.shutter));
    EXPECT_FALSE(LensChangesOver(camera, {1.0, 2.0}));
    EXPECT_FALSE(LensChangesOver(camera, {}));
}

TEST_F(CameraTest, OrdinaryCamerasNeedNoLensKernels) {
    RenderOptions options = Options();
    options.camera.fStop = 2.0F;
    options.camera.lens.apertureBlades = 2;
    options.camera.lensSamples = {{0.0, 3.0F, 2.0F, 5.0F}};
    EXPECT_FALSE(NeedsLensKernels(options.camera, {0.0, 1.0}));
    options.camera.lens.apertureBlades = 3;
    EXPECT_TRUE(NeedsLensKernels(options.camera, {}));
}

} // namespace
} // namespace hds::test
