// SPDX-License-Identifier: Apache-2.0
#include "hdStream/scene/valueRange.h"

#include "kernels/shared/programMath.h"

#include <algorithm>
#include <cmath>
#include <initializer_list>
#include <limits>

namespace hds {

namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr double kPi = 3.14159265358979;
constexpr AmountRange kAny = {-kInfinity, kInfinity};
/// Of Perlin's noise by the largest sums of weighed gradients, which all cells could have at once:
/// 0.9998 in the plane, 1.0177 in space.
constexpr double kNoise2 = 1.001;
constexpr double kNoise3 = 1.019;

bool IsPoint(const AmountRange& a) {
    return a.low == a.high;
}

AmountRange Ordered(double a, double b) {
    return std::isnan(a) || std::isnan(b) ? kAny : AmountRange{std::min(a, b), std::max(a, b)};
}

/// The least range with all values; any where one is not a number.
AmountRange RangeOfValues(std::initializer_list<double> values) {
    AmountRange range{kInfinity, -kInfinity};
    for (const double value : values) {
        if (std::isnan(value)) {
            return kAny;
        }
        range.low = std::min(range.low, value);
        range.high = std::max(range.high, value);
    }
    return range;
}

AmountRange Within(const AmountRange& a, double low, double high) {
    return {std::clamp(a.low, low, high), std::clamp(a.high, low, high)};
}

AmountRange Negated(const AmountRange& a) {
    return {-a.high, -a.low};
}

AmountRange Difference(const AmountRange& a, const AmountRange& b) {
    return SumOf(a, Negated(b));
}

/// A function that never falls.
template <typename Function>
AmountRange Rising(const AmountRange& a, const Function& f) {
    return Ordered(f(a.low), f(a.high));
}

AmountRange Absolute(const AmountRange& a) {
    const double most = std::max(std::fabs(a.low), std::fabs(a.high));
    const bool holdsZero = a.low <= 0.0 && a.high >= 0.0;
    return {holdsZero ? 0.0 : std::min(std::fabs(a.low), std::fabs(a.high)), most};
}

/// cos; sin is cos of what is a quarter turn behind.
AmountRange Cosine(const AmountRange& a) {
    if (!std::isfinite(a.low) || !std::isfinite(a.high)) {
        return kAny; // not a number
    }
    if (!(a.high - a.low < 2.0 * kPi) || std::fabs(a.low) > 1e5 || std::fabs(a.high) > 1e5) {
        return {-1.0, 1.0};
    }
    AmountRange range = Ordered(std::cos(a.low), std::cos(a.high));
    // An odd multiple of pi has -1, an even one 1.
    for (double k = std::ceil(a.low / kPi); k * kPi <= a.high; k += 1.0) {
        const bool isOdd = std::fmod(std::fabs(k), 2.0) == 1.0;
        range = HullOf(range, isOdd ? AmountRange{-1.0, -1.0} : AmountRange{1.0, 1.0});
    }
    return {std::max(range.low - 1e-5, -1.0), std::min(range.high + 1e-5, 1.0)};
}

AmountRange Tangent(const AmountRange& a) {
    const double half = 0.5 * kPi;
    const double turn = std::floor((a.low + half) / kPi);
    const bool isOneBranch = a.low > turn * kPi - half + 1e-3 && a.high < turn * kPi + half - 1e-3;
    return isOneBranch ? Rising(a, [](double x) { return std::tan(x); }) : kAny;
}

AmountRange Quotient(const AmountRange& a, const AmountRange& b) {
    if (b.low <= 0.0 && b.high >= 0.0) {
        return kAny;
    }
    return RangeOfValues({a.low / b.low, a.low / b.high, a.high / b.low, a.high / b.high});
}

/// a - b floor(a / b).
AmountRange Modulo(const AmountRange& a, const AmountRange& b) {
    if (b.low <= 0.0 && b.high >= 0.0) {
        return kAny;
    }
    const double rounding = 1e-6 * std::max(std::fabs(a.low), std::fabs(a.high));
    if (IsPoint(b) && std::floor(a.low / b.low) == std::floor(a.high / b.low)) {
        const double turns = b.low * std::floor(a.low / b.low);
        // Rounding may put an end into the next period.
        const AmountRange range{a.low - turns, a.high - turns};
        const AmountRange inside =
            Within(range, std::min(rounding, std::fabs(b.low)) * (b.low > 0.0 ? 1.0 : -1.0), b.low);
        if (inside.low == range.low && inside.high == range.high) {
            return {range.low - rounding, range.high + rounding};
        }
    }
    return {std::min(b.low, 0.0) - rounding, std::max(b.high, 0.0) + rounding};
}

AmountRange Power(const AmountRange& a, const AmountRange& b) {
    const double exponent = b.low;
    if (a.low < 0.0) {
        if (!IsPoint(b) || std::floor(exponent) != exponent || exponent < 0.0) {
            return kAny;
        }
        const AmountRange ends = Ordered(std::pow(a.low, exponent), std::pow(a.high, exponent));
        return a.high > 0.0 ? HullOf(ends, {0.0, exponent == 0.0 ? 1.0 : 0.0}) : ends;
    }
    if (a.low == 0.0 && b.low <= 0.0 && !(IsPoint(b) && exponent == 0.0)) {
        return kAny;
    }
    return RangeOfValues({std::pow(a.low, b.low), std::pow(a.low, b.high), std::pow(a.high, b.low),
                          std::pow(a.high, b.high)});
}

AmountRange Angle(const AmountRange& y, const AmountRange& x) {
    if (!std::isfinite(y.low + y.high) || !std::isfinite(x.low + x.high)) {
        return kAny;
    }
    if (!(x.low > 0.0)) {
        return {-kPi, kPi};
    }
    return RangeOfValues({std::atan2(y.low, x.low), std::atan2(y.low, x.high),
                          std::atan2(y.high, x.low), std::atan2(y.high, x.high)});
}

AmountRange Decided(bool isTrue, bool isFalse) {
    return {isTrue ? 1.0 : 0.0, isFalse ? 0.0 : 1.0};
}

AmountRange Of1(std::uint32_t code, const AmountRange& a) {
    switch (code) {
    case HDS_MATH_ABS:
        return Absolute(a);
    case HDS_MATH_SIGN:
        return Rising(a, [](double x) { return x > 0.0 ? 1.0 : x < 0.0 ? -1.0 : 0.0; });
    case HDS_MATH_FLOOR:
        return Rising(a, [](double x) { return std::floor(x); });
    case HDS_MATH_CEIL:
        return Rising(a, [](double x) { return std::ceil(x); });
    case HDS_MATH_ROUND:
        return Rising(a, [](double x) { return std::floor(x + 0.5); });
    case HDS_MATH_SQRT:
        return Rising(a, [](double x) { return std::sqrt(std::max(x, 0.0)); });
    case HDS_MATH_EXP:
        return Rising(a, [](double x) { return std::exp(x); });
    case HDS_MATH_LN:
        return a.low > 0.0 ? Rising(a, [](double x) { return std::log(x); }) : kAny;
    case HDS_MATH_SIN:
        return Cosine({a.low - 0.5 * kPi, a.high - 0.5 * kPi});
    case HDS_MATH_COS:
        return Cosine(a);
    case HDS_MATH_TAN:
        return Tangent(a);
    case HDS_MATH_ASIN:
        return Rising(Within(a, -1.0, 1.0), [](double x) { return std::asin(x); });
    default: // HDS_MATH_ACOS
        return Ordered(std::acos(std::clamp(a.low, -1.0, 1.0)),
                       std::acos(std::clamp(a.high, -1.0, 1.0)));
    }
}

AmountRange Of2(std::uint32_t code, const AmountRange& a, const AmountRange& b) {
    switch (code) {
    case HDS_MATH_ADD:
        return SumOf(a, b);
    case HDS_MATH_SUBTRACT:
        return Difference(a, b);
    case HDS_MATH_MULTIPLY:
        return ProductOf(a, b);
    case HDS_MATH_DIVIDE:
        return Quotient(a, b);
    case HDS_MATH_MODULO:
        return Modulo(a, b);
    case HDS_MATH_POWER:
        return Power(a, b);
    case HDS_MATH_MIN:
        return {std::min(a.low, b.low), std::min(a.high, b.high)};
    case HDS_MATH_MAX:
        return {std::max(a.low, b.low), std::max(a.high, b.high)};
    case HDS_MATH_ATAN2:
        return Angle(a, b);
    case HDS_MATH_GREATER:
        return Decided(a.low > b.high, a.high <= b.low);
    case HDS_MATH_GREATER_OR_EQUAL:
        return Decided(a.low >= b.high, a.high < b.low);
    default: // HDS_MATH_EQUAL
        return Decided(IsPoint(a) && IsPoint(b) && a.low == b.low,
                       a.high < b.low || b.high < a.low);
    }
}

AmountRange Of3(std::uint32_t code, const AmountRange& a, const AmountRange& b,
                const AmountRange& c) {
    if (code == HDS_MATH_MIX) { // linear in each: the corners
        AmountRange range{kInfinity, -kInfinity};
        for (const double share : {c.low, c.high}) {
            range = HullOf(range, SumOf(ProductOf(a, {1.0 - share, 1.0 - share}),
                                        ProductOf(b, {share, share})));
        }
        return range;
    }
    if (code == HDS_MATH_SMOOTHSTEP) {
        const double width = c.low - b.low;
        if (!IsPoint(b) || !IsPoint(c) || !(std::fabs(width) > 0.0)) {
            return {0.0, 1.0};
        }
        const auto smooth = [&](double x) {
            const double t = std::clamp((x - b.low) / width, 0.0, 1.0);
            return t * t * (3.0 - 2.0 * t);
        };
        return Ordered(smooth(a.low), smooth(a.high));
    }
    if (a.low > 0.0 || a.high < 0.0) { // HDS_MATH_SELECT
        return b;
    }
    return IsPoint(a) ? c : HullOf(b, c);
}

AmountRange Dot(const ValueRange& a, const ValueRange& b) {
    AmountRange sum;
    for (std::size_t k = 0; k < 3; ++k) {
        const bool isSquare = &a == &b;
        const AmountRange size = Absolute(a[k]);
        sum = SumOf(sum, isSquare ? ProductOf(size, size) : ProductOf(a[k], b[k]));
    }
    return sum;
}

ValueRange Spread(const AmountRange& a) {
    return {a, a, a, a};
}

/// Sums of octaves of noise.
AmountRange Octaves(double noise, const AmountRange& octaves, const AmountRange& diminish) {
    const double count = std::clamp(octaves.high, 0.0, double(HDS_MATH_MAX_OCTAVES));
    const double weight = Absolute(diminish).high;
    double sum = 0.0;
    double amplitude = 1.0;
    for (int i = 0; i < int(count); ++i) {
        sum += noise * amplitude;
        amplitude *= weight;
    }
    return {-sum, sum};
}

ValueRange Normalized(const ValueRange& a) {
    ValueRange result{};
    for (std::size_t k = 0; k < 3; ++k) {
        result[k] = {a[k].low >= 0.0 ? 0.0 : -1.0, a[k].high <= 0.0 ? 0.0 : 1.0};
    }
    return result;
}

ValueRange RgbToHsv(const ValueRange& a) {
    const auto most = [&](auto end) { return std::max({end(a[0]), end(a[1]), end(a[2])}); };
    const auto low = [](const AmountRange& range) { return range.low; };
    const auto high = [](const AmountRange& range) { return range.high; };
    const bool isPositive = a[0].low >= 0.0 && a[1].low >= 0.0 && a[2].low >= 0.0;
    const AmountRange saturation = isPositive ? AmountRange{0.0, 1.0} : AmountRange{0.0, kInfinity};
    return {AmountRange{0.0, 1.0}, saturation, AmountRange{most(low), most(high)}, a[3]};
}

ValueRange HsvToRgb(const ValueRange& a) {
    const AmountRange taken = ProductOf(a[1], {0.0, 1.0});
    const AmountRange channel = ProductOf(a[2], Difference({1.0, 1.0}, taken));
    return {channel, channel, channel, a[3]};
}

ValueRange Cross(const ValueRange& a, const ValueRange& b) {
    const auto part = [&](std::size_t i, std::size_t k) {
        return Difference(ProductOf(a[i], b[k]), ProductOf(a[k], b[i]));
    };
    return {part(1, 2), part(2, 0), part(0, 1), AmountRange()};
}

/// Of the three nearest points of the cells around, each at most two cells away in each direction,
/// and farther by what the jitter is beyond 1.
ValueRange Worley(const AmountRange& jitter, double numAxes) {
    const double reach = 1.5 + 0.5 * std::max(Absolute(jitter).high, 1.0);
    const AmountRange distance{0.0, std::sqrt(numAxes) * reach};
    return {distance, distance, distance, AmountRange{0.0, 1.0}};
}

ValueRange OfSpecial(std::uint32_t code, const std::vector<ValueRange>& a) {
    const AmountRange unit{0.0, 1.0};
    const auto three = [](const AmountRange& range) {
        return ValueRange{range, range, range, AmountRange()};
    };
    switch (code) {
    case HDS_MATH_DOT:
        return Spread(Dot(a[0], a[1]));
    case HDS_MATH_CROSS:
        return Cross(a[0], a[1]);
    case HDS_MATH_NORMALIZE:
        return Normalized(a[0]);
    case HDS_MATH_COMBINE:
        return {a[0][0], a[1][0], a[2][0], a[3][0]};
    case HDS_MATH_RGB_TO_HSV:
        return RgbToHsv(a[0]);
    case HDS_MATH_HSV_TO_RGB:
        return HsvToRgb(a[0]);
    case HDS_MATH_NOISE2:
        return Spread({-kNoise2, kNoise2});
    case HDS_MATH_NOISE3:
        return Spread({-kNoise3, kNoise3});
    case HDS_MATH_NOISE2_VECTOR:
        return three({-kNoise2, kNoise2});
    case HDS_MATH_NOISE3_VECTOR:
        return three({-kNoise3, kNoise3});
    case HDS_MATH_CELL2:
    case HDS_MATH_CELL3:
        return Spread(unit);
    case HDS_MATH_FRACTAL2:
        return Spread(Octaves(kNoise2, a[1][0], a[3][0]));
    case HDS_MATH_FRACTAL3:
        return Spread(Octaves(kNoise3, a[1][0], a[3][0]));
    case HDS_MATH_FRACTAL2_VECTOR:
        return three(Octaves(kNoise2, a[1][0], a[3][0]));
    case HDS_MATH_FRACTAL3_VECTOR:
        return three(Octaves(kNoise3, a[1][0], a[3][0]));
    case HDS_MATH_WORLEY2:
        return Worley(a[1][0], 2.0);
    case HDS_MATH_WORLEY3:
        return Worley(a[1][0], 3.0);
    case HDS_MATH_WORLEY2_CELL:
    case HDS_MATH_WORLEY3_CELL:
        return three(unit);
    case HDS_MATH_FLAKE:
        return Spread(unit);
    default: // HDS_MATH_HEXTILE: coordinates of tiles, which look-ups do not mind; their weights
        return {kAny, kAny, unit, kAny};
    }
}

} // namespace

AmountRange Widened(const AmountRange& range) {
    // Floats end at 3e38. Where one end is open the value may also be no number.
    if (!(range.low >= -1e30) || !(range.high <= 1e30)) {
        return kAny;
    }
    const double rounding = 1e-6 * std::max(std::fabs(range.low), std::fabs(range.high));
    return {range.low - rounding, range.high + rounding};
}

AmountRange SumOf(const AmountRange& a, const AmountRange& b) {
    const double low = a.low + b.low;
    const double high = a.high + b.high;
    return std::isnan(low) || std::isnan(high) ? kAny : AmountRange{low, high};
}

AmountRange ProductOf(const AmountRange& a, const AmountRange& b) {
    return RangeOfValues({a.low * b.low, a.low * b.high, a.high * b.low, a.high * b.high});
}

AmountRange HullOf(const AmountRange& a, const AmountRange& b) {
    return {std::min(a.low, b.low), std::max(a.high, b.high)};
}

ValueRange RangeOfMath(std::uint32_t code, const std::vector<ValueRange>& operands) {
    ValueRange result{};
    const bool isFar = std::any_of(operands.begin(), operands.end(), [](const ValueRange& value) {
        return std::any_of(value.begin(), value.end(), [](const AmountRange& one) {
            return !std::isfinite(one.low) || !std::isfinite(one.high);
        });
    });
    if (isFar && (code == HDS_MATH_NORMALIZE || code >= HDS_MATH_RGB_TO_HSV)) {
        result = Spread(kAny); // not a number
    } else if (code >= 48U) {
        result = OfSpecial(code, operands);
    } else {
        for (std::size_t k = 0; k < 4; ++k) {
            const AmountRange& a = operands[0][k];
            result[k] = code >= 32U   ? Of3(code, a, operands[1][k], operands[2][k])
                        : code >= 16U ? Of2(code, a, operands[1][k])
                                      : Of1(code, a);
        }
    }
    for (AmountRange& one : result) {
        one = Widened(one);
    }
    return result;
}

} // namespace hds
