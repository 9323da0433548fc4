// SPDX-License-Identifier: Apache-2.0
// The light tree (kernels/light/select.clh) over the finite lights of a table.
#pragma once

#include "kernels/shared/light.h"

#include <vector>

namespace hds {

/// Builds a binary tree and writes each light's treePath. A node is split where the parts' sums of
/// strength * extent * spread of directions are least, in 16 bins along each axis. Lights at
/// infinity, which come first, are not in it. Deterministic; the depth is at most 31, which
/// treePath's 32 bits and the stack of kernels/light/walk.clh bound. \param cdf lightCdf, which
/// holds the lights' shapings. \return no nodes for fewer than 2 finite lights.
std::vector<shared::HdsLightNode> BuildLightTree(std::vector<shared::HdsLight>& lights,
                                                 const std::vector<float>& cdf);

} // namespace hds
