// SPDX-License-Identifier: Apache-2.0
// Geometry is made resident when what that saves is at least what it costs, and not before.
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
