// SPDX-License-Identifier: Apache-2.0
// Pearson's chi-square test of a sampler against the density it claims, over the unit square.
// A domain maps samples to the square and back: SphereDomain and DiskDomain here; tests add their
// own (points of a rectangle, of a cone). Design after Mitsuba 3's chi2 module (Jakob et al. 2022):
// bins are pooled until each expects enough samples, mass that the density lacks counts as a bin.
// Explained in docs/shading.md, section "Tests".
#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <functional>
#include <numeric>
#include <random>
#include <string>
#include <vector>

namespace hds::test {

/// Bins per axis, points per bin and axis at which the density is integrated unless a test asks for
/// more, and the least number of samples a bin may expect. 5 is Cochran's rule, below which the
/// statistic is not chi-square distributed.
constexpr int kChiSquareBins = 32;
constexpr int kChiSquareSubdivisions = 8;
/// Of densities with an edge inside of bins, as refraction by rough glass has where the normal that
/// refracts lies on the horizon.
constexpr int kChiSquareFineSubdivisions = 32;
constexpr double kChiSquareMinExpected = 5.0;

/// Chance that a correct suite fails, shared by all tests of the suite (Sidak): with fixed seeds it
/// is paid once, when a test is written.
constexpr double kChiSquareSignificance = 0.01;
constexpr int kChiSquareNumTests = 100;

/// Upper tail of the chi-square distribution: Q(dof / 2, x / 2), by series or continued fraction.
/// Source: Press et al. 2007, Numerical Recipes, section 6.2.
inline double ChiSquareTail(double x, double dof) {
    const double a = 0.5 * dof;
    const double z = 0.5 * x;
    if (!(z > 0.0)) {
        return 1.0;
    }
    const double scale = std::exp(a * std::log(z) - z - std::lgamma(a));
    if (z < a + 1.0) {
        double term = 1.0 / a;
        double sum = term;
        for (int n = 1; n < 10000 && term > sum * 1e-16; ++n) {
            term *= z / (a + n);
            sum += term;
        }
        return 1.0 - scale * sum;
    }
    double b = z + 1.0 - a;
    double c = 1e300;
    double d = 1.0 / b;
    double h = d;
    for (int n = 1; n < 10000; ++n) {
        const double an = -n * (n - a);
        b += 2.0;
        d = 1.0 / (an * d + b);
        c = b + an / c;
        const double delta = d * c;
        h *= delta;
        if (std::abs(delta - 1.0) < 1e-16) {
            break;
        }
    }
    return scale * h;
}

using Square = std::array<double, 2>;

/// Random points of the unit square, uniform and independent, as floats in [0, 1).
inline std::vector<float> RandomSquares(std::size_t count, unsigned seed) {
    std::mt19937 generator(seed);
    std::vector<float> values(count * 2);
    for (float& value : values) {
        value = float(generator() >> 8) * 0x1p-24F;
    }
    return values;
}

/// Directions: x is theta / pi, y is phi / 2 pi. Even in theta, so that peaks at the pole are wide.
struct SphereDomain {
    static constexpr double kPi = 3.141592653589793;
    static Square ToSquare(const double* d) {
        const double phi = std::atan2(d[1], d[0]) / (2.0 * kPi);
        return {std::atan2(std::hypot(d[0], d[1]), d[2]) / kPi, phi < 0.0 ? phi + 1.0 : phi};
    }
    static void FromSquare(const Square& s, float* d) {
        const double r = std::sin(kPi * s[0]);
        d[0] = float(r * std::cos(2.0 * kPi * s[1]));
        d[1] = float(r * std::sin(2.0 * kPi * s[1]));
        d[2] = float(std::cos(kPi * s[0]));
    }
    /// Solid angle per unit of the square.
    static double Jacobian(const Square& s) { return 2.0 * kPi * kPi * std::sin(kPi * s[0]); }
};

/// The unit disk: x is r^2, y is phi / 2 pi; the Jacobian is pi.
struct DiskDomain {
    static constexpr double kJacobian = 3.141592653589793;
    static Square ToSquare(double x, double y) {
        const double phi = std::atan2(y, x) / 6.283185307179586;
        return {x * x + y * y, phi < 0.0 ? phi + 1.0 : phi};
    }
};

/// Counts of samples per bin; samples outside the square are not counted.
inline std::vector<double> BinSamples(const std::vector<Square>& samples) {
    std::vector<double> counts(kChiSquareBins * kChiSquareBins, 0.0);
    for (const Square& s : samples) {
        if (!(s[0] >= 0.0 && s[0] <= 1.0 && s[1] >= 0.0 && s[1] <= 1.0)) {
            continue;
        }
        const int x = std::min(int(s[0] * kChiSquareBins), kChiSquareBins - 1);
        const int y = std::min(int(s[1] * kChiSquareBins), kChiSquareBins - 1);
        counts[std::size_t(y) * kChiSquareBins + std::size_t(x)] += 1.0;
    }
    return counts;
}

/// The points at which a density over the square is wanted: midpoints of all subdivisions.
inline std::vector<Square> DensityPoints(int subdivisions = kChiSquareSubdivisions) {
    const int numSteps = kChiSquareBins * subdivisions;
    std::vector<Square> points;
    points.reserve(std::size_t(numSteps) * numSteps);
    for (int y = 0; y < numSteps; ++y) {
        for (int x = 0; x < numSteps; ++x) {
            points.push_back({(x + 0.5) / numSteps, (y + 0.5) / numSteps});
        }
    }
    return points;
}

/// Probability of each bin from densities (with respect to the square) at DensityPoints() of some
/// number of subdivisions.
inline std::vector<double> IntegrateBins(const std::vector<double>& densities) {
    const int numSteps = int(std::lround(std::sqrt(double(densities.size()))));
    const int subdivisions = numSteps / kChiSquareBins;
    std::vector<double> bins(kChiSquareBins * kChiSquareBins, 0.0);
    for (int y = 0; y < numSteps; ++y) {
        for (int x = 0; x < numSteps; ++x) {
            const int bin = y / subdivisions * kChiSquareBins + x / subdivisions;
            bins[std::size_t(bin)] += densities[std::size_t(y) * numSteps + std::size_t(x)] /
                                      (double(numSteps) * numSteps);
        }
    }
    return bins;
}

/// Expects that `samples` follow `densities` (at DensityPoints(), per unit of the square).
/// \param numSamples all that were drawn; those that the sampler rejected are not in `samples`, and
/// their share must equal the mass that the density lacks.
inline void ExpectChiSquare(const std::string& name, const std::vector<Square>& samples,
                            std::size_t numSamples, const std::vector<double>& densities) {
    std::vector<double> counts = BinSamples(samples);
    std::vector<double> expected = IntegrateBins(densities);
    const double mass = std::accumulate(expected.begin(), expected.end(), 0.0);
    ASSERT_LT(mass, 1.0 + 2e-3) << name << ": the density integrates to more than 1";
    counts.push_back(double(numSamples) - std::accumulate(counts.begin(), counts.end(), 0.0));
    expected.push_back(std::max(0.0, 1.0 - mass));

    std::vector<std::size_t> order(expected.size());
    std::iota(order.begin(), order.end(), std::size_t(0));
    std::stable_sort(order.begin(), order.end(),
                     [&](std::size_t a, std::size_t b) { return expected[a] < expected[b]; });
    double statistic = 0.0;
    double pooledCount = 0.0;
    double pooledExpected = 0.0;
    int cells = 0;
    for (const std::size_t i : order) {
        pooledCount += counts[i];
        pooledExpected += expected[i] * double(numSamples);
        if (pooledExpected >= kChiSquareMinExpected) {
            const double difference = pooledCount - pooledExpected;
            statistic += difference * difference / pooledExpected;
            pooledCount = 0.0;
            pooledExpected = 0.0;
            ++cells;
        }
    }
    ASSERT_LE(pooledCount, 0.0) << name << ": samples where the density is 0";
    ASSERT_GE(cells, 2) << name << ": too few bins";
    const double pValue = ChiSquareTail(statistic, cells - 1);
    const double level = 1.0 - std::pow(1.0 - kChiSquareSignificance, 1.0 / kChiSquareNumTests);
    EXPECT_GT(pValue, level) << name << ": chi-square " << statistic << " with " << cells - 1
                             << " degrees of freedom, mass " << mass;
}

} // namespace hds::test
