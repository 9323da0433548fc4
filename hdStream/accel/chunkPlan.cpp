// SPDX-License-Identifier: Apache-2.0
// Cuts a mesh into chunks: the top of the binary tree that a build over the whole mesh would make.
#include "hdStream/accel/bvh.h"
#include "hdStream/accel/sahSplit.h"
#include "hdStream/base/error.h"

#include <tbb/parallel_invoke.h>

namespace hds {
namespace {

constexpr std::size_t kTaskCount = 32768;

class ChunkPlanner {
public:
    ChunkPlanner(const TriangleMesh& mesh, std::uint32_t maxTriangles)
        : _refs(MakeRefs(mesh.positions, mesh.triangles)), _scratch(_refs.size()),
          _isBegin(_refs.size(), 0), _maxTriangles(maxTriangles) {}

    ChunkPlan Plan() {
        ChunkPlan plan;
        if (!_refs.empty()) {
            Cut(0, _refs.size(), ComputeRangeBounds(_refs.data(), _refs.size()));
        }
        plan.order.reserve(_refs.size());
        for (std::size_t i = 0; i < _refs.size(); ++i) {
            if (_isBegin[i] != 0) {
                plan.begin.push_back(static_cast<std::uint32_t>(i));
            }
            plan.order.push_back(_refs[i].item);
        }
        plan.begin.push_back(static_cast<std::uint32_t>(_refs.size()));
        return plan;
    }

private:
    /// Recursion ends: every cut takes at least a quarter of a chunk off, or halves the range.
    void Cut(std::size_t begin, std::size_t count, const RangeBounds& bounds) {
        if (count <= _maxTriangles) {
            _isBegin[begin] = 1;
            return;
        }
        SplitOptions options;
        options.minSide = std::max<std::size_t>(1, _maxTriangles / 4);
        options.scratch = _scratch.data() + begin;
        const SplitResult split = SplitRange(_refs.data() + begin, count, bounds, options);
        const auto cutLeft = [&] { Cut(begin, split.numLeft, split.left); };
        const auto cutRight = [&] {
            Cut(begin + split.numLeft, count - split.numLeft, split.right);
        };
        if (count >= kTaskCount) {
            tbb::parallel_invoke(cutLeft, cutRight);
        } else {
            cutLeft();
            cutRight();
        }
    }

    std::vector<BoxRef> _refs;
    std::vector<BoxRef> _scratch;
    std::vector<std::uint8_t> _isBegin; ///< [numTriangles] 1: a chunk begins here
    std::uint32_t _maxTriangles;
};

} // namespace

ChunkPlan PlanChunks(const TriangleMesh& mesh, std::uint32_t maxTriangles) {
    HDS_VERIFY(maxTriangles > 0, std::to_string(maxTriangles));
    return ChunkPlanner(mesh, maxTriangles).Plan();
}

} // namespace hds
