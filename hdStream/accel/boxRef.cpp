// SPDX-License-Identifier: Apache-2.0
#include "hdStream/accel/boxRef.h"

#include <glm/common.hpp>
#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>
#include <tbb/parallel_reduce.h>

#include <algorithm>

namespace hds {
namespace {

constexpr std::size_t kGrain = 16384; ///< items a task handles at least

/// An empty box (an instance of nothing) becomes the point 0.
BoxRef MakeRef(const glm::vec3& lo, const glm::vec3& hi, std::size_t item) {
    BoxRef ref{};
    const bool isEmpty = !(lo.x <= hi.x && lo.y <= hi.y && lo.z <= hi.z);
    for (int axis = 0; axis < 3; ++axis) {
        ref.lo[axis] = isEmpty ? 0.0F : lo[axis] + 0.0F; // -0 becomes +0
        ref.hi[axis] = isEmpty ? 0.0F : hi[axis] + 0.0F;
    }
    ref.item = static_cast<std::uint32_t>(item);
    return ref;
}

} // namespace

std::vector<BoxRef> MakeRefs(const std::vector<Bounds>& boxes) {
    std::vector<BoxRef> refs(boxes.size());
    tbb::parallel_for(tbb::blocked_range<std::size_t>(0, boxes.size(), kGrain),
                      [&](const tbb::blocked_range<std::size_t>& range) {
                          for (std::size_t i = range.begin(); i != range.end(); ++i) {
                              refs[i] = MakeRef(boxes[i].min, boxes[i].max, i);
                          }
                      });
    return refs;
}

std::vector<BoxRef> MakeRefs(const std::vector<glm::vec3>& positions,
                             const std::vector<glm::uvec3>& triangles) {
    std::vector<BoxRef> refs(triangles.size());
    tbb::parallel_for(tbb::blocked_range<std::size_t>(0, triangles.size(), kGrain),
                      [&](const tbb::blocked_range<std::size_t>& range) {
                          for (std::size_t i = range.begin(); i != range.end(); ++i) {
                              const glm::vec3& a = positions[triangles[i].x];
                              const glm::vec3& b = positions[triangles[i].y];
                              const glm::vec3& c = positions[triangles[i].z];
                              refs[i] = MakeRef(glm::min(glm::min(a, b), c),
                                                glm::max(glm::max(a, b), c), i);
                          }
                      });
    return refs;
}

RangeBounds ComputeRangeBounds(const BoxRef* refs, std::size_t count) {
    const auto grow = [refs](const tbb::blocked_range<std::size_t>& range, RangeBounds bounds) {
        for (std::size_t i = range.begin(); i != range.end(); ++i) {
            bounds.Grow(refs[i]);
        }
        return bounds;
    };
    const tbb::blocked_range<std::size_t> all(0, count, kGrain);
    if (count <= kGrain) {
        return grow(all, {});
    }
    return tbb::parallel_reduce(all, RangeBounds{}, grow, [](RangeBounds a, const RangeBounds& b) {
        a.Grow(b);
        return a;
    });
}

} // namespace hds
