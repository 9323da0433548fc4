// SPDX-License-Identifier: Apache-2.0
#include "hdStream/integrator/residencyPlan.h"

#include <algorithm>

namespace hds {

namespace {

/// Part of the device's memory that a pool may take when the user does not say.
constexpr std::uint64_t kBudgetDivisor = 4;

std::uint64_t Budget(std::uint64_t bytes, double share, std::uint64_t totalBytes,
                     std::uint64_t deviceBytes) {
    if (share > 0.0) {
        return static_cast<std::uint64_t>(share * static_cast<double>(totalBytes));
    }
    return bytes > 0 ? bytes : deviceBytes / kBudgetDivisor;
}

PoolKind ChoosePool(const ResidencyOptions& options, std::uint64_t totalBytes,
                    std::uint64_t budgetBytes) {
    switch (options.mode) {
    case ResidencyMode::Resident:
        return PoolKind::Resident;
    case ResidencyMode::Stream:
        return PoolKind::Streaming;
    case ResidencyMode::Mapped:
        return PoolKind::Mapped;
    case ResidencyMode::Auto:
        break;
    }
    // A share of all bytes is known once all is prepared.
    const bool isPrepared = options.preparesAll || options.budgetShare > 0.0;
    const bool isLittle = totalBytes <= kLittleBytes || isPrepared;
    return totalBytes <= budgetBytes && isLittle ? PoolKind::Resident : PoolKind::Streaming;
}

} // namespace

ResidencyPlan PlanResidency(const ResidencyOptions& options, std::uint64_t totalBytes,
                            std::uint64_t deviceBytes) {
    ResidencyPlan plan;
    plan.budgetBytes = Budget(options.budgetBytes, options.budgetShare, totalBytes, deviceBytes);
    plan.pool = ChoosePool(options, totalBytes, plan.budgetBytes);
    // A mapped pool prepares what is in no file itself.
    plan.needsAllPages = plan.pool != PoolKind::Mapped &&
                         (plan.pool == PoolKind::Resident || options.budgetShare > 0.0);
    return plan;
}

std::uint64_t TextureBudget(const ResidencyOptions& options, std::uint64_t totalBytes,
                            std::uint64_t deviceBytes) {
    return Budget(options.textureBudgetBytes, options.textureBudgetShare, totalBytes, deviceBytes);
}

std::uint64_t VolumeBudget(const ResidencyOptions& options, std::uint64_t totalBytes) {
    const bool isGiven = options.volumeBudgetBytes > 0 || options.volumeBudgetShare > 0.0;
    return isGiven ? std::max<std::uint64_t>(1, Budget(options.volumeBudgetBytes,
                                                       options.volumeBudgetShare, totalBytes, 0))
                   : 0;
}

} // namespace hds
