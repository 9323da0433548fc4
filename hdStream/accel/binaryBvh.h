// SPDX-License-Identifier: Apache-2.0
// The binary hierarchy that is collapsed to 8-wide: one item a leaf, nodes in depth-first order.
// Private to the layer. Explained in docs/accel.md.
#pragma once

#include "hdStream/accel/boxRef.h"

#include <vector>

namespace hds {

/// A node of the binary tree. The left child follows its parent; the subtree of n items takes 2n -
/// 1 consecutive nodes and n consecutive references.
struct alignas(16) BinaryNode {
    float lo[3];
    std::uint32_t count; ///< items below; 1: leaf
    float hi[3];
    std::uint32_t right; ///< distance to the right child = 2 * (items of the left child)
};
static_assert(sizeof(BinaryNode) == 32);

/// Deepest binary tree that a build by areas makes; from there on ranges are cut at the median.
constexpr std::uint32_t kMaxBinaryDepth = 96;

/// Builds over `refs`, which it reorders. Uses all cores.
/// \param balanced cut at medians only: depth is the logarithm of the count.
std::vector<BinaryNode> BuildBinaryBvh(std::vector<BoxRef>& refs, bool balanced);

} // namespace hds
