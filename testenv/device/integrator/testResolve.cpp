// SPDX-License-Identifier: Apache-2.0
// kernels/integrator/resolve.cl: samples that are not finite are counted, each once, and add black
// to the film. A pixel's first sample does not meet what the film has held before.
#include "kernels/shared/frame.h"
#include "testenv/support/deviceFixture.h"

#include <array>
#include <cmath>
#include <cstring>
#include <limits>

namespace hds::test {
namespace {

/// The radiance of a wave's paths, put there as shading would.
const char* const kSource = R"(
#include "integrator/resolve.cl"
kernel void injectRadiance(global uchar* state, uint numSlots, global const float4* values) {
    uint i = (uint)get_global_id(0);
    HdsPaths paths = {state, numSlots};
    path_store_radiance(paths, i, values[i]);
}
kernel void countFields(global uint* out) { *out = pathField_count; }
)";

constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
constexpr float kInfinity = std::numeric_limits<float>::infinity();
constexpr std::uint32_t kPixels = 5;
constexpr std::uint32_t kSamples = 4;
constexpr std::uint32_t kSlots = kPixels * kSamples;
using Radiance = std::array<float, 4>; // r, g, b, alpha

class ResolveTest : public DeviceFixture {
protected:
    /// The film after one wave of such samples; sets `counters`. \param before what the film has
    /// held. \param firstSample of the wave.
    std::vector<shared::HdsFilmPixel> Resolve(const std::vector<Radiance>& samples,
                                              const shared::HdsFilmPixel& before = {},
                                              std::uint32_t firstSample = 0) {
        const auto program = Build(kSource);
        const Buffer count = Allocate(sizeof(std::uint32_t));
        program->GetKernel("countFields").Launch(1, count);
        const std::uint64_t stateBytes = Download<std::uint32_t>(count, 1)[0] * 16ULL * kSlots;
        const Buffer paths = Allocate(stateBytes);
        const Buffer values = Upload(samples);
        const Buffer pixels = Upload(std::vector<std::uint32_t>{4, 2, 0, 1, 3});
        const Buffer film = Upload(std::vector<shared::HdsFilmPixel>(kPixels, before));
        const Buffer counts = Upload(std::vector<std::uint32_t>(HDS_NUM_COUNTERS, 0));
        program->GetKernel("injectRadiance").Launch(kSlots, paths, kSlots, values);
        const shared::HdsWave wave{0, kPixels, firstSample, kSamples};
        program->GetKernel("resolve_addSamples")
            .Launch(kPixels, wave, paths, kSlots, pixels, film, counts);
        counters = Download<std::uint32_t>(counts, HDS_NUM_COUNTERS);
        return Download<shared::HdsFilmPixel>(film, kPixels);
    }

    std::vector<std::uint32_t> counters;
};

TEST_F(ResolveTest, FiniteSamplesAreSummedAndNotCounted) {
    const auto film = Resolve(std::vector<Radiance>(kSlots, Radiance{1.0F, 2.0F, 0.5F, 1.0F}));
    EXPECT_EQ(counters, std::vector<std::uint32_t>(HDS_NUM_COUNTERS, 0));
    for (const shared::HdsFilmPixel& pixel : film) {
        EXPECT_EQ(pixel.numSamples, kSamples);
        EXPECT_EQ(pixel.blockSum.x, 4.0F);
        EXPECT_EQ(pixel.blockSum.y, 8.0F);
        EXPECT_EQ(pixel.blockSum.z, 2.0F);
        EXPECT_EQ(pixel.blockSum.w, 4.0F);
    }
}

TEST_F(ResolveTest, OnlyTheFirstSamplesBeginAnew) {
    const std::vector<Radiance> samples(kSlots, Radiance{1.0F, 2.0F, 0.5F, 1.0F});
    shared::HdsFilmPixel before{};
    before.sum = {32.0F, 8.0F, 4.0F, 16.0F};
    before.blockSum = {3.0F, 1.0F, 2.0F, 2.0F};
    before.luminanceSquares = 5.0F;
    before.blockLuminanceSquares = 6.0F;
    before.blockSquares = 7.0F;
    before.numSamples = 18;
    const auto black = Resolve(samples);
    const auto anew = Resolve(samples, before);
    const auto later = Resolve(samples, before, 18);
    for (std::uint32_t i = 0; i < kPixels; ++i) {
        EXPECT_EQ(std::memcmp(&anew[i], &black[i], sizeof(anew[i])), 0) << i;
        EXPECT_EQ(later[i].numSamples, 22U);
        EXPECT_EQ(later[i].sum.x, 32.0F);
        EXPECT_EQ(later[i].blockSum.x, 7.0F);
        EXPECT_EQ(later[i].blockSquares, 7.0F);
    }
}

TEST_F(ResolveTest, WhatIsNotFiniteIsCountedOnceASampleAndBlack) {
    std::vector<Radiance> samples(kSlots, Radiance{1.0F, 2.0F, 0.5F, 1.0F});
    // The first pixel of the list, 4: one of each kind, in one channel or in all.
    samples[0] = {kNan, 2.0F, 0.5F, 1.0F};
    samples[1] = {1.0F, kInfinity, 0.5F, 1.0F};
    samples[2] = {1.0F, 2.0F, -kInfinity, 1.0F};
    samples[3] = {kNan, kNan, kInfinity, kNan};
    // The fourth, 1: one among finite ones.
    samples[3 * kSamples + 2] = {1.0F, 2.0F, kNan, 1.0F};
    const auto film = Resolve(samples);
    EXPECT_EQ(counters[HDS_COUNTER_NAN], 5U);
    counters[HDS_COUNTER_NAN] = 0;
    EXPECT_EQ(counters, std::vector<std::uint32_t>(HDS_NUM_COUNTERS, 0)) << "no other counter";
    for (std::uint32_t i = 0; i < kPixels; ++i) {
        const shared::HdsFilmPixel& pixel = film[i];
        const float finite = i == 4 ? 0.0F : i == 1 ? 3.0F : 4.0F; // samples that count
        EXPECT_EQ(pixel.numSamples, kSamples) << "a black sample is one too";
        EXPECT_EQ(pixel.blockSum.x, finite) << i;
        EXPECT_EQ(pixel.blockSum.y, 2.0F * finite) << i;
        EXPECT_EQ(pixel.blockSum.z, 0.5F * finite) << i;
        EXPECT_EQ(pixel.blockSum.w, i == 4 ? 3.0F : 4.0F) << "alpha stays where it is finite";
        EXPECT_TRUE(std::isfinite(pixel.blockLuminanceSquares));
    }
}

} // namespace
} // namespace hds::test
