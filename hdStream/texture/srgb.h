// SPDX-License-Identifier: Apache-2.0
// The sRGB transfer functions in double precision (IEC 61966-2-1:1999, equations 5 and 6), extended
// to negative values by odd symmetry and above 1 by the same power law.
#pragma once

#include <cmath>

namespace hds {

/// Linear light of an encoded value; 1 is white in both.
inline double LinearFromSrgb(double encoded) {
    const double a = std::abs(encoded);
    const double linear = a <= 0.04045 ? a / 12.92 : std::pow((a + 0.055) / 1.055, 2.4);
    return std::copysign(linear, encoded);
}

/// Encoded value of linear light.
inline double SrgbFromLinear(double linear) {
    const double a = std::abs(linear);
    const double encoded = a <= 0.0031308 ? a * 12.92 : 1.055 * std::pow(a, 1.0 / 2.4) - 0.055;
    return std::copysign(encoded, linear);
}

} // namespace hds
