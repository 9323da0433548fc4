// SPDX-License-Identifier: Apache-2.0
// Cuts a range of boxes in two where the surface area heuristic is least, by binning the centres.
// Source: Wald 2007, "On fast Construction of SAH-based Bounding Volume Hierarchies".
// Invariant: the result is a function of the references' order, never of the thread count.
// Private to the layer. Explained in docs/accel.md.
#pragma once

#include "hdStream/accel/boxRef.h"

#include <cstddef>

namespace hds {

/// How a range may be cut.
struct SplitOptions {
    std::size_t minSide = 1; ///< fewest references on a side
    bool balanced = false;   ///< ignore areas: cut at the median
    /// Room for the range but its last reference; enables parallel partition of long ranges.
    BoxRef* scratch = nullptr;
};

/// The outcome: refs[0, numLeft) and refs[numLeft, count), and their bounds.
struct SplitResult {
    std::size_t numLeft = 0;
    RangeBounds left, right;
};

/// Reorders refs[0, count) so that each side is contiguous. Both sides are never empty; a range of
/// equal centres is cut in the middle of its present order.
/// \pre count >= 2, options.minSide <= count / 2, `bounds` are those of the range.
SplitResult SplitRange(BoxRef* refs, std::size_t count, const RangeBounds& bounds,
                       const SplitOptions& options);

} // namespace hds
