// SPDX-License-Identifier: Apache-2.0
#include "hdStream/integrator/makeResident.h"

#include "hdStream/integrator/residencyPlan.h"

namespace hds {

namespace {

/// Part of the time of tracing and shading that kernels without streaming code save when nothing is
/// missing. Measured: docs/streaming.md, "What it costs".
constexpr double kSavedPart = 0.05;
/// Of pages, while none has been prepared: two cores build so many.
constexpr double kSecondsPerByte = 1.0 / 100e6;

} // namespace

bool BecomesResidentAtOnce(std::uint64_t missingBytes) {
    return missingBytes <= kLittleBytes;
}

double SecondsToGet(KernelPlace place) {
    switch (place) {
    case KernelPlace::Bound:
        return 0.0;
    case KernelPlace::Cached:
        return kSecondsOfCachedKernels;
    case KernelPlace::Nowhere:
        break;
    }
    return kSecondsOfBuiltKernels;
}

bool IsWorthMakingResident(const MakeResidentCosts& costs) {
    const double secondsPerByte =
        costs.preparedBytes > 0 ? costs.prepareSeconds / static_cast<double>(costs.preparedBytes)
                                : kSecondsPerByte;
    return costs.kernelSeconds + secondsPerByte * static_cast<double>(costs.missingBytes) <=
           kSavedPart * costs.secondsLeft;
}

} // namespace hds
