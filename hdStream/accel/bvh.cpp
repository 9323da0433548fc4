// SPDX-License-Identifier: Apache-2.0
#include "hdStream/accel/bvh.h"

#include "hdStream/accel/wideBvh.h"

namespace hds {

Bvh BuildBvh(const std::vector<Bounds>& items, const BvhOptions& options) {
    std::vector<BoxRef> refs = MakeRefs(items);
    return BuildWideBvh(refs, options);
}

} // namespace hds
