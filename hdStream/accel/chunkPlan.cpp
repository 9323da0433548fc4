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
    ChunkPlanner(const TriangleMesh& mesh, std::uint32_t maxTriangles, std::uint32_t maxVertices)
        : _mesh(mesh), _refs(MakeRefs(mesh.positions, mesh.triangles)), _scratch(_refs.size()),
          _isBegin(_refs.size(), 0), _maxTriangles(maxTriangles), _maxVertices(maxVertices) {}

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
    /// Recursion ends: every cut takes at least a quarter of a chunk or of the range off.
    void Cut(std::size_t begin, std::size_t count, const RangeBounds& bounds) {
        if (count <= _maxTriangles && HasFewVertices(begin, count)) {
            _isBegin[begin] = 1;
            return;
        }
        SplitOptions options;
        options.minSide = std::max<std::size_t>(1, std::min<std::size_t>(_maxTriangles, count) / 4);
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

    /// Counts only where triangles are so many that their vertices could be too many.
    bool HasFewVertices(std::size_t begin, std::size_t count) const {
        if (count <= _maxVertices / 3) {
            return true;
        }
        std::vector<bool> isSeen(_mesh.positions.size());
        std::size_t numVertices = 0;
        for (std::size_t i = begin; i < begin + count; ++i) {
            const glm::uvec3& triangle = _mesh.triangles[_refs[i].item];
            for (int corner = 0; corner < 3; ++corner) {
                numVertices += isSeen[triangle[corner]] ? 0 : 1;
                isSeen[triangle[corner]] = true;
            }
        }
        return numVertices <= _maxVertices;
    }

    const TriangleMesh& _mesh;
    std::vector<BoxRef> _refs;
    std::vector<BoxRef> _scratch;
    std::vector<std::uint8_t> _isBegin; ///< [numTriangles] 1: a chunk begins here
    std::uint32_t _maxTriangles;
    std::uint32_t _maxVertices;
};

} // namespace

ChunkPlan PlanChunks(const TriangleMesh& mesh, std::uint32_t maxTriangles,
                     std::uint32_t maxVertices) {
    HDS_VERIFY(maxTriangles > 0 && maxVertices >= 3, std::to_string(maxTriangles));
    return ChunkPlanner(mesh, maxTriangles, maxVertices).Plan();
}

} // namespace hds
