// SPDX-License-Identifier: Apache-2.0
// surface_sample follows the density that surface_evaluate states: chi-square tests of mixtures of
// all lobes, also with a geometric normal that cuts directions off.
#include "testenv/device/shading/previewReference.h"
#include "testenv/stat/chiSquare.h"
#include "testenv/support/deviceFixture.h"

#include <cmath>
#include <string>

namespace hds::test {
namespace {

constexpr std::size_t kNumSamples = 1000000;

const char* const kKernels = R"(
kernel void sampleAll(global const float* parameters, global const float* geometry,
                      global const float* us, global float* out, uint count) {
    uint i = (uint)get_global_id(0);
    if (i >= count) return;
    HdsSurface s = unpackSurface(parameters, vload3(1, geometry));
    float3 wi;
    float pdf;
    surface_sample(&s, surface_lobeProbabilities(&s, geometry[2]), vload3(0, geometry),
                   vload2(i, us), &wi, &pdf);
    vstore3(pdf > 0.0f ? wi : (float3)(NAN), i, out);
}
kernel void pdfAll(global const float* parameters, global const float* geometry,
                   global const float* directions, global float* out, uint count) {
    uint i = (uint)get_global_id(0);
    if (i >= count) return;
    HdsSurface s = unpackSurface(parameters, vload3(1, geometry));
    float pdf;
    surface_evaluate(&s, surface_lobeProbabilities(&s, geometry[2]), vload3(0, geometry),
                     vload3(i, directions), &pdf);
    out[i] = pdf;
}
)";

class PreviewChiSquareTest : public DeviceFixture {
protected:
    void Check(const std::string& name, const PreviewParameters& parameters, double cosO,
               const glm::dvec3& geomNormal, unsigned seed) {
        auto program = Build(std::string(kUnpackSurface) + kKernels);
        const glm::dvec3 n = glm::normalize(geomNormal);
        const double sine = std::sqrt(1.0 - cosO * cosO);
        const Buffer packed = Upload(parameters.Pack());
        const Buffer geometry = Upload(
            std::vector<float>{float(sine), 0.0F, float(cosO), float(n.x), float(n.y), float(n.z)});
        const Buffer us = Upload(RandomSquares(kNumSamples * 2, seed));
        const Buffer out = Allocate(kNumSamples * 3 * sizeof(float));
        program->GetKernel("sampleAll")
            .Launch(kNumSamples, packed, geometry, us, out, std::uint32_t(kNumSamples));
        const std::vector<float> directions = Download<float>(out, kNumSamples * 3);
        std::vector<Square> samples;
        for (std::size_t i = 0; i < kNumSamples; ++i) {
            if (!std::isnan(directions[3 * i])) {
                const double d[3] = {directions[3 * i], directions[3 * i + 1],
                                     directions[3 * i + 2]};
                samples.push_back(SphereDomain::ToSquare(d));
            }
        }
        ExpectChiSquare(name, samples, kNumSamples, Densities(*program, packed, geometry));
    }

private:
    std::vector<double> Densities(const Program& program, const Buffer& packed,
                                  const Buffer& geometry) {
        const std::vector<Square> points = DensityPoints();
        std::vector<float> directions(points.size() * 3);
        for (std::size_t i = 0; i < points.size(); ++i) {
            SphereDomain::FromSquare(points[i], &directions[i * 3]);
        }
        const Buffer in = Upload(directions);
        const Buffer out = Allocate(points.size() * sizeof(float));
        program.GetKernel("pdfAll").Launch(points.size(), packed, geometry, in, out,
                                           std::uint32_t(points.size()));
        const std::vector<float> pdfs = Download<float>(out, points.size());
        std::vector<double> densities;
        for (std::size_t i = 0; i < points.size(); ++i) {
            densities.push_back(pdfs[i] * SphereDomain::Jacobian(points[i]));
        }
        return densities;
    }
};

TEST_F(PreviewChiSquareTest, MixturesFollowTheirDensity) {
    unsigned seed = 100;
    for (const double cosO : {0.2, 0.6, 1.0}) {
        PreviewParameters p;
        Check("default", p, cosO, {0, 0, 1}, seed++);
        p.diffuseColor = glm::dvec3(0.8);
        p.clearcoat = 0.6;
        p.clearcoatRoughness = 0.5;
        p.metallic = 0.3;
        Check("three lobes", p, cosO, {0, 0, 1}, seed++);
        p.isSpecularWorkflow = true;
        p.specularColor = glm::dvec3(0.5);
        p.opacity = 0.4;
        Check("specular workflow", p, cosO, {0, 0, 1}, seed++);
        p.isLambert = true;
        Check("lambert", p, cosO, {0, 0, 1}, seed++);
    }
}

TEST_F(PreviewChiSquareTest, DirectionsBelowTheGeometricSurfaceHaveNoDensity) {
    PreviewParameters p;
    p.clearcoat = 0.6;
    p.clearcoatRoughness = 0.5;
    // The cut runs along phi = 90 and 270 degrees, borders of bins.
    Check("cut", p, 0.8, {1.0, 0.0, 0.0}, 200);
}

} // namespace
} // namespace hds::test
