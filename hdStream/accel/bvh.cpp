// SPDX-License-Identifier: Apache-2.0
#include "hdStream/accel/bvh.h"

#include "hdStream/accel/wideBvh.h"

#include <glm/common.hpp>

namespace hds {
namespace {

double HalfArea(const Bounds& box) {
    const glm::dvec3 size = glm::max(glm::dvec3(box.max) - glm::dvec3(box.min), glm::dvec3(0.0));
    return size.x * size.y + size.y * size.z + size.z * size.x;
}

} // namespace

Bvh BuildBvh(const std::vector<Bounds>& items, const BvhOptions& options) {
    std::vector<BoxRef> refs = MakeRefs(items);
    return BuildWideBvh(refs, options);
}

Bvh BuildBvh(std::vector<Bounds>&& items, const BvhOptions& options) {
    std::vector<BoxRef> refs = MakeRefs(items);
    items = std::vector<Bounds>(); // frees them
    return BuildWideBvh(refs, options);
}

Bvh BuildMovingBvh(const std::vector<Bounds>& open, const std::vector<Bounds>& close,
                   const BvhOptions& options) {
    std::vector<Bounds> both;
    both.reserve(open.size());
    double resting = 0.0;
    double moving = 0.0;
    for (std::size_t i = 0; i < open.size(); ++i) {
        both.push_back({glm::min(open[i].min, close[i].min), glm::max(open[i].max, close[i].max)});
        resting += HalfArea(both[i]);
        moving += 0.5 * (HalfArea(open[i]) + HalfArea(close[i]));
    }
    if (!(resting > options.restingArea * moving)) {
        return BuildBvh(both, options);
    }
    return BuildWideBvh(MakeRefs(open), MakeRefs(close), options);
}

} // namespace hds
