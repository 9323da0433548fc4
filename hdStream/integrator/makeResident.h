// SPDX-License-Identifier: Apache-2.0
// Whether geometry that streams had better become resident in the middle of a render. It changes
// time, never bits. Explained in docs/streaming.md.
#pragma once

#include <cstdint>

namespace hds {

/// Whether geometry that was resident before an edit becomes so again before the first ray.
/// \param missingBytes of the pages that the edit has brought.
bool BecomesResidentAtOnce(std::uint64_t missingBytes);

/// How fast a render traces and shades at present: the rate of the last pass and of what the next
/// one has rendered so far. It leaves out the first wave, in which drivers compile what they launch
/// first and most pages are loaded.
class TracingRate {
public:
    /// A wave has ended. \param seconds of tracing and shading since the render began.
    /// \param samples per pixel since then, as SampleSchedule::Equivalent.
    void EndWave(double seconds, double samples);
    /// The wave that has ended last was the last one of a pass.
    void EndPass();
    /// 0: not known yet.
    double SecondsPerSample() const;

private:
    struct Point {
        double seconds = 0.0;
        double samples = 0.0;
    };

    bool _hasBegun = false;
    Point _begin; ///< of what the rate is taken from
    Point _pass;  ///< beginning of the present pass
    Point _now;
};

/// What is known between two waves of a render.
struct MakeResidentCosts {
    double secondsLeft = 0.0;        ///< of tracing and shading, at the present rate
    double kernelSeconds = 0.0;      ///< until kernels without streaming code are there
    std::uint64_t flatTriangles = 0; ///< that are flattened then; 0: there is no flat hierarchy
    std::uint64_t missingBytes = 0;  ///< pages to be prepared and loaded
    double prepareSeconds = 0.0;     ///< what preparing pages has taken in this render
    std::uint64_t preparedBytes = 0; ///< these pages
};

/// Seconds until a set of kernels is there that is in the persistent cache, or has to be built:
/// PoCL on two cores (docs/streaming.md).
constexpr double kSecondsOfCachedKernels = 0.1;
constexpr double kSecondsOfBuiltKernels = 5.0;

/// Where a set of kernels is.
enum class KernelPlace { Bound, Cached, Nowhere };

/// An estimate.
double SecondsToGet(KernelPlace place);

/// Whether what resident kernels save is at least what it takes to have them, all pages and the
/// flat hierarchy.
bool IsWorthMakingResident(const MakeResidentCosts& costs);

} // namespace hds
