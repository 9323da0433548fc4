// SPDX-License-Identifier: Apache-2.0
// kernels/texture/rayCone.clh: widths along paths against geometry, footprints against the plane
// they lie in, curvature of spheres.
#include "testenv/support/deviceFixture.h"

#include <glm/glm.hpp>

#include <cmath>
#include <random>

namespace hds::test {
namespace {

const char* const kSource = R"(
#include "texture/rayCone.clh"
/* Camera, first hit at t0, reflection with curvature and pdf, second hit at t1. */
kernel void path(global const float* in, global float* out, uint count) {
    uint i = (uint)get_global_id(0);
    if (i >= count) return;
    global const float* a = in + 6 * i;
    HdsRayCones cones = cones_atHit(cones_begin(a[0], a[1]), a[2], true);
    out[3 * i] = cones_width(cones);
    cones = cones_reflect(cones, a[3], a[4]);
    out[3 * i + 1] = cones_width(cones_atHit(cones, a[5], false));
    out[3 * i + 2] = cones_width(cones_atHit(cones_unpack(cones_pack(cones)), a[5], false));
}
kernel void footprints(global const float* in, global float4* out, uint count) {
    uint i = (uint)get_global_id(0);
    if (i >= count) return;
    global const float* a = in + 10 * i;
    out[i] = cones_footprint(a[0], vload3(0, a + 1), vload3(0, a + 4), vload3(0, a + 7));
}
kernel void curvatures(global const float* in, global float* out, uint count) {
    uint i = (uint)get_global_id(0);
    if (i >= count) return;
    global const float* a = in + 12 * i;
    out[i] = cones_curvature(vload3(0, a), vload3(0, a + 3), vload3(0, a + 6), vload3(0, a + 9));
}
)";

class RayConeTest : public DeviceFixture {
protected:
    std::vector<float> Run(const char* kernel, const std::vector<float>& in, std::size_t numIn,
                           std::size_t numOut) {
        auto program = Build(kSource);
        const std::size_t count = in.size() / numIn;
        const Buffer input = Upload(in);
        const Buffer out = Allocate(count * numOut * sizeof(float));
        program->GetKernel(kernel).Launch(count, input, out, std::uint32_t(count));
        return Download<float>(out, count * numOut);
    }
};

constexpr float kSharp = 1e8F; ///< density of a mirror: no scattering

TEST_F(RayConeTest, WidthsFollowThePath) {
    const float angle = 1e-3F;
    const std::vector<float> found = Run("path", {0.0F,  angle, 10.0F, 0.0F, kSharp, 5.0F, //
                                                  0.0F,  angle, 10.0F, 0.5F, kSharp, 5.0F, //
                                                  0.02F, 0.0F,  10.0F, 0.0F, kSharp, 5.0F, //
                                                  0.0F,  angle, 10.0F, 0.0F, 0.0F,   5.0F},
                                         6, 3);
    EXPECT_NEAR(found[0], 0.01, 1e-7) << "a pixel at distance 10";
    EXPECT_NEAR(found[1], 0.015, 1e-6) << "a plane mirror";
    EXPECT_NEAR(found[2], found[1], 1e-4) << "packed";
    // A convex mirror of radius 2: its normals turn by 0.01 / 2 over the footprint, rays by twice.
    EXPECT_NEAR(found[4], 0.01 + (angle + 2 * 0.5 * 0.01) * 5.0, 1e-6);
    EXPECT_NEAR(found[6], 0.02, 1e-7) << "orthographic";
    EXPECT_NEAR(found[7], 0.02, 1e-6);
    EXPECT_NEAR(found[10], 0.01 + (angle + 0.25) * 5.0, 1e-5) << "a diffuse bounce";
}

TEST_F(RayConeTest, AFocusIsNeverAPoint) {
    // A concave mirror of focal length 2 images the camera, at distance 10, to 2.5.
    std::vector<float> in;
    for (int i = 0; i < 200; ++i) {
        in.insert(in.end(), {0.0F, 1e-3F, 10.0F, -0.25F, kSharp, 0.05F * float(i)});
    }
    const std::vector<float> found = Run("path", in, 6, 3);
    for (std::size_t i = 0; i < 200; ++i) {
        const double t = 0.05 * double(i);
        const double exact = std::abs(0.01 + (1e-3 - 0.5 * 0.01) * t);
        EXPECT_GE(found[3 * i + 1], 0.999 * exact) << "at least the image of the pixel";
        EXPECT_GT(found[3 * i + 1], 1e-3) << "distance " << t;
    }
}

TEST_F(RayConeTest, FootprintsAreTheConesCutByThePlane) {
    std::mt19937 generator(9);
    std::normal_distribution<double> normal;
    const auto vector = [&] {
        return glm::dvec3(normal(generator), normal(generator), normal(generator));
    };
    std::vector<float> in;
    std::vector<std::array<glm::dvec3, 3>> cases;
    for (int i = 0; i < 1000; ++i) {
        const glm::dvec3 e1 = vector();
        const glm::dvec3 e2 = vector();
        const glm::dvec3 n = glm::normalize(glm::cross(e1, e2));
        const glm::dvec3 d = i % 10 == 0 ? n : glm::normalize(vector());
        cases.push_back({e1, e2, d});
        in.push_back(0.125F);
        for (const glm::dvec3& v : {e1, e2, d}) {
            in.insert(in.end(), {float(v.x), float(v.y), float(v.z)});
        }
    }
    const std::vector<float> found = Run("footprints", in, 10, 4);
    for (std::size_t i = 0; i < cases.size(); ++i) {
        const auto& [e1, e2, d] = cases[i];
        const glm::dvec3 n = glm::normalize(glm::cross(e1, e2));
        const double cosine = std::abs(glm::dot(d, n));
        if (cosine < 0.02 || glm::length(glm::cross(e1, e2)) < 0.1) {
            continue; // slivers and grazing rays lose digits
        }
        const float* f = &found[4 * i];
        const glm::dvec3 major = double(f[0]) * e1 + double(f[1]) * e2;
        const glm::dvec3 minor = double(f[2]) * e1 + double(f[3]) * e2;
        EXPECT_NEAR(glm::length(major) * cosine, 0.125, 1e-3);
        EXPECT_NEAR(glm::length(minor), 0.125, 1e-3);
        EXPECT_NEAR(glm::dot(minor, d), 0.0, 1e-3);
        // Seen along the ray the ellipse is a circle.
        const glm::dvec3 seen = major - glm::dot(major, d) * d;
        EXPECT_NEAR(glm::length(seen), 0.125, 2e-3);
    }
    for (const float value : Run("footprints", {1, 1, 0, 0, 2, 0, 0, 0, 0, 1}, 10, 4)) {
        EXPECT_EQ(value, 0.0F) << "a triangle without area";
    }
}

TEST_F(RayConeTest, CurvatureOfASphereIsOneOverItsRadius) {
    std::vector<float> in;
    const auto add = [&](const std::array<glm::dvec3, 4>& v) {
        for (const glm::dvec3& one : v) {
            in.insert(in.end(), {float(one.x), float(one.y), float(one.z)});
        }
    };
    const double radius = 4.0;
    const glm::dvec3 n[3] = {glm::normalize(glm::dvec3(0.1, 0.2, 1.0)),
                             glm::normalize(glm::dvec3(0.3, 0.1, 1.0)),
                             glm::normalize(glm::dvec3(0.2, 0.5, 1.0))};
    for (const double sign : {1.0, -1.0}) {
        add({radius * (n[1] - n[0]), radius * (n[2] - n[0]), sign * (n[1] - n[0]),
             sign * (n[2] - n[0])});
    }
    add({glm::dvec3(1, 0, 0), glm::dvec3(0, 1, 0), glm::dvec3(0.1, 0, 0), glm::dvec3(0, -0.1, 0)});
    add({glm::dvec3(0), glm::dvec3(0), glm::dvec3(0.1), glm::dvec3(0.1)});
    const std::vector<float> found = Run("curvatures", in, 12, 1);
    EXPECT_NEAR(found[0], 0.25, 1e-5);
    EXPECT_NEAR(found[1], -0.25, 1e-5);
    EXPECT_EQ(found[2], 0.0F) << "a saddle";
    EXPECT_EQ(found[3], 0.0F);
}

} // namespace
} // namespace hds::test
