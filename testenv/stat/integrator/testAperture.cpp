// SPDX-License-Identifier: Apache-2.0
// Apertures with blades are covered evenly, whatever their corners and their roundness: chi-square
// tests, with the border computed here from the polygon's own geometry.
#include "testenv/stat/chiSquare.h"
#include "testenv/support/deviceFixture.h"

#include "kernels/shared/frame.h"

namespace hds::test {
namespace {

constexpr std::size_t kNumSamples = 400000;
constexpr double kPi = 3.141592653589793;

const char* const kSource = R"(
#include "integrator/lens.clh"
kernel void aperture(constant const HdsFrameParams* frame, global const float* u,
                     global float* out, uint count) {
    uint i = (uint)get_global_id(0);
    if (i < count) vstore2(lens_aperture(frame, vload2(i, u)), i, out);
}
)";

class ApertureTest : public DeviceFixture {};

/// Distance of the border in a direction: of a polygon whose corners have distance 1, and which is
/// half of the way to the circle for a roundness of 0.5.
double Border(double angle, int blades, double roundness, double rotation) {
    const double step = 2.0 * kPi / blades;
    const double fromMiddle = std::remainder(angle - rotation, step);
    const double polygon = std::cos(0.5 * step) / std::cos(fromMiddle);
    return polygon + roundness * (1.0 - polygon);
}

TEST_F(ApertureTest, PointsAreEvenInsideOfTheBlades) {
    struct Case {
        int blades;
        float roundness, rotation;
    };
    for (const Case& one : {Case{3, 0.0F, 0.0F}, Case{5, 0.0F, 0.4F}, Case{5, 0.6F, -2.0F},
                            Case{6, 1.0F, 0.0F}, Case{8, 0.25F, 3.0F}}) {
        shared::HdsFrameParams params{};
        params.apertureBlades = std::uint32_t(one.blades);
        params.apertureRoundness = one.roundness;
        params.apertureRotation = one.rotation;
        const Buffer frame = Upload(std::vector<shared::HdsFrameParams>{params});
        const Buffer in = Upload(RandomSquares(kNumSamples, 7));
        const Buffer out = Allocate(kNumSamples * 2 * sizeof(float));
        auto program = Build(kSource);
        program->GetKernel("aperture")
            .Launch(kNumSamples, frame, in, out, std::uint32_t(kNumSamples));
        const auto points = Download<float>(out, kNumSamples * 2);
        std::vector<Square> samples;
        for (std::size_t i = 0; i < kNumSamples; ++i) {
            samples.push_back(DiskDomain::ToSquare(points[2 * i], points[2 * i + 1]));
            const double angle = std::atan2(double(points[2 * i + 1]), double(points[2 * i]));
            ASSERT_LT(std::sqrt(samples.back()[0]),
                      Border(angle, one.blades, one.roundness, one.rotation) + 2e-6);
        }
        double area = 0.0;
        constexpr int kSteps = 100000;
        for (int i = 0; i < kSteps; ++i) {
            const double border =
                Border(2.0 * kPi * (i + 0.5) / kSteps, one.blades, one.roundness, one.rotation);
            area += border * border * kPi / kSteps;
        }
        std::vector<double> densities;
        for (const Square& s : DensityPoints(kChiSquareFineSubdivisions)) {
            const double border = Border(2.0 * kPi * s[1], one.blades, one.roundness, one.rotation);
            densities.push_back(s[0] <= border * border ? DiskDomain::kJacobian / area : 0.0);
        }
        ExpectChiSquare(std::to_string(one.blades) + " blades, roundness " +
                            std::to_string(one.roundness),
                        samples, kNumSamples, densities);
    }
}

} // namespace
} // namespace hds::test
