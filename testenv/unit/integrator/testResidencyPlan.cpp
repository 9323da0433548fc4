// SPDX-License-Identifier: Apache-2.0
// Where geometry goes and how large pools are, by options, sizes and the device's memory.
#include "hdStream/integrator/residencyPlan.h"

#include <gtest/gtest.h>

namespace hds::test {
namespace {

constexpr std::uint64_t kMega = 1U << 20U;
constexpr std::uint64_t kDevice = 4096 * kMega;

ResidencyOptions Options(ResidencyMode mode = ResidencyMode::Auto) {
    ResidencyOptions options;
    options.mode = mode;
    return options;
}

PoolKind PoolOf(const ResidencyOptions& options, std::uint64_t totalBytes) {
    return PlanResidency(options, totalBytes, kDevice).pool;
}

TEST(ResidencyPlan, BudgetsAreBytesOrAShareOrAQuarterOfTheDevice) {
    ResidencyOptions options = Options(ResidencyMode::Stream);
    EXPECT_EQ(PlanResidency(options, 1000, kDevice).budgetBytes, 1024 * kMega);
    options.budgetBytes = 123;
    options.textureBudgetBytes = 77;
    EXPECT_EQ(PlanResidency(options, 1000, kDevice).budgetBytes, 123U);
    EXPECT_EQ(TextureBudget(options, 1000, kDevice), 77U);
    options.budgetShare = 0.25;
    EXPECT_EQ(PlanResidency(options, 1002, kDevice).budgetBytes, 250U) << "rounded down";
    EXPECT_EQ(TextureBudget(options, 1000, kDevice), 77U) << "each has its own";
    options.textureBudgetShare = 0.5;
    EXPECT_EQ(TextureBudget(options, 1001, kDevice), 500U);
    EXPECT_EQ(TextureBudget(Options(), 1000, kDevice), 1024 * kMega);
    EXPECT_EQ(VolumeBudget(options, 1001), 0U) << "volumes share with textures";
    options.volumeBudgetBytes = 55;
    EXPECT_EQ(VolumeBudget(options, 1001), 55U);
    options.volumeBudgetShare = 0.3;
    EXPECT_EQ(VolumeBudget(options, 1001), 300U);
    EXPECT_EQ(VolumeBudget(options, 2), 1U) << "0 would share";
}

TEST(ResidencyPlan, WhatIsAskedForIsDone) {
    for (const std::uint64_t bytes : {std::uint64_t{1}, 100 * kMega, 100000 * kMega}) {
        EXPECT_EQ(PoolOf(Options(ResidencyMode::Resident), bytes), PoolKind::Resident);
        EXPECT_EQ(PoolOf(Options(ResidencyMode::Stream), bytes), PoolKind::Streaming);
        EXPECT_EQ(PoolOf(Options(ResidencyMode::Mapped), bytes), PoolKind::Mapped);
    }
}

TEST(ResidencyPlan, AutoStreamsWhatIsNotLittleOrDoesNotFit) {
    ResidencyOptions options = Options();
    EXPECT_EQ(PoolOf(options, kLittleBytes), PoolKind::Resident);
    EXPECT_EQ(PoolOf(options, kLittleBytes + 1), PoolKind::Streaming);
    options.budgetBytes = 2 * kMega;
    EXPECT_EQ(PoolOf(options, 2 * kMega), PoolKind::Resident);
    EXPECT_EQ(PoolOf(options, 2 * kMega + 1), PoolKind::Streaming);
    options.preparesAll = true;
    options.budgetBytes = 100 * kMega;
    EXPECT_EQ(PoolOf(options, 100 * kMega), PoolKind::Resident) << "all is prepared anyway";
    EXPECT_EQ(PoolOf(options, 100 * kMega + 1), PoolKind::Streaming);
}

TEST(ResidencyPlan, AutoWithAShareOfAllFitsWhenItIsAll) {
    ResidencyOptions options = Options();
    options.budgetShare = 1.0;
    EXPECT_EQ(PoolOf(options, 100 * kMega), PoolKind::Resident);
    options.budgetShare = 0.99;
    EXPECT_EQ(PoolOf(options, 100 * kMega), PoolKind::Streaming);
}

bool NeedsAll(const ResidencyOptions& options, std::uint64_t totalBytes) {
    return PlanResidency(options, totalBytes, kDevice).needsAllPages;
}

TEST(ResidencyPlan, AllIsPreparedForResidentPoolsAndForShares) {
    EXPECT_TRUE(NeedsAll(Options(ResidencyMode::Resident), 100 * kMega));
    EXPECT_FALSE(NeedsAll(Options(ResidencyMode::Stream), 100 * kMega));
    EXPECT_FALSE(NeedsAll(Options(ResidencyMode::Mapped), 100 * kMega));
    EXPECT_TRUE(NeedsAll(Options(), kLittleBytes));
    EXPECT_FALSE(NeedsAll(Options(), kLittleBytes + 1));
    for (const ResidencyMode mode : {ResidencyMode::Stream, ResidencyMode::Auto}) {
        ResidencyOptions options = Options(mode);
        options.budgetShare = 0.1;
        EXPECT_TRUE(NeedsAll(options, 100 * kMega));
    }
    ResidencyOptions mapped = Options(ResidencyMode::Mapped);
    mapped.budgetShare = 0.1;
    EXPECT_FALSE(NeedsAll(mapped, 100 * kMega)) << "it has no pool";
}

} // namespace
} // namespace hds::test
