// SPDX-License-Identifier: Apache-2.0
// Inverse cumulative distributions of pixel filters.
#include "hdStream/shading/pixelFilter.h"

#include "hdStream/base/error.h"

#include <cmath>
#include <cstddef>

namespace hds {

namespace {

constexpr double kPi = 3.14159265358979323846;

/// Equals HDS_FILTER_TABLE_SIZE of kernels/sample/filter.clh (testPixelFilter compares them).
constexpr int kTableSize = 512;

/// Coefficients of the four-term window. Source: Harris 1978, "On the Use of Windows for Harmonic
/// Analysis with the Discrete Fourier Transform", minimum 4-term (-92 dB).
constexpr double kBlackmanHarris[4] = {0.35875, 0.48829, 0.14128, 0.01168};

/// Integral of the window from its left end to x in [0, 1] of its width.
double BlackmanHarrisIntegral(double x) {
    const double* a = kBlackmanHarris;
    return a[0] * x - a[1] * std::sin(2.0 * kPi * x) / (2.0 * kPi) +
           a[2] * std::sin(4.0 * kPi * x) / (4.0 * kPi) -
           a[3] * std::sin(6.0 * kPi * x) / (6.0 * kPi);
}

/// The x in [0, 1] at which the integral reaches `share` of its total: bisection to double
/// precision.
double InvertBlackmanHarris(double share) {
    const double target = share * BlackmanHarrisIntegral(1.0);
    double low = 0.0;
    double high = 1.0;
    for (int i = 0; i < 60; ++i) {
        const double middle = 0.5 * (low + high);
        (BlackmanHarrisIntegral(middle) < target ? low : high) = middle;
    }
    return 0.5 * (low + high);
}

void CheckFilter(const std::string& name, double width) {
    if (name != "blackmanHarris" && name != "box") {
        throw Error("unknown pixel filter " + name, ErrorKind::Usage);
    }
    if (!(width > 0.0) || !std::isfinite(width)) {
        throw Error("pixel filter width must be positive", ErrorKind::Usage);
    }
}

} // namespace

std::vector<float> BuildPixelFilterTable(const std::string& name, double width) {
    CheckFilter(name, width);
    std::vector<float> table(kTableSize + 1);
    for (int i = 0; i <= kTableSize; ++i) {
        const double root = double(i) / kTableSize;
        const double share = 0.5 * root * root;
        const double x = name == "box" ? share : InvertBlackmanHarris(share);
        table[std::size_t(i)] = float((x - 0.5) * width);
    }
    table.front() = float(-0.5 * width);
    table.back() = 0.0F;
    return table;
}

double EvaluatePixelFilter(const std::string& name, double width, double offset) {
    CheckFilter(name, width);
    const double x = offset / width + 0.5;
    if (x < 0.0 || x > 1.0) {
        return 0.0;
    }
    if (name == "box") {
        return 1.0;
    }
    const double* a = kBlackmanHarris;
    return a[0] - a[1] * std::cos(2.0 * kPi * x) + a[2] * std::cos(4.0 * kPi * x) -
           a[3] * std::cos(6.0 * kPi * x);
}

} // namespace hds
