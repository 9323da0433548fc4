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

Bvh BuildMovingBvh(const std::vector<std::vector<Bounds>>& keys, const BvhOptions& options) {
    std::vector<Bounds> all = keys.front();
    double resting = 0.0;
    double moving = 0.0;
    for (std::size_t i = 0; i < all.size(); ++i) {
        double sum = 0.0;
        for (const std::vector<Bounds>& key : keys) {
            all[i] = {glm::min(all[i].min, key[i].min), glm::max(all[i].max, key[i].max)};
            sum += HalfArea(key[i]);
        }
        resting += HalfArea(all[i]);
        moving += sum / static_cast<double>(keys.size());
    }
    if (!(resting > options.restingArea * moving)) {
        return BuildBvh(all, options);
    }
    std::vector<std::vector<BoxRef>> refs;
    for (const std::vector<Bounds>& key : keys) {
        refs.push_back(MakeRefs(key));
    }
    return BuildWideBvh(refs, options);
}

} // namespace hds
