// SPDX-License-Identifier: Apache-2.0
// The light tree (kernels/light/tree.clh) over the finite lights of a table.
#pragma once

#include "kernels/shared/light.h"

#include <vector>

namespace hds {

/// Builds a tree of nodes with up to eight children and writes each light's treePlace. A binary
/// tree comes first: it is split where the parts' sums of strength * extent * spread of directions
/// are least, in 16 bins along each axis. Lights at infinity, which come first, are not in it.
/// Deterministic; nodes lie on at most 31 levels, which the stack of kernels/light/walk.clh bounds.
/// \param cdf lightCdf, which holds the lights' shapings. \return no nodes without finite lights.
std::vector<shared::HdsLightNode> BuildLightTree(std::vector<shared::HdsLight>& lights,
                                                 const std::vector<float>& cdf);

} // namespace hds
