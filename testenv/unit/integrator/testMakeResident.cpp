// SPDX-License-Identifier: Apache-2.0
// Geometry is made resident when what that saves is at least what it costs, and not before.
#include "hdStream/integrator/flatGeometry.h"
#include "hdStream/integrator/makeResident.h"
#include "hdStream/integrator/residencyPlan.h"

#include <gtest/gtest.h>

namespace hds::test {
namespace {

TEST(MakeResident, WhatCostsNothingIsWorthIt) {
    EXPECT_TRUE(IsWorthMakingResident({}));
}

TEST(MakeResident, KernelsAreBuiltForLongRendersOnly) {
    MakeResidentCosts costs;
    costs.secondsLeft = 60.0;
    costs.kernelSeconds = kSecondsOfCachedKernels;
    EXPECT_TRUE(IsWorthMakingResident(costs));
    costs.kernelSeconds = kSecondsOfBuiltKernels;
    EXPECT_FALSE(IsWorthMakingResident(costs));
    costs.secondsLeft = 3600.0;
    EXPECT_TRUE(IsWorthMakingResident(costs));
}

TEST(MakeResident, WhatNobodyHasSeenIsPreparedForLongRendersOnly) {
    MakeResidentCosts costs;
    costs.prepareSeconds = 2.0; // 100 MB/s
    costs.preparedBytes = 200'000'000;
    costs.missingBytes = 500'000'000;
    costs.secondsLeft = 20.0;
    EXPECT_FALSE(IsWorthMakingResident(costs));
    costs.secondsLeft = 2000.0;
    EXPECT_TRUE(IsWorthMakingResident(costs));
    costs.prepareSeconds *= 1000.0; // a slow one
    EXPECT_FALSE(IsWorthMakingResident(costs));
    costs.preparedBytes = 0; // not known: a bound of what two cores do
    costs.prepareSeconds = 0.0;
    EXPECT_TRUE(IsWorthMakingResident(costs));
    costs.secondsLeft = 20.0;
    EXPECT_FALSE(IsWorthMakingResident(costs));
}

// It saves more, and has to be built first.
TEST(MakeResident, TheFlatHierarchyCountsOnBothSides) {
    MakeResidentCosts costs;
    costs.kernelSeconds = kSecondsOfBuiltKernels;
    costs.secondsLeft = 40.0;
    EXPECT_FALSE(IsWorthMakingResident(costs));
    costs.flatTriangles = 1'000'000;
    EXPECT_TRUE(IsWorthMakingResident(costs));
    costs.flatTriangles = 1'000'000'000;
    EXPECT_FALSE(IsWorthMakingResident(costs));
}

TEST(MakeResident, WhatIsFlattenedIsBoundByRaysAndMemory) {
    FlatLimits limits;
    limits.bytes = 1U << 30U;
    EXPECT_EQ(MaxFlatTriangles(limits), 0U) << "no ray pays";
    limits.cameraRays = 4'000'000;
    const std::uint64_t byRays = MaxFlatTriangles(limits);
    EXPECT_GT(byRays, 0U);
    EXPECT_LT(byRays, limits.cameraRays);
    limits.raysATriangle = kFlatRaysATriangleGpu;
    EXPECT_LT(MaxFlatTriangles(limits), byRays) << "the host builds as slowly for a fast device";
    limits.raysATriangle = kFlatRaysATriangleCpu;
    limits.isForced = true;
    EXPECT_EQ(MaxFlatTriangles(limits), limits.bytes / kFlatBytesATriangle);
    limits.bytes = kFlatBytesATriangle * byRays / 2;
    EXPECT_EQ(MaxFlatTriangles(limits), byRays / 2);
    limits.isForced = false;
    EXPECT_EQ(MaxFlatTriangles(limits), byRays / 2);
    limits.bytes = 0;
    EXPECT_EQ(MaxFlatTriangles(limits), 0U);
}

TEST(MakeResident, TheRateLeavesOutTheFirstWave) {
    TracingRate rate;
    EXPECT_EQ(rate.SecondsPerSample(), 0.0) << "nothing is rendered";
    rate.EndWave(5.0, 0.5); // kernels were compiled
    EXPECT_EQ(rate.SecondsPerSample(), 0.0) << "not known";
    rate.EndWave(6.0, 1.0);
    EXPECT_EQ(rate.SecondsPerSample(), 2.0);
    rate.EndPass();
    EXPECT_EQ(rate.SecondsPerSample(), 2.0);
}

TEST(MakeResident, TheRateIsThatOfOnePassAndWhatFollows) {
    TracingRate rate;
    rate.EndWave(5.0, 1.0);
    rate.EndPass(); // of one wave
    EXPECT_EQ(rate.SecondsPerSample(), 0.0);
    rate.EndWave(8.0, 4.0);
    EXPECT_EQ(rate.SecondsPerSample(), 1.0);
    rate.EndWave(17.0, 16.0);
    rate.EndPass();
    EXPECT_EQ(rate.SecondsPerSample(), 0.8);
    rate.EndWave(18.0, 24.0);
    rate.EndWave(19.0, 32.0);
    rate.EndPass(); // most pixels have met the error
    EXPECT_EQ(rate.SecondsPerSample(), 0.125) << "the first pass counts no more";
}

TEST(MakeResident, LittleThatAnEditBringsIsLoadedAtOnce) {
    EXPECT_TRUE(BecomesResidentAtOnce(kLittleBytes));
    EXPECT_FALSE(BecomesResidentAtOnce(kLittleBytes + 1));
}

TEST(MakeResident, KernelsThatAreThereTakeNoTime) {
    EXPECT_EQ(SecondsToGet(KernelPlace::Bound), 0.0);
    EXPECT_EQ(SecondsToGet(KernelPlace::Cached), kSecondsOfCachedKernels);
    EXPECT_EQ(SecondsToGet(KernelPlace::Nowhere), kSecondsOfBuiltKernels);
}

} // namespace
} // namespace hds::test
