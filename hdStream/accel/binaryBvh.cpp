// SPDX-License-Identifier: Apache-2.0
#include "hdStream/accel/binaryBvh.h"

#include "hdStream/accel/sahSplit.h"

#include <tbb/parallel_invoke.h>

namespace hds {
namespace {

constexpr std::size_t kTaskCount = 4096;     ///< items of both children from which they are tasks
constexpr std::size_t kScratchCount = 65536; ///< items from which a build gets scratch memory

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
        : _refs(refs), _nodes(2 * refs.size() - 1), _balanced(balanced) {
        if (refs.size() >= kScratchCount) {
            _scratch.resize(refs.size());
        }
    }

    std::vector<BinaryNode> Build() {
        BuildRange(0, 0, _refs.size(), ComputeRangeBounds(_refs.data(), _refs.size()),
                   kMaxBinaryDepth);
        return std::move(_nodes);
    }

private:
    /// \param depthLeft levels that this subtree may still take.
    void BuildRange(std::size_t node, std::size_t begin, std::size_t count,
                    const RangeBounds& bounds, std::uint32_t depthLeft) {
        BinaryNode& target = _nodes[node];
        Store(target.lo, bounds.lo);
        Store(target.hi, bounds.hi);
        target.count = static_cast<std::uint32_t>(count);
        target.right = 0;
        if (count == 1) {
            return;
        }
        SplitOptions options;
        options.balanced = _balanced || depthLeft <= CeilLog2(count);
        options.scratch = _scratch.empty() ? nullptr : _scratch.data() + begin;
        const SplitResult split = SplitRange(_refs.data() + begin, count, bounds, options);
        const std::size_t right = 2 * split.numLeft;
        target.right = static_cast<std::uint32_t>(right);
        const auto buildLeft = [&] {
            BuildRange(node + 1, begin, split.numLeft, split.left, depthLeft - 1);
        };
        const auto buildRight = [&] {
            BuildRange(node + right, begin + split.numLeft, count - split.numLeft, split.right,
                       depthLeft - 1);
        };
        if (split.numLeft >= kTaskCount && count - split.numLeft >= kTaskCount) {
            tbb::parallel_invoke(buildLeft, buildRight);
        } else {
            buildLeft();
            buildRight();
        }
    }

    std::vector<BoxRef>& _refs;
    std::vector<BoxRef> _scratch;
    std::vector<BinaryNode> _nodes;
    bool _balanced;
};

} // namespace

std::vector<BinaryNode> BuildBinaryBvh(std::vector<BoxRef>& refs, bool balanced) {
    return BinaryBuilder(refs, balanced).Build();
}

} // namespace hds
