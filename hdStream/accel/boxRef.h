// SPDX-License-Identifier: Apache-2.0
// The builder's view of an item: its box and its number, 32 bytes, sorted in place while building.
// Private to the layer. Explained in docs/accel.md.
#pragma once

#include "hdStream/accel/simd4.h"
#include "hdStream/geometry/chunkSource.h"

#include <cstdint>
#include <limits>
#include <vector>

namespace hds {

/// A box and the item it stands for. Never holds -0, so that minima and maxima do not depend on the
/// order in which boxes are merged. The inner nodes of the binary tree have this form too, so that
/// a range of references fits where its nodes will be.
struct alignas(16) BoxRef {
    float lo[3];
    std::uint32_t item; ///< of an inner node: how many items are below its left child
    float hi[3];
    std::uint32_t unused;
};
static_assert(sizeof(BoxRef) == 32);

/// Union of boxes and of their centres (both in lanes 0 to 2).
struct RangeBounds {
    Float4 lo = Splat(std::numeric_limits<float>::max());
    Float4 hi = Splat(-std::numeric_limits<float>::max());
    Float4 centreLo = lo;
    Float4 centreHi = hi;

    void Grow(const BoxRef& ref);
    void Grow(const RangeBounds& other);
};

/// Centre of the box; halved before adding, so that it cannot overflow.
inline Float4 Centre(const BoxRef& ref) {
    const Float4 half = Splat(0.5F);
    return LoadBox(ref.lo) * half + LoadBox(ref.hi) * half;
}

inline void RangeBounds::Grow(const BoxRef& ref) {
    const Float4 refLo = LoadBox(ref.lo);
    const Float4 refHi = LoadBox(ref.hi);
    const Float4 half = Splat(0.5F);
    const Float4 centre = refLo * half + refHi * half;
    lo = Min(lo, refLo);
    hi = Max(hi, refHi);
    centreLo = Min(centreLo, centre);
    centreHi = Max(centreHi, centre);
}

inline void RangeBounds::Grow(const RangeBounds& other) {
    lo = Min(lo, other.lo);
    hi = Max(hi, other.hi);
    centreLo = Min(centreLo, other.centreLo);
    centreHi = Max(centreHi, other.centreHi);
}

/// References to boxes, or to the boxes of triangles, in order. Uses all cores.
std::vector<BoxRef> MakeRefs(const std::vector<Bounds>& boxes);
std::vector<BoxRef> MakeRefs(const std::vector<glm::vec3>& positions,
                             const std::vector<glm::uvec3>& triangles);

/// Bounds of refs[begin, end). Uses all cores for long ranges.
RangeBounds ComputeRangeBounds(const BoxRef* refs, std::size_t count);

/// Half the surface area of the box lo..hi.
inline float HalfArea(Float4 lo, Float4 hi) {
    alignas(16) float d[4];
    Store(d, hi - lo);
    return d[0] * d[1] + d[1] * d[2] + d[2] * d[0];
}

} // namespace hds
