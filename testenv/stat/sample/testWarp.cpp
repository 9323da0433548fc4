// SPDX-License-Identifier: Apache-2.0
// Every map of kernels/sample follows the density it states: chi-square tests.
#include "testenv/stat/chiSquare.h"
#include "testenv/support/deviceFixture.h"

#include "hdStream/shading/pixelFilter.h"

#include <gtest/gtest-spi.h>

#include <algorithm>
#include <cmath>
#include <cstring>

namespace hds::test {
namespace {

constexpr std::size_t kNumSamples = 1000000;

const char* const kSource = R"(
#include "sample/filter.clh"
#include "sample/ggx.clh"
#include "sample/warp.clh"
kernel void disk(global const float* u, global float* out, uint count) {
    uint i = (uint)get_global_id(0);
    if (i < count) vstore3((float3)(warp_disk(vload2(i, u)), 0.0f), i, out);
}
kernel void triangle(global const float* u, global float* out, uint count) {
    uint i = (uint)get_global_id(0);
    if (i < count) vstore3((float3)(warp_triangle(vload2(i, u)), 0.0f), i, out);
}
kernel void cosine(global const float* u, global float* out, uint count) {
    uint i = (uint)get_global_id(0);
    if (i < count) vstore3(warp_cosineHemisphere(vload2(i, u)), i, out);
}
kernel void cosinePdf(global const float* d, global float* out, uint count) {
    uint i = (uint)get_global_id(0);
    if (i < count) out[i] = warp_cosineHemispherePdf(d[3 * i + 2]);
}
kernel void sphere(global const float* u, global float* out, uint count) {
    uint i = (uint)get_global_id(0);
    if (i < count) vstore3(warp_sphere(vload2(i, u)), i, out);
}
kernel void cone(global const float* u, float oneMinusCos, global float* out, uint count) {
    uint i = (uint)get_global_id(0);
    if (i < count) vstore3(warp_cone(vload2(i, u), oneMinusCos), i, out);
}
kernel void ggxNormal(global const float* u, float cosO, float alpha, global float* out, uint count) {
    uint i = (uint)get_global_id(0);
    float3 wo = (float3)(sqrt(1.0f - cosO * cosO), 0.0f, cosO);
    if (i < count) vstore3(ggx_sampleVisibleNormal(wo, alpha, vload2(i, u)), i, out);
}
kernel void ggxNormalPdf(global const float* d, float cosO, float alpha, global float* out,
                         uint count) {
    uint i = (uint)get_global_id(0);
    if (i >= count) return;
    float3 wo = (float3)(sqrt(1.0f - cosO * cosO), 0.0f, cosO);
    float3 h = vload3(i, d);
    out[i] = h.z > 0.0f ? ggx_distribution(h, alpha) * 2.0f * fmax(vec_dot(wo, h), 0.0f) *
                              ggx_masking(wo, alpha)
                        : 0.0f;
}
kernel void ggxReflection(global const float* u, float cosO, float alpha, global float* out,
                          uint count) {
    uint i = (uint)get_global_id(0);
    if (i >= count) return;
    float3 wo = (float3)(sqrt(1.0f - cosO * cosO), 0.0f, cosO);
    float3 h = ggx_sampleVisibleNormal(wo, alpha, vload2(i, u));
    float3 wi = vec_normalize(vec_mulAdd(2.0f * vec_dot(wo, h), h, -wo));
    /* Directions below the horizon are rejected. */
    vstore3(wi.z > 0.0f ? wi : (float3)(NAN), i, out);
}
kernel void ggxReflectionPdf(global const float* d, float cosO, float alpha, global float* out,
                             uint count) {
    uint i = (uint)get_global_id(0);
    if (i >= count) return;
    float3 wo = (float3)(sqrt(1.0f - cosO * cosO), 0.0f, cosO);
    float3 wi = vload3(i, d);
    out[i] = wi.z > 0.0f ? ggx_distribution(vec_normalize(wo + wi), alpha) * 0.5f *
                               ggx_masking(wo, alpha)
                         : 0.0f;
}
kernel void filterOffsets(global const float* u, global const float* inverseCdf, global float* out,
                          uint count) {
    uint i = (uint)get_global_id(0);
    if (i < count) vstore3((float3)(filter_sample2(inverseCdf, vload2(i, u)), 0.0f), i, out);
}
)";

class WarpTest : public DeviceFixture {
protected:
    void SetUp() override {
        DeviceFixture::SetUp();
        if (device) {
            _program = Build(kSource);
        }
    }
    template <typename... Args>
    std::vector<float> Sample(const char* kernel, unsigned seed, const Args&... args) {
        const Buffer us = Upload(RandomSquares(kNumSamples, seed));
        const Buffer out = Allocate(kNumSamples * 3 * sizeof(float));
        _program->GetKernel(kernel).Launch(kNumSamples, us, args..., out,
                                           std::uint32_t(kNumSamples));
        return Download<float>(out, kNumSamples * 3);
    }
    /// Densities over SphereDomain's square.
    template <typename... Args>
    std::vector<double> SphereDensities(const char* kernel, const Args&... args) {
        const std::vector<Square> points = DensityPoints();
        std::vector<float> directions(points.size() * 3);
        for (std::size_t i = 0; i < points.size(); ++i) {
            SphereDomain::FromSquare(points[i], &directions[i * 3]);
        }
        const Buffer in = Upload(directions);
        const Buffer out = Allocate(points.size() * sizeof(float));
        _program->GetKernel(kernel).Launch(points.size(), in, args..., out,
                                           std::uint32_t(points.size()));
        const std::vector<float> pdfs = Download<float>(out, points.size());
        std::vector<double> densities;
        for (std::size_t i = 0; i < points.size(); ++i) {
            densities.push_back(pdfs[i] * SphereDomain::Jacobian(points[i]));
        }
        return densities;
    }
    std::unique_ptr<Program> _program;
};

std::vector<Square> OnSphere(const std::vector<float>& directions) {
    std::vector<Square> squares;
    for (std::size_t i = 0; i < directions.size(); i += 3) {
        if (std::isnan(directions[i])) {
            continue;
        }
        const double d[3] = {directions[i], directions[i + 1], directions[i + 2]};
        squares.push_back(SphereDomain::ToSquare(d));
    }
    return squares;
}

const std::vector<double>& UniformDensities() {
    static const std::vector<double> densities(DensityPoints().size(), 1.0);
    return densities;
}

TEST_F(WarpTest, DiskIsUniform) {
    const std::vector<float> p = Sample("disk", 1);
    std::vector<Square> squares;
    for (std::size_t i = 0; i < p.size(); i += 3) {
        squares.push_back(DiskDomain::ToSquare(p[i], p[i + 1]));
    }
    ExpectChiSquare("disk", squares, kNumSamples, UniformDensities());
}

TEST_F(WarpTest, TriangleIsUniform) {
    const std::vector<float> p = Sample("triangle", 2);
    std::vector<Square> squares;
    for (std::size_t i = 0; i < p.size(); i += 3) {
        ASSERT_GE(std::min(p[i], p[i + 1]), 0.0F);
        ASSERT_LE(p[i] + p[i + 1], 1.0F);
        // The textbook's inverse: (1 - sqrt, share), uniform when the points are.
        const double rest = 1.0 - double(p[i]);
        squares.push_back({rest * rest, rest > 0.0 ? p[i + 1] / rest : 0.0});
    }
    ExpectChiSquare("triangle", squares, kNumSamples, UniformDensities());
}

TEST_F(WarpTest, CosineHemisphereFollowsItsDensity) {
    const std::vector<Square> squares = OnSphere(Sample("cosine", 3));
    ExpectChiSquare("cosine", squares, kNumSamples, SphereDensities("cosinePdf"));
}

TEST_F(WarpTest, SphereIsUniform) {
    std::vector<double> densities;
    for (const Square& s : DensityPoints()) {
        densities.push_back(SphereDomain::Jacobian(s) / (4.0 * SphereDomain::kPi));
    }
    ExpectChiSquare("sphere", OnSphere(Sample("sphere", 4)), kNumSamples, densities);
}

TEST_F(WarpTest, ConesAreUniformAlsoWhenNarrow) {
    // 2e-5 is the sun's cone; there 1 - cos is taken from the sine, which has the digits.
    unsigned seed = 5;
    for (const float k : {2e-9F, 2e-5F, 0.3F, 1.5F, 2.0F}) {
        const std::vector<float> d = Sample("cone", seed++, k);
        std::vector<Square> squares;
        for (std::size_t i = 0; i < d.size(); i += 3) {
            const double sine = std::hypot(double(d[i]), double(d[i + 1]));
            const double oneMinusCos = d[i + 2] > 0.5F
                                           ? 2.0 * std::pow(std::sin(0.5 * std::asin(sine)), 2.0)
                                           : 1.0 - double(d[i + 2]);
            squares.push_back({oneMinusCos / k * (1.0 - 1e-6),
                               DiskDomain::ToSquare(double(d[i]), double(d[i + 1]))[1]});
        }
        ExpectChiSquare("cone " + std::to_string(k), squares, kNumSamples, UniformDensities());
    }
}

TEST_F(WarpTest, GgxVisibleNormalsAndReflectionsFollowTheirDensities) {
    unsigned seed = 20;
    for (const float alpha : {0.15F, 0.4F, 1.0F}) {
        for (const float cosO : {0.15F, 0.5F, 1.0F}) {
            const std::string name =
                "alpha " + std::to_string(alpha) + ", cos " + std::to_string(cosO);
            ExpectChiSquare("normals, " + name, OnSphere(Sample("ggxNormal", seed++, cosO, alpha)),
                            kNumSamples, SphereDensities("ggxNormalPdf", cosO, alpha));
            ExpectChiSquare("reflections, " + name,
                            OnSphere(Sample("ggxReflection", seed++, cosO, alpha)), kNumSamples,
                            SphereDensities("ggxReflectionPdf", cosO, alpha));
        }
    }
}

TEST_F(WarpTest, PixelFiltersFollowTheirShape) {
    unsigned seed = 50;
    for (const char* name : {"blackmanHarris", "box"}) {
        const double width = std::strcmp(name, "box") == 0 ? 1.0 : 3.0;
        const std::vector<float> table = BuildPixelFilterTable(name, width);
        const Buffer tableBuffer = Upload(table);
        const std::vector<float> offsets = Sample("filterOffsets", seed++, tableBuffer);
        std::vector<Square> squares;
        for (std::size_t i = 0; i < offsets.size(); i += 3) {
            squares.push_back({offsets[i] / width + 0.5, offsets[i + 1] / width + 0.5});
        }
        // Integral of the window: its mean coefficient.
        const double mean = std::strcmp(name, "box") == 0 ? 1.0 : 0.35875;
        std::vector<double> densities;
        for (const Square& s : DensityPoints()) {
            densities.push_back(EvaluatePixelFilter(name, width, (s[0] - 0.5) * width) *
                                EvaluatePixelFilter(name, width, (s[1] - 0.5) * width) /
                                (mean * mean));
        }
        ExpectChiSquare(name, squares, kNumSamples, densities);
    }
}

TEST_F(WarpTest, TheHarnessRejectsAWrongDensity) {
    // Samples of the cosine hemisphere against a density that is 5 % too high at the pole and, with
    // the same total, 10 % too low at the horizon.
    const std::vector<Square> squares = OnSphere(Sample("cosine", 60));
    std::vector<double> densities = SphereDensities("cosinePdf");
    const std::vector<Square> points = DensityPoints();
    for (std::size_t i = 0; i < points.size(); ++i) {
        const double cosine = std::cos(SphereDomain::kPi * points[i][0]);
        densities[i] *= cosine > 0.0 ? 1.0 + 0.15 * (cosine - 2.0 / 3.0) : 0.0;
    }
    ::testing::TestPartResultArray failures;
    {
        ::testing::ScopedFakeTestPartResultReporter reporter(
            ::testing::ScopedFakeTestPartResultReporter::INTERCEPT_ALL_THREADS, &failures);
        ExpectChiSquare("deliberately wrong", squares, kNumSamples, densities);
    }
    EXPECT_GE(failures.size(), 1);
}

} // namespace
} // namespace hds::test
