// SPDX-License-Identifier: Apache-2.0
// The device's inverse of an affine map against one in double precision: rotated, mirrored,
// strongly sheared maps, scales of 1e-12 to 1e12.
#include "kernels/shared/motionKeys.h"
#include "testenv/support/deviceFixture.h"

#include <glm/gtc/matrix_transform.hpp>
#include <glm/mat4x4.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <random>

namespace hds::test {
namespace {

const char* const kSource = R"(
#include "math/inverse.clh"
kernel void invert(global const float* maps, global float* inverses, uint count, uint isPlain) {
    uint i = (uint)get_global_id(0);
    if (i >= count) return;
    HdsTransform map = transform_load(maps + 12 * i);
    HdsTransform inverse = isPlain != 0u ? transform_inversePlain(&map) : transform_inverse(&map);
    vstore4(inverse.row0, 3 * i, inverses);
    vstore4(inverse.row1, 3 * i + 1, inverses);
    vstore4(inverse.row2, 3 * i + 2, inverses);
}
)";

constexpr double kRoundoff = 0x1p-24;

using Rows = std::array<float, 12>;

/// The inverse in extended precision, where products of two floats are exact.
struct Exact {
    explicit Exact(const Rows& map) {
        const auto entry = [&](int row, int column) {
            return static_cast<long double>(
                map[static_cast<std::size_t>(4 * (row % 3) + column % 3)]);
        };
        long double determinant = 0.0L;
        long double products = 0.0L;
        for (int row = 0; row < 3; ++row) {
            for (int column = 0; column < 3; ++column) {
                const long double plus = entry(row + 1, column + 1) * entry(row + 2, column + 2);
                const long double minus = entry(row + 1, column + 2) * entry(row + 2, column + 1);
                linear[column][row] = plus - minus;
                determinant += row == 0 ? entry(0, column) * (plus - minus) : 0.0L;
                products += row == 0
                                ? std::abs(entry(0, column)) * (std::abs(plus) + std::abs(minus))
                                : 0.0L;
            }
        }
        cancellation = static_cast<double>(products / std::abs(determinant));
        for (int row = 0; row < 3; ++row) {
            for (int column = 0; column < 3; ++column) {
                linear[row][column] /= determinant;
                inverseDeterminant = static_cast<double>(1.0L / determinant);
                translation[row] -=
                    linear[row][column] *
                    static_cast<long double>(map[static_cast<std::size_t>(4 * column + 3)]);
            }
        }
    }

    long double linear[3][3] = {};
    long double translation[3] = {};
    double inverseDeterminant = 0.0;
    double cancellation = 0.0; ///< of the terms of the determinant
};

class InverseTest : public DeviceFixture {
protected:
    std::vector<Rows> Invert(const std::vector<Rows>& maps, bool isPlain = false) {
        const auto program = Build(kSource);
        const Buffer input = Upload(maps);
        const Buffer output = Allocate(maps.size() * sizeof(Rows));
        program->GetKernel("invert").Launch(
            maps.size(), input, output, static_cast<std::uint32_t>(maps.size()), isPlain ? 1U : 0U);
        return Download<Rows>(output, maps.size());
    }

    /// A float map: rotations, scales around `size` that differ by up to `aspect`, shears of up to
    /// `shear`, mirrored by chance, a translation of up to 1e6 times the size.
    Rows RandomMap(double size, double aspect, double shear) {
        std::uniform_real_distribution<double> uniform(-1.0, 1.0);
        const auto vector = [&] {
            return glm::dvec3(uniform(random), uniform(random), uniform(random));
        };
        const auto scaled = [&](double range) {
            return std::exp(uniform(random) * std::log(range));
        };
        glm::dmat4 m = glm::translate(glm::dmat4(1.0), vector() * size * scaled(1e6));
        m = glm::rotate(m, 3.0 * uniform(random), vector());
        m = glm::scale(m, glm::dvec3(scaled(aspect), scaled(aspect), scaled(aspect)) * size *
                              (uniform(random) < 0.0 ? -1.0 : 1.0));
        glm::dmat4 shears(1.0);
        shears[1][0] = shear * uniform(random);
        shears[2][0] = shear * uniform(random);
        shears[2][1] = shear * uniform(random);
        m = glm::rotate(m * shears, 3.0 * uniform(random), vector());
        Rows rows{};
        for (int row = 0; row < 3; ++row) {
            for (int column = 0; column < 4; ++column) {
                rows[static_cast<std::size_t>(4 * row + column)] =
                    static_cast<float>(m[column][row]);
            }
        }
        return rows;
    }

    std::mt19937 random{5};
};

TEST_F(InverseTest, IsAccurateForShearsMirrorsAndScales) {
    std::vector<Rows> maps;
    for (const double size : {1e-12, 1e-6, 1e-2, 1.0, 1e2, 1e6, 1e12}) {
        for (const double shear : {0.0, 1.0, 30.0, 300.0}) {
            for (int i = 0; i < 2000; ++i) {
                maps.push_back(RandomMap(size, i % 2 == 0 ? 3.0 : 30.0, shear));
            }
        }
    }
    const std::vector<Rows> inverses = Invert(maps);
    double worstLinear = 0.0;
    double worstTranslation = 0.0;
    double worstCancellation = 0.0;
    for (std::size_t i = 0; i < maps.size(); ++i) {
        const Exact exact(maps[i]);
        // Twice the precision goes as far as that.
        const double allowance = 16.0 * kRoundoff * kRoundoff * exact.cancellation;
        worstCancellation = std::max(worstCancellation, exact.cancellation);
        for (std::size_t row = 0; row < 3; ++row) {
            double products = 0.0;
            for (std::size_t column = 0; column < 3; ++column) {
                const auto size = static_cast<double>(std::abs(exact.linear[row][column]));
                const auto error = static_cast<double>(
                    std::abs(inverses[i][4 * row + column] - exact.linear[row][column]));
                worstLinear = std::max(worstLinear, error / size - allowance);
                products += size * static_cast<double>(std::abs(maps[i][4 * column + 3]));
            }
            const auto error =
                static_cast<double>(std::abs(inverses[i][4 * row + 3] - exact.translation[row]));
            worstTranslation = std::max(worstTranslation, error / products - allowance);
        }
    }
    EXPECT_LT(worstLinear, 5.0 * kRoundoff);
    EXPECT_LT(worstTranslation, 7.0 * kRoundoff);
    EXPECT_GT(worstLinear, 0.5 * kRoundoff) << "the oracle measures something";
    EXPECT_GT(worstCancellation, 1e5) << "single precision alone would not do";
}

/// How far the map of a point and the inverse of that come off it, over the distance from the map's
/// origin, in roundoffs: at most the sum over columns of the map times the errors of rows.
double WayBack(const Rows& map, const Rows& inverse) {
    const Exact exact(map);
    double sum = 0.0;
    for (std::size_t row = 0; row < 3; ++row) {
        double error = 0.0;
        double length = 0.0;
        for (std::size_t k = 0; k < 3; ++k) {
            const auto one = static_cast<double>(inverse[4 * row + k] - exact.linear[row][k]);
            error += one * one;
            length += double{map[4 * k + row]} * double{map[4 * k + row]};
        }
        sum += std::sqrt(error * length);
    }
    return sum / kRoundoff;
}

TEST_F(InverseTest, FewOperationsDoForOrdinaryMaps) {
    std::vector<Rows> maps;
    std::vector<Rows> sheared;
    for (const double size : {0x1p-28, 1e-6, 1.0, 1e6, 0x1p28}) {
        for (int i = 0; i < 20000; ++i) {
            const Rows map = RandomMap(size, i % 2 == 0 ? 1.5 : 3.0, i % 4 == 0 ? 0.0 : 1.0);
            double product = 1.0;
            for (std::size_t k = 0; k < 3; ++k) {
                product *= std::hypot(double{map[k]}, double{map[4 + k]}, double{map[8 + k]});
            }
            const bool isPlain =
                product * std::abs(Exact(map).inverseDeterminant) <= HDS_MOTION_MOST_SHEAR;
            (isPlain ? maps : sheared).push_back(map);
        }
    }
    ASSERT_GT(maps.size(), 30000U);
    ASSERT_GT(sheared.size(), 1000U);
    double worst = 0.0;
    const std::vector<Rows> inverses = Invert(maps, true);
    for (std::size_t i = 0; i < maps.size(); ++i) {
        worst = std::max(worst, WayBack(maps[i], inverses[i]));
    }
    EXPECT_LT(worst, 80.0);
    EXPECT_GT(worst, 2.0) << "the oracle measures something";
}

TEST_F(InverseTest, PowersOfTwoAndPermutationsAreExact) {
    const Rows map = {0, -4, 0, 8, 0, 0, 0.25F, -3, 0x1p-40F, 0, 0, 0x1p-38F};
    const Rows expected = {0, 0, 0x1p40F, -4, -0.25F, 0, 0, 2, 0, 4, 0, 12};
    const Rows found = Invert({map})[0];
    for (std::size_t i = 0; i < 12; ++i) {
        EXPECT_EQ(found[i], expected[i]) << i;
    }
}

TEST_F(InverseTest, SingularMapsAreNotFinite) {
    const Rows map = {1, 2, 3, 0, 2, 4, 6, 0, 0, 0, 1, 0};
    EXPECT_FALSE(std::isfinite(Invert({map})[0][0]));
}

} // namespace
} // namespace hds::test
