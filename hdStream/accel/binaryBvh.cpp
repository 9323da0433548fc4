// SPDX-License-Identifier: Apache-2.0
#include "hdStream/accel/binaryBvh.h"

#include "hdStream/accel/sahSplit.h"

#include <tbb/parallel_invoke.h>

namespace hds {
namespace {

constexpr std::uint32_t kTaskCount = 4096; ///< items of both children from which they are tasks

std::uint32_t CeilLog2(std::size_t count) {
    std::uint32_t bits = 0;
    while ((std::size_t{1} << bits) < count) {
        ++bits;
    }
    return bits;
}

class BinaryBuilder {
public:
    BinaryBuilder(std::vector<BoxRef>& refs, bool balanced)
        : _refs(refs), _nodes(new BoxRef[refs.size()]), _balanced(balanced) {}

    BinaryBvh Build() {
        const auto count = static_cast<std::uint32_t>(_refs.size());
        BuildRange({0, 0, count}, ComputeRangeBounds(_refs.data(), count), kMaxBinaryDepth);
        return {_refs.data(), std::move(_nodes), count};
    }

private:
    /// \param depthLeft levels that this subtree may still take.
    void BuildRange(const BinarySubtree& tree, const RangeBounds& bounds, std::uint32_t depthLeft) {
        if (tree.count == 1) {
            return;
        }
        SplitOptions options;
        options.balanced = _balanced || depthLeft <= CeilLog2(tree.count);
        // Where the subtree's nodes will be there is nothing yet.
        options.scratch = &_nodes[tree.node];
        const SplitResult split =
            SplitRange(_refs.data() + tree.begin, tree.count, bounds, options);
        BoxRef& node = _nodes[tree.node];
        Store(node.lo, bounds.lo);
        Store(node.hi, bounds.hi);
        node.item = static_cast<std::uint32_t>(split.numLeft); // four lanes were stored
        const BinarySubtree left{tree.node + 1, tree.begin, node.item};
        const BinarySubtree right{tree.node + node.item, tree.begin + node.item,
                                  tree.count - node.item};
        const auto buildLeft = [&] { BuildRange(left, split.left, depthLeft - 1); };
        const auto buildRight = [&] { BuildRange(right, split.right, depthLeft - 1); };
        if (left.count >= kTaskCount && right.count >= kTaskCount) {
            tbb::parallel_invoke(buildLeft, buildRight);
        } else {
            buildLeft();
            buildRight();
        }
    }

    std::vector<BoxRef>& _refs;
    std::unique_ptr<BoxRef[]> _nodes;
    bool _balanced;
};

} // namespace

BinaryBvh BuildBinaryBvh(std::vector<BoxRef>& refs, bool balanced) {
    return BinaryBuilder(refs, balanced).Build();
}

} // namespace hds
