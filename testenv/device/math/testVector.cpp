// SPDX-License-Identifier: Apache-2.0
// kernels/math/vector.clh against double precision.
#include "testenv/support/deviceFixture.h"

#include <cmath>
#include <cstring>
#include <random>

namespace hds::test {
namespace {

class VectorTest : public DeviceFixture {};

const char* const kSource = R"(
#include "math/vector.clh"
kernel void frames(global const float* normals, global float* out, uint count) {
    uint i = (uint)get_global_id(0);
    if (i >= count) return;
    HdsFrame frame = frame_fromNormal(vload3(i, normals));
    vstore3(frame.x, 3 * i, out);
    vstore3(frame.y, 3 * i + 1, out);
    vstore3(frame.z, 3 * i + 2, out);
}
kernel void normalizeAll(global const float* in, global float* out, uint count) {
    uint i = (uint)get_global_id(0);
    if (i < count) vstore3(vec_normalize(vload3(i, in)), i, out);
}
kernel void crossAll(global const float* a, global const float* b, global float* out, uint count) {
    uint i = (uint)get_global_id(0);
    if (i < count) vstore3(vec_cross(vload3(i, a), vload3(i, b)), i, out);
}
kernel void transforms(global const float* rows, global const float* points, global float* out,
                       uint count) {
    uint i = (uint)get_global_id(0);
    if (i >= count) return;
    HdsTransform m = transform_load(rows);
    float3 p = vload3(i, points);
    vstore3(transform_point(&m, p), 3 * i, out);
    vstore3(transform_vector(&m, p), 3 * i + 1, out);
    vstore3(transform_normal(&m, p), 3 * i + 2, out);
}
)";

std::vector<float> RandomUnitVectors(std::size_t count, unsigned seed) {
    std::mt19937 generator(seed);
    std::normal_distribution<double> normal;
    std::vector<float> out;
    for (std::size_t i = 0; i < count; ++i) {
        const double x = normal(generator);
        const double y = normal(generator);
        const double z = normal(generator);
        const double length = std::sqrt(x * x + y * y + z * z);
        out.insert(out.end(), {float(x / length), float(y / length), float(z / length)});
    }
    return out;
}

double Dot(const float* a, const float* b) {
    return double(a[0]) * b[0] + double(a[1]) * b[1] + double(a[2]) * b[2];
}

TEST_F(VectorTest, FramesAreOrthonormalAndRightHanded) {
    std::vector<float> normals = RandomUnitVectors(100000, 1);
    const float poles[4][3] = {{0, 0, 1}, {0, 0, -1}, {1, 0, 0}, {0, -1, -0.0F}};
    std::memcpy(normals.data(), poles, sizeof(poles));
    const std::uint32_t count = std::uint32_t(normals.size() / 3);
    auto program = Build(kSource);
    const Buffer in = Upload(normals);
    const Buffer out = Allocate(normals.size() * 3 * sizeof(float));
    program->GetKernel("frames").Launch(count, in, out, count);
    const std::vector<float> frames = Download<float>(out, normals.size() * 3);
    // Each entry has at most 3 roundings of values below 2: 6e-8 * 6.
    constexpr double kTolerance = 4e-7;
    for (std::size_t i = 0; i < count; ++i) {
        const float* x = &frames[i * 9];
        const float* y = x + 3;
        const float* z = x + 6;
        ASSERT_NEAR(Dot(x, x), 1.0, kTolerance);
        ASSERT_NEAR(Dot(y, y), 1.0, kTolerance);
        ASSERT_NEAR(Dot(x, y), 0.0, kTolerance);
        ASSERT_NEAR(Dot(x, z), 0.0, kTolerance);
        ASSERT_NEAR(Dot(y, z), 0.0, kTolerance);
        const double handed = z[0] * (double(x[1]) * y[2] - double(x[2]) * y[1]) +
                              z[1] * (double(x[2]) * y[0] - double(x[0]) * y[2]) +
                              z[2] * (double(x[0]) * y[1] - double(x[1]) * y[0]);
        ASSERT_NEAR(handed, 1.0, 3 * kTolerance);
    }
}

TEST_F(VectorTest, NormalizesAnyMagnitude) {
    const std::vector<float> in = {3e-38F,  4e-38F, 0, 3e38F, 0, -3e38F, 1e-20F, 2e-20F,
                                   -2e-20F, 0,      0, 0,     5, 0,      0};
    const std::uint32_t count = std::uint32_t(in.size() / 3);
    auto program = Build(kSource);
    const Buffer input = Upload(in);
    const Buffer out = Allocate(in.size() * sizeof(float));
    program->GetKernel("normalizeAll").Launch(count, input, out, count);
    const std::vector<float> unit = Download<float>(out, in.size());
    for (std::size_t i = 0; i < count; ++i) {
        const double length = std::sqrt(Dot(&in[i * 3], &in[i * 3]));
        for (std::size_t c = 0; c < 3; ++c) {
            const double expected = length > 0.0 ? in[i * 3 + c] / length : 0.0;
            EXPECT_NEAR(unit[i * 3 + c], expected, 3e-7) << "vector " << i;
        }
    }
}

TEST_F(VectorTest, CrossProductOfNearlyParallelVectorsIsAccurate) {
    std::vector<float> a = RandomUnitVectors(10000, 2);
    std::vector<float> b = a;
    std::mt19937 generator(3);
    for (float& value : b) {
        value *= 1.0F + 1e-5F * (float(generator() >> 8) * 0x1p-23F - 1.0F);
    }
    const std::uint32_t count = std::uint32_t(a.size() / 3);
    auto program = Build(kSource);
    const Buffer inA = Upload(a);
    const Buffer inB = Upload(b);
    const Buffer out = Allocate(a.size() * sizeof(float));
    program->GetKernel("crossAll").Launch(count, inA, inB, out, count);
    const std::vector<float> cross = Download<float>(out, a.size());
    for (std::size_t i = 0; i < count; ++i) {
        for (std::size_t c = 0; c < 3; ++c) {
            const std::size_t j = i * 3 + (c + 1) % 3;
            const std::size_t k = i * 3 + (c + 2) % 3;
            const double expected = double(a[j]) * b[k] - double(a[k]) * b[j];
            // Kahan: 1.5 ulp of the result; plain float would be off by 1e-8 / 1e-6 = 1 %.
            ASSERT_NEAR(cross[i * 3 + c], expected, std::abs(expected) * 2e-7 + 1e-38);
        }
    }
}

TEST_F(VectorTest, TransformsMapPointsVectorsAndNormals) {
    // Small integers: every product is exact, so are the results.
    const std::vector<float> rows = {1, 2, 0, 3, 0, 1, -1, 4, 2, 0, 1, -5};
    const std::vector<float> point = {1, -2, 3};
    auto program = Build(kSource);
    const Buffer m = Upload(rows);
    const Buffer p = Upload(point);
    const Buffer out = Allocate(9 * sizeof(float));
    program->GetKernel("transforms").Launch(1, m, p, out, std::uint32_t(1));
    // The point, the same as a vector, and by the transposed linear part.
    const std::vector<float> expected = {0, -1, 0, -3, -5, 5, 7, 0, 5};
    EXPECT_EQ(Download<float>(out, 9), expected);
}

} // namespace
} // namespace hds::test
