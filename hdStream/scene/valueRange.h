// SPDX-License-Identifier: Apache-2.0
// Interval arithmetic of the functions of programs (kernels/shared/programMath.h): what bounds
// displacement by networks. Source of the method: Moore 1966, "Interval Analysis".
#pragma once

#include "hdStream/geometry/displacement.h"

#include <array>
#include <cstdint>
#include <vector>

namespace hds {

/// What the four components of a value lie between; infinite where it cannot be told.
using ValueRange = std::array<AmountRange, 4>;

/// Holds the function `code` (HDS_MATH_*) of all operands within the ranges, and its rounding.
/// \param operands as many as the function has.
ValueRange RangeOfMath(std::uint32_t code, const std::vector<ValueRange>& operands);

/// A range with the rounding of floats.
AmountRange Widened(const AmountRange& range);

AmountRange SumOf(const AmountRange& a, const AmountRange& b);
AmountRange ProductOf(const AmountRange& a, const AmountRange& b);
AmountRange HullOf(const AmountRange& a, const AmountRange& b);

} // namespace hds
