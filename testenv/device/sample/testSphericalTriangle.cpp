// SPDX-License-Identifier: Apache-2.0
// kernels/sample/sphericalTriangle.clh against double precision: solid angle and uniformity.
#include "testenv/support/deviceFixture.h"

#include <glm/geometric.hpp>
#include <glm/vec3.hpp>

#include <algorithm>
#include <cmath>
#include <random>

namespace hds::test {
namespace {

const char* const kSource = R"(
#include "sample/sphericalTriangle.clh"
kernel void sampleAll(global const float* triangles, global const float* us, global float* out,
                      uint count) {
    uint i = (uint)get_global_id(0);
    if (i >= count) return;
    HdsSphericalTriangle t = sphericalTriangle_make(vload3(3 * i, triangles),
                                                    vload3(3 * i + 1, triangles),
                                                    vload3(3 * i + 2, triangles));
    vstore4((float4)(sphericalTriangle_sample(&t, vload2(i, us)), t.solidAngle), i, out);
}
)";

/// The angle at corner `a` of a spherical triangle.
double CornerAngle(const glm::dvec3& a, const glm::dvec3& b, const glm::dvec3& c) {
    const glm::dvec3 ab = glm::cross(a, b);
    const glm::dvec3 ac = glm::cross(a, c);
    return std::atan2(glm::length(glm::cross(ab, ac)), glm::dot(ab, ac));
}

/// By the sum of the angles (Girard); corners of any length.
double SolidAngle(const glm::dvec3& a, const glm::dvec3& b, const glm::dvec3& c) {
    return CornerAngle(a, b, c) + CornerAngle(b, c, a) + CornerAngle(c, a, b) -
           3.14159265358979323846;
}

class SphericalTriangleTest : public DeviceFixture {};

TEST_F(SphericalTriangleTest, SamplesAreUniformInSolidAngle) {
    constexpr std::size_t kCount = 100000;
    std::mt19937 generator(22);
    std::uniform_real_distribution<double> uniform;
    const auto signedUnit = [&] { return 2.0 * uniform(generator) - 1.0; };
    std::vector<float> triangles;
    std::vector<float> us;
    for (std::size_t i = 0; i < kCount; ++i) {
        const double size = std::exp(3.0 * uniform(generator) - 1.5);
        const double height = std::exp(4.0 * uniform(generator) - 3.0);
        triangles.insert(triangles.end(),
                         {float(2.0 * signedUnit()), float(2.0 * signedUnit()), float(height)});
        for (int edge = 0; edge < 2; ++edge) {
            triangles.insert(triangles.end(),
                             {float(size * signedUnit()), float(size * signedUnit()),
                              float(0.5 * height * uniform(generator))});
        }
        us.push_back(float(uniform(generator) * 0.999));
        us.push_back(float(uniform(generator) * 0.999));
    }
    auto program = Build(kSource);
    const Buffer triangleBuffer = Upload(triangles);
    const Buffer uBuffer = Upload(us);
    const Buffer out = Allocate(kCount * 4 * sizeof(float));
    program->GetKernel("sampleAll")
        .Launch(kCount, triangleBuffer, uBuffer, out, std::uint32_t(kCount));
    const std::vector<float> samples = Download<float>(out, kCount * 4);
    std::size_t tested = 0;
    double worst[2] = {};
    for (std::size_t i = 0; i < kCount; ++i) {
        const float* t = &triangles[9 * i];
        const glm::dvec3 a(t[0], t[1], t[2]);
        const glm::dvec3 b = a + glm::dvec3(t[3], t[4], t[5]);
        const glm::dvec3 c = a + glm::dvec3(t[6], t[7], t[8]);
        const double total = SolidAngle(a, b, c);
        // Corners that lie almost opposite to each other lose most.
        ASSERT_NEAR(samples[4 * i + 3], total, 1e-6 + 5e-5 * total) << "triangle " << i;
        if (total < 0.005) { // a panel is sampled by area below twice that
            continue;
        }
        ++tested;
        const glm::dvec3 d(samples[4 * i], samples[4 * i + 1], samples[4 * i + 2]);
        ASSERT_NEAR(glm::length(d), 1.0, 1e-4);
        // Where the great circle through b and the direction meets the edge from a to c.
        const glm::dvec3 end = glm::cross(glm::cross(b, d), glm::cross(a, c));
        const glm::dvec3 onEdge =
            end * (glm::dot(end, glm::normalize(a) + glm::normalize(c)) > 0.0 ? 1.0 : -1.0);
        const double share = SolidAngle(a, b, onEdge) / total;
        const auto fromB = [&](const glm::dvec3& v) {
            return 1.0 - glm::dot(glm::normalize(b), glm::normalize(v));
        };
        worst[0] = std::max(worst[0], std::abs(share - us[2 * i]));
        worst[1] = std::max(worst[1], std::abs(fromB(d) / fromB(onEdge) - us[2 * i + 1]));
    }
    EXPECT_GT(tested, kCount / 2);
    EXPECT_LT(worst[0], 1e-3);
    EXPECT_LT(worst[1], 1e-3);
}

} // namespace
} // namespace hds::test
