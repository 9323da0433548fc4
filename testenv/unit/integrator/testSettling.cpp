// SPDX-License-Identifier: Apache-2.0
// Geometry settles when what that saves is at least what it costs, and not before.
#include "hdStream/integrator/residencyPlan.h"
#include "hdStream/integrator/settling.h"

#include <gtest/gtest.h>

namespace hds::test {
namespace {

TEST(Settling, WhatCostsNothingIsWorthIt) {
    EXPECT_TRUE(IsWorthSettling({}));
}

TEST(Settling, KernelsAreBuiltForLongRendersOnly) {
    SettlingCosts costs;
    costs.secondsLeft = 60.0;
    costs.kernelSeconds = kSecondsOfCachedKernels;
    EXPECT_TRUE(IsWorthSettling(costs));
    costs.kernelSeconds = kSecondsOfBuiltKernels;
    EXPECT_FALSE(IsWorthSettling(costs));
    costs.secondsLeft = 3600.0;
    EXPECT_TRUE(IsWorthSettling(costs));
}

TEST(Settling, WhatNobodyHasSeenIsPreparedForLongRendersOnly) {
    SettlingCosts costs;
    costs.prepareSeconds = 2.0; // 100 MB/s
    costs.preparedBytes = 200'000'000;
    costs.missingBytes = 500'000'000;
    costs.secondsLeft = 20.0;
    EXPECT_FALSE(IsWorthSettling(costs));
    costs.secondsLeft = 2000.0;
    EXPECT_TRUE(IsWorthSettling(costs));
    costs.prepareSeconds *= 1000.0; // a slow one
    EXPECT_FALSE(IsWorthSettling(costs));
    costs.preparedBytes = 0; // not known: a bound of what two cores do
    costs.prepareSeconds = 0.0;
    EXPECT_TRUE(IsWorthSettling(costs));
    costs.secondsLeft = 20.0;
    EXPECT_FALSE(IsWorthSettling(costs));
}

TEST(Settling, LittleThatAnEditBringsIsLoadedAtOnce) {
    EXPECT_TRUE(SettlesAtOnce(kLittleBytes));
    EXPECT_FALSE(SettlesAtOnce(kLittleBytes + 1));
}

TEST(Settling, KernelsThatAreThereTakeNoTime) {
    EXPECT_EQ(SecondsToGet(KernelPlace::Bound), 0.0);
    EXPECT_EQ(SecondsToGet(KernelPlace::Cached), kSecondsOfCachedKernels);
    EXPECT_EQ(SecondsToGet(KernelPlace::Nowhere), kSecondsOfBuiltKernels);
}

} // namespace
} // namespace hds::test
