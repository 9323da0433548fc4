// SPDX-License-Identifier: Apache-2.0
#include "hdStream/integrator/makeResident.h"

#include "hdStream/integrator/residencyPlan.h"

namespace hds {

namespace {

/// Part of the time of tracing and shading that kernels without streaming code save when nothing is
/// missing. Measured: docs/streaming.md, "What it costs".
constexpr double kSavedPart = 0.05;
/// The same with the flat hierarchy (docs/accel.md, "The flat hierarchy"), and the seconds that two
/// cores take to build it.
constexpr double kSavedPartOfFlat = 0.2;
constexpr double kSecondsPerFlatTriangle = 0.3e-6;
/// Of pages, while none has been prepared: two cores build so many.
constexpr double kSecondsPerByte = 1.0 / 100e6;

} // namespace

void TracingRate::EndWave(double seconds, double samples) {
    _now = {seconds, samples};
    if (!_hasBegun) {
        _hasBegun = true;
        _begin = _now;
        _pass = _now;
    }
}

void TracingRate::EndPass() {
    _begin = _pass;
    _pass = _now;
}

double TracingRate::SecondsPerSample() const {
    const double samples = _now.samples - _begin.samples;
    return samples > 0.0 ? (_now.seconds - _begin.seconds) / samples : 0.0;
}

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
    const double flattenSeconds =
        kSecondsPerFlatTriangle * static_cast<double>(costs.flatTriangles);
    const double savedPart = costs.flatTriangles > 0 ? kSavedPartOfFlat : kSavedPart;
    return costs.kernelSeconds + flattenSeconds +
               secondsPerByte * static_cast<double>(costs.missingBytes) <=
           savedPart * costs.secondsLeft;
}

} // namespace hds
