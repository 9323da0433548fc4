// SPDX-License-Identifier: Apache-2.0
// The 8-wide compressed hierarchy over references: binary build, collapse, packing into nodes.
// Private to the layer. Explained in docs/accel.md.
#pragma once

#include "hdStream/accel/boxRef.h"
#include "hdStream/accel/bvh.h"

namespace hds {

/// Builds over `refs` (reordered). At most HDS_BVH_MAX_DEPTH nodes lie on a path from the root: a
/// tree by areas that would be deeper is replaced by a balanced one.
Bvh BuildWideBvh(std::vector<BoxRef>& refs, const BvhOptions& options);

/// The same for boxes that move; what lies together is decided by the means of their boxes.
/// \param keys boxes of each item at the keys, in the order of items.
Bvh BuildWideBvh(const std::vector<std::vector<BoxRef>>& keys, const BvhOptions& options);

} // namespace hds
