// SPDX-License-Identifier: Apache-2.0
// Which binary subtrees become leaves and which become children of one 8-wide node, at least cost.
// Source: Ylitie, Karras, Laine 2017, section 3.1, equations 1 to 3.
// Private to the layer. Explained in docs/accel.md.
#pragma once

#include "hdStream/accel/binaryBvh.h"
#include "hdStream/accel/bvh.h"

#include <array>
#include <vector>

namespace hds {

constexpr int kWidth = 8; ///< children of a node

/// A child of a wide node: a binary subtree and the first of its references.
struct CollapsedChild {
    std::uint32_t node;
    std::uint32_t begin;
    bool isLeaf;
};

/// The children that one wide node takes.
struct CollapsedChildren {
    std::array<CollapsedChild, kWidth> child;
    int count = 0;
};

/// The optimal choice by dynamic programming: C(n, i) is the least cost of representing the subtree
/// n with at most i roots. Memory: 36 B a binary node, held until the collapse is done.
class CollapsePlan {
public:
    CollapsePlan(const std::vector<BinaryNode>& nodes, const BvhOptions& options);

    /// Children of the wide node that stands for the binary subtree `node`.
    CollapsedChildren Children(std::uint32_t node, std::uint32_t begin) const;

private:
    /// cost[i - 1] = C(n, i); split[i - 1] = roots given to the left child when i are used, 0 when
    /// fewer than i are; split[0]: 1 leaf, 0 inner; split[7]: the split of an inner node's 8 slots.
    struct Entry {
        float cost[kWidth - 1];
        std::uint8_t split[kWidth];
    };
    void SolveSubtree(std::uint32_t node);
    void Solve(std::uint32_t node);
    void Gather(std::uint32_t node, std::uint32_t begin, int roots, CollapsedChildren* out) const;

    const std::vector<BinaryNode>& _nodes;
    BvhOptions _options;
    std::vector<Entry> _entries;
};

/// The children when depth matters more than area: always opens the subtree of most items. Over a
/// balanced binary tree this takes three binary levels a node.
CollapsedChildren GatherBalanced(const std::vector<BinaryNode>& nodes, std::uint32_t node,
                                 std::uint32_t begin, std::uint32_t maxLeafItems);

} // namespace hds
