// SPDX-License-Identifier: Apache-2.0
#include "hdStream/film/deepImage.h"

#include "hdStream/base/error.h"
#include "hdStream/film/imageWriter.h"
#include "testenv/support/fileSizeLimit.h"
#include "testenv/support/temporaryFolder.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <limits>

namespace {

using hds::DeepHit;
using hds::DeepImage;
using hds::DeepLimits;
using hds::DeepSample;
using hds::DeepSums;

constexpr float kInfinity = std::numeric_limits<float>::infinity();

DeepHit Hit(std::uint32_t prim, float depth, float light = 1.0F, float alpha = 1.0F) {
    return {{prim, 0}, depth, {light, 2.0F * light, 0.0F, alpha}};
}

DeepSums MakeSums(const DeepLimits& limits, std::uint32_t width = 1) {
    DeepSums sums;
    sums.Reset(width, 1, limits);
    return sums;
}

/// Of four samples one on the first surface, two on the second, one on nothing: 1/4, then 2/3 of
/// what that leaves.
TEST(DeepImage, SamplesCoverWhatIsLeftByThoseBefore) {
    DeepSums sums = MakeSums({});
    sums.Add(0, Hit(7, 5.0F, 4.0F));
    sums.Add(0, Hit(3, 2.0F, 8.0F));
    sums.AddNothing(0);
    sums.Add(0, Hit(7, 5.01F, 2.0F));
    const DeepImage image = sums.Make();
    ASSERT_EQ(image.counts, std::vector<std::uint32_t>{2});
    const DeepSample& front = image.samples[0];
    const DeepSample& back = image.samples[1];
    EXPECT_EQ(front.z, 2.0F);
    EXPECT_EQ(front.zBack, 2.0F);
    EXPECT_EQ(front.color, (std::array<float, 4>{2.0F, 4.0F, 0.0F, 0.25F}));
    EXPECT_EQ(back.z, 5.0F);
    EXPECT_EQ(back.zBack, 5.01F);
    EXPECT_EQ(back.color, (std::array<float, 4>{2.0F, 4.0F, 0.0F, 2.0F / 3.0F}));
}

/// One surface in reach of its first sample is one; another surface never is.
TEST(DeepImage, ToleranceIsOfTheFirstSampleAndOfOneSurface) {
    DeepLimits limits;
    limits.tolerance = 0.1F;
    DeepSums sums = MakeSums(limits, 2);
    for (const float depth : {10.0F, 10.9F, 11.5F, 9.1F}) {
        sums.Add(0, Hit(1, depth));
        sums.Add(1, Hit(static_cast<std::uint32_t>(depth * 10.0F), depth));
    }
    const DeepImage image = sums.Make();
    EXPECT_EQ(image.counts, (std::vector<std::uint32_t>{2, 4}));
    EXPECT_EQ(image.samples[0].z, 9.1F);
    EXPECT_EQ(image.samples[0].zBack, 10.9F);
    EXPECT_EQ(image.samples[1].z, 11.5F);
}

/// A sample ends where the next one begins, and two that begin at one depth are one.
TEST(DeepImage, SamplesDoNotOverlap) {
    DeepLimits limits;
    limits.tolerance = 1.0F;
    DeepSums sums = MakeSums(limits);
    sums.Add(0, Hit(1, 4.0F));
    sums.Add(0, Hit(1, 8.0F));
    sums.Add(0, Hit(2, 6.0F));
    sums.Add(0, Hit(3, 6.0F, 3.0F));
    const DeepImage image = sums.Make();
    ASSERT_EQ(image.counts[0], 2U);
    EXPECT_EQ(image.samples[0].zBack, 6.0F);
    EXPECT_EQ(image.samples[1].z, 6.0F);
    EXPECT_EQ(image.samples[1].color, (std::array<float, 4>{2.0F, 4.0F, 0.0F, 1.0F}));
}

TEST(DeepImage, WhatHasNoDepthLiesAtTheFarEnd) {
    DeepLimits limits;
    limits.farDepth = 100.0F;
    DeepSums sums = MakeSums(limits);
    sums.Add(0, Hit(1, 50.0F));
    sums.Add(0, Hit(2, kInfinity, 3.0F, 0.0F));
    sums.Add(0, Hit(2, std::numeric_limits<float>::quiet_NaN(), 5.0F, 0.0F));
    const DeepImage image = sums.Make();
    ASSERT_EQ(image.counts[0], 2U);
    EXPECT_EQ(image.samples[1].z, 100.0F);
    EXPECT_EQ(image.samples[1].color, (std::array<float, 4>{4.0F, 8.0F, 0.0F, 0.0F}));
}

TEST(DeepImage, WhatHasNoRoomJoinsTheNearestAndIsCounted) {
    DeepLimits limits;
    limits.mostSamples = 2;
    DeepSums sums = MakeSums(limits);
    for (const std::uint32_t prim : {1U, 8U, 2U, 7U, 8U}) {
        sums.Add(0, Hit(prim, static_cast<float>(prim)));
    }
    EXPECT_EQ(sums.NumCrowded(), 2U);
    const DeepImage image = sums.Make();
    ASSERT_EQ(image.counts[0], 2U);
    EXPECT_EQ(image.samples[0].zBack, 2.0F);
    EXPECT_EQ(image.samples[0].color[3], 2.0F / 5.0F);
    EXPECT_EQ(image.samples[1].z, 7.0F);
    EXPECT_EQ(image.samples[1].color[3], 1.0F);
}

TEST(DeepImage, MemoryIsThatOfItsSamples) {
    DeepSums sums = MakeSums({}, 1000);
    EXPECT_EQ(sums.Bytes(), 8000U);
    constexpr std::uint32_t kPerPixel = 40;
    for (std::uint32_t pixel = 0; pixel < 1000; ++pixel) {
        for (std::uint32_t i = 0; i < kPerPixel; ++i) {
            sums.Add(pixel, Hit(i, 1.0F));
        }
    }
    EXPECT_GE(sums.Bytes(), 8000U + 56U * 1000U * kPerPixel);
    EXPECT_LE(sums.Bytes(), 8000U + 56U * (1000U * kPerPixel + (1U << 14U)));
}

/// OpenImageIO writes deep files by name: a disk that is full leaves the old file and nothing else.
TEST(DeepImage, AFullDiskLeavesTheOldFile) {
    const hds::test::TemporaryFolder folder;
    const std::string file = folder.File("out.exr");
    DeepSums sums = MakeSums({}, 500);
    for (std::uint32_t pixel = 0; pixel < 500; ++pixel) {
        sums.Add(pixel, Hit(1, 1.0F + static_cast<float>(pixel) / 7.0F));
    }
    hds::WriteDeepImage(file, sums.Make(), false, {});
    const auto bytes = std::filesystem::file_size(file);
    for (const unsigned limit : {20U, 900U}) { // inside the header, inside the pixels
        const hds::test::FileSizeLimit full(limit);
        EXPECT_THROW(hds::WriteDeepImage(file, sums.Make(), false, {}), hds::Error) << limit;
    }
    EXPECT_EQ(std::filesystem::file_size(file), bytes);
    EXPECT_EQ(folder.NumEntries(), 1U);
}

TEST(DeepImage, OnlyExrFilesAreDeep) {
    DeepSums sums = MakeSums({});
    EXPECT_THROW(hds::WriteDeepImage("never.png", sums.Make(), false, {}), hds::Error);
    EXPECT_THROW(hds::WriteDeepImage("never.exr", {}, false, {}), hds::Error);
}

} // namespace
