// SPDX-License-Identifier: Apache-2.0
// Which binary subtrees become leaves and which become children of one 8-wide node, at least cost.
// Source: Ylitie, Karras, Laine 2017, section 3.1, equations 1 to 3.
// Private to the layer. Explained in docs/accel.md.
#pragma once

#include "hdStream/accel/binaryBvh.h"
#include "hdStream/accel/bvh.h"

#include <array>
#include <memory>

namespace hds {

constexpr int kWidth = 8; ///< children of a node

/// A child of a wide node: a binary subtree.
struct CollapsedChild {
    BinarySubtree tree;
    bool isLeaf;
};

/// The children that one wide node takes.
struct CollapsedChildren {
    std::array<CollapsedChild, kWidth> child;
    int count = 0;
};

/// The optimal choice by dynamic programming: C(n, i) is the least cost of representing the subtree
/// n with at most i roots. Memory: 8 B an item, held until the collapse is done; the costs are held
/// only on the way up.
class CollapsePlan {
public:
    CollapsePlan(const BinaryBvh& binary, const BvhOptions& options);

    /// Children of the wide node that stands for the binary subtree.
    CollapsedChildren Children(const BinarySubtree& tree) const;

private:
    using Costs = std::array<float, kWidth - 1>; ///< [i - 1] = C(n, i)
    /// [i - 1]: roots given to the left child when i are used, 0 when fewer than i are; [0]: 1
    /// leaf, 0 inner; [7]: the split of an inner node's 8 slots.
    using Split = std::array<std::uint8_t, kWidth>;
    Costs Solve(const BinarySubtree& tree);
    Costs SolveInner(const BinarySubtree& tree, const Costs& left, const Costs& right);
    bool MayBeLeaf(const BinarySubtree& tree) const;
    Split SplitOf(const BinarySubtree& tree) const;
    void Gather(const BinarySubtree& tree, int roots, CollapsedChildren* out) const;

    const BinaryBvh& _binary;
    BvhOptions _options;
    std::unique_ptr<Split[]> _splits; ///< of the inner nodes
};

/// The children when depth matters more than area: always opens the subtree of most items. Over a
/// balanced binary tree this takes three binary levels a node.
CollapsedChildren GatherBalanced(const BinaryBvh& binary, const BinarySubtree& tree,
                                 std::uint32_t maxLeafItems);

} // namespace hds
