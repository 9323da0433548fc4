// SPDX-License-Identifier: Apache-2.0
#include "hdStream/accel/collapseCost.h"

#include <tbb/parallel_invoke.h>

#include <algorithm>

namespace hds {
namespace {

constexpr std::uint32_t kTaskCount = 16384; ///< items of a subtree from which its halves are tasks

float NodeArea(const BinaryNode& node) {
    return HalfArea(LoadBox(node.lo), LoadBox(node.hi));
}

} // namespace

CollapsePlan::CollapsePlan(const std::vector<BinaryNode>& nodes, const BvhOptions& options)
    : _nodes(nodes), _options(options), _entries(nodes.size()) {
    SolveSubtree(0);
}

void CollapsePlan::SolveSubtree(std::uint32_t node) {
    const BinaryNode& binary = _nodes[node];
    if (binary.count >= kTaskCount) {
        tbb::parallel_invoke([&] { SolveSubtree(node + 1); },
                             [&] { SolveSubtree(node + binary.right); });
        Solve(node);
        return;
    }
    // Children come after their parents.
    for (std::uint32_t i = node + 2 * binary.count - 1; i-- > node;) {
        Solve(i);
    }
}

void CollapsePlan::Solve(std::uint32_t node) {
    const BinaryNode& binary = _nodes[node];
    Entry& entry = _entries[node];
    const float area = NodeArea(binary);
    const float leafCost = area * static_cast<float>(binary.count) * _options.itemCost;
    if (binary.count == 1) {
        for (int i = 0; i < kWidth - 1; ++i) {
            entry.cost[i] = leafCost;
            entry.split[i] = 0;
        }
        entry.split[0] = 1;
        return;
    }
    const Entry& left = _entries[node + 1];
    const Entry& right = _entries[node + binary.right];
    float distribute[kWidth + 1] = {};
    const int numItems = static_cast<int>(std::min<std::uint32_t>(binary.count, kWidth));
    for (int roots = 2; roots <= kWidth; ++roots) {
        if (roots > numItems) { // more roots than items are of no use
            distribute[roots] = distribute[roots - 1];
            entry.split[roots - 1] = entry.split[roots - 2];
            continue;
        }
        float best = left.cost[0] + right.cost[roots - 2];
        int bestLeft = 1;
        for (int k = 2; k < roots; ++k) {
            const float cost = left.cost[k - 1] + right.cost[roots - k - 1];
            if (cost < best) {
                best = cost;
                bestLeft = k;
            }
        }
        distribute[roots] = best;
        entry.split[roots - 1] = static_cast<std::uint8_t>(bestLeft);
    }
    const float innerCost = area * _options.traversalCost + distribute[kWidth];
    const bool isLeaf = binary.count <= _options.maxLeafItems && !(innerCost < leafCost);
    entry.cost[0] = isLeaf ? leafCost : innerCost;
    entry.split[0] = isLeaf ? 1 : 0;
    for (int roots = 2; roots < kWidth; ++roots) {
        if (distribute[roots] < entry.cost[roots - 2]) {
            entry.cost[roots - 1] = distribute[roots];
        } else {
            entry.cost[roots - 1] = entry.cost[roots - 2];
            entry.split[roots - 1] = 0;
        }
    }
}

void CollapsePlan::Gather(std::uint32_t node, std::uint32_t begin, int roots,
                          CollapsedChildren* out) const {
    const Entry& entry = _entries[node];
    while (roots > 1 && entry.split[roots - 1] == 0) {
        --roots;
    }
    if (roots == 1) {
        out->child[out->count++] = {node, begin, entry.split[0] == 1};
        return;
    }
    const int leftRoots = entry.split[roots - 1];
    const std::uint32_t right = _nodes[node].right;
    Gather(node + 1, begin, leftRoots, out);
    Gather(node + right, begin + right / 2, roots - leftRoots, out);
}

CollapsedChildren CollapsePlan::Children(std::uint32_t node, std::uint32_t begin) const {
    CollapsedChildren out;
    const BinaryNode& binary = _nodes[node];
    if (binary.count <= _options.maxLeafItems && _entries[node].split[0] == 1) {
        out.child[out.count++] = {node, begin, true}; // a root that is a leaf
        return out;
    }
    const int leftRoots = _entries[node].split[kWidth - 1];
    Gather(node + 1, begin, leftRoots, &out);
    Gather(node + binary.right, begin + binary.right / 2, kWidth - leftRoots, &out);
    return out;
}

CollapsedChildren GatherBalanced(const std::vector<BinaryNode>& nodes, std::uint32_t node,
                                 std::uint32_t begin, std::uint32_t maxLeafItems) {
    CollapsedChildren out;
    out.child[out.count++] = {node, begin, nodes[node].count <= maxLeafItems};
    while (out.count < kWidth) {
        int largest = -1;
        for (int i = 0; i < out.count; ++i) {
            if (!out.child[i].isLeaf && (largest < 0 || nodes[out.child[i].node].count >
                                                            nodes[out.child[largest].node].count)) {
                largest = i;
            }
        }
        if (largest < 0) {
            break;
        }
        const CollapsedChild opened = out.child[largest];
        const std::uint32_t left = opened.node + 1;
        const std::uint32_t right = opened.node + nodes[opened.node].right;
        out.child[largest] = {left, opened.begin, nodes[left].count <= maxLeafItems};
        out.child[out.count++] = {right, opened.begin + nodes[opened.node].right / 2,
                                  nodes[right].count <= maxLeafItems};
    }
    return out;
}

} // namespace hds
