// SPDX-License-Identifier: Apache-2.0
#include "hdStream/accel/collapseCost.h"

#include <tbb/parallel_invoke.h>

#include <algorithm>

namespace hds {
namespace {

constexpr std::uint32_t kTaskCount = 16384; ///< items of a subtree from which its halves are tasks

float AreaOf(const BoxRef& box) {
    return HalfArea(LoadBox(box.lo), LoadBox(box.hi));
}

} // namespace

CollapsePlan::CollapsePlan(const BinaryBvh& binary, const BvhOptions& options)
    : _binary(binary), _options(options), _splits(new Split[binary.count]) {
    Solve(binary.Root());
}

CollapsePlan::Costs CollapsePlan::Solve(const BinarySubtree& tree) {
    if (tree.count == 1) {
        Costs costs;
        costs.fill(AreaOf(_binary.Box(tree)) * _options.itemCost);
        return costs;
    }
    const BinarySubtree leftTree = _binary.Left(tree);
    const BinarySubtree rightTree = _binary.Right(tree);
    Costs left;
    Costs right;
    if (tree.count >= kTaskCount) {
        tbb::parallel_invoke([&] { left = Solve(leftTree); }, [&] { right = Solve(rightTree); });
    } else {
        left = Solve(leftTree);
        right = Solve(rightTree);
    }
    return SolveInner(tree, left, right);
}

CollapsePlan::Costs CollapsePlan::SolveInner(const BinarySubtree& tree, const Costs& left,
                                             const Costs& right) {
    Split& split = _splits[tree.node];
    Costs costs;
    const float area = AreaOf(_binary.Box(tree));
    const bool isTogether = _options.unitOfItem != nullptr;
    const float leafCost =
        area * (isTogether ? 1.0F : static_cast<float>(tree.count)) * _options.itemCost;
    float distribute[kWidth + 1] = {};
    const int numItems = static_cast<int>(std::min<std::uint32_t>(tree.count, kWidth));
    for (int roots = 2; roots <= kWidth; ++roots) {
        if (roots > numItems) { // more roots than items are of no use
            distribute[roots] = distribute[roots - 1];
            split[roots - 1] = split[roots - 2];
            continue;
        }
        float best = left[0] + right[roots - 2];
        int bestLeft = 1;
        for (int k = 2; k < roots; ++k) {
            const float cost = left[k - 1] + right[roots - k - 1];
            if (cost < best) {
                best = cost;
                bestLeft = k;
            }
        }
        distribute[roots] = best;
        split[roots - 1] = static_cast<std::uint8_t>(bestLeft);
    }
    const float innerCost = area * _options.traversalCost + distribute[kWidth];
    const bool isLeaf = MayBeLeaf(tree) && !(innerCost < leafCost);
    costs[0] = isLeaf ? leafCost : innerCost;
    split[0] = isLeaf ? 1 : 0;
    for (int roots = 2; roots < kWidth; ++roots) {
        if (distribute[roots] < costs[roots - 2]) {
            costs[roots - 1] = distribute[roots];
        } else {
            costs[roots - 1] = costs[roots - 2];
            split[roots - 1] = 0;
        }
    }
    return costs;
}

bool CollapsePlan::MayBeLeaf(const BinarySubtree& tree) const {
    if (tree.count > _options.maxLeafItems || _options.unitOfItem == nullptr) {
        return tree.count <= _options.maxLeafItems;
    }
    const BoxRef* refs = _binary.refs + tree.begin;
    const std::uint32_t unit = _options.unitOfItem[refs[0].item];
    std::uint32_t size = 0;
    for (const BoxRef* ref = refs; ref != refs + tree.count; ++ref) {
        if (_options.unitOfItem[ref->item] != unit) {
            return false;
        }
        size += _options.sizeOfItem[ref->item];
    }
    return size <= _options.maxLeafItems;
}

CollapsePlan::Split CollapsePlan::SplitOf(const BinarySubtree& tree) const {
    return tree.count == 1 ? Split{1} : _splits[tree.node];
}

void CollapsePlan::Gather(const BinarySubtree& tree, int roots, CollapsedChildren* out) const {
    const Split split = SplitOf(tree);
    while (roots > 1 && split[roots - 1] == 0) {
        --roots;
    }
    if (roots == 1) {
        out->child[out->count++] = {tree, split[0] == 1};
        return;
    }
    const int leftRoots = split[roots - 1];
    Gather(_binary.Left(tree), leftRoots, out);
    Gather(_binary.Right(tree), roots - leftRoots, out);
}

CollapsedChildren CollapsePlan::Children(const BinarySubtree& tree) const {
    CollapsedChildren out;
    const Split split = SplitOf(tree);
    if (tree.count <= _options.maxLeafItems && split[0] == 1) {
        out.child[out.count++] = {tree, true}; // a root that is a leaf
        return out;
    }
    const int leftRoots = split[kWidth - 1];
    Gather(_binary.Left(tree), leftRoots, &out);
    Gather(_binary.Right(tree), kWidth - leftRoots, &out);
    return out;
}

CollapsedChildren GatherBalanced(const BinaryBvh& binary, const BinarySubtree& tree,
                                 std::uint32_t maxLeafItems) {
    CollapsedChildren out;
    out.child[out.count++] = {tree, tree.count <= maxLeafItems};
    while (out.count < kWidth) {
        int largest = -1;
        for (int i = 0; i < out.count; ++i) {
            if (!out.child[i].isLeaf &&
                (largest < 0 || out.child[i].tree.count > out.child[largest].tree.count)) {
                largest = i;
            }
        }
        if (largest < 0) {
            break;
        }
        const BinarySubtree opened = out.child[largest].tree;
        const BinarySubtree left = binary.Left(opened);
        const BinarySubtree right = binary.Right(opened);
        out.child[largest] = {left, left.count <= maxLeafItems};
        out.child[out.count++] = {right, right.count <= maxLeafItems};
    }
    return out;
}

} // namespace hds
