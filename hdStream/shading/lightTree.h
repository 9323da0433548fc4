// SPDX-License-Identifier: Apache-2.0
// The light tree (kernels/light/select.clh) over the finite lights of a table.
#pragma once

#include "kernels/shared/light.h"

#include <vector>

namespace hds {

/// Builds a balanced binary tree by median splits of the lights' centres along the longest axis and
/// writes each light's treePath. Lights at infinity, which come first, are not in it.
/// Deterministic; the depth is at most ceil(log2(number of lights)), which treePath's 32 bits
/// bound. \return no nodes for fewer than 2 finite lights.
std::vector<shared::HdsLightNode> BuildLightTree(std::vector<shared::HdsLight>& lights);

} // namespace hds
