// SPDX-License-Identifier: Apache-2.0
// The binary hierarchy that is collapsed to 8-wide: one item a leaf, nodes in depth-first order.
// A leaf is its reference and has no node. Private to the layer. Explained in docs/accel.md.
#pragma once

#include "hdStream/accel/boxRef.h"

#include <memory>
#include <vector>

namespace hds {

/// The items refs[begin, begin + count) of a binary tree. Its inner nodes, one less than items, lie
/// next to each other, the subtree's own one first.
struct BinarySubtree {
    std::uint32_t node; ///< of a leaf without a meaning
    std::uint32_t begin;
    std::uint32_t count; ///< 1: leaf
};

/// A binary tree over references that somebody else holds.
struct BinaryBvh {
    const BoxRef* refs = nullptr;    ///< the leaves, from left to right
    std::unique_ptr<BoxRef[]> nodes; ///< inner ones
    std::uint32_t count = 0;         ///< of references

    BinarySubtree Root() const { return {0, 0, count}; }
    /// \pre an inner subtree.
    BinarySubtree Left(const BinarySubtree& tree) const {
        return {tree.node + 1, tree.begin, nodes[tree.node].item};
    }
    BinarySubtree Right(const BinarySubtree& tree) const {
        const std::uint32_t numLeft = nodes[tree.node].item;
        return {tree.node + numLeft, tree.begin + numLeft, tree.count - numLeft};
    }
    const BoxRef& Box(const BinarySubtree& tree) const {
        return tree.count == 1 ? refs[tree.begin] : nodes[tree.node];
    }
};

/// Deepest binary tree that a build by areas makes; from there on ranges are cut at the median.
constexpr std::uint32_t kMaxBinaryDepth = 96;

/// Builds over `refs`, which it reorders. Uses all cores, and no memory but the tree's 32 bytes an
/// item. \pre there are some.
/// \param balanced cut at medians only: depth is the logarithm of the count.
BinaryBvh BuildBinaryBvh(std::vector<BoxRef>& refs, bool balanced);

} // namespace hds
