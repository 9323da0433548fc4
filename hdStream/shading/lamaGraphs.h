// SPDX-License-Identifier: Apache-2.0
// LamA, Industrial Light & Magic's layered materials, as graphs of MaterialX's closures. Part of
// the material compiler. Explained in docs/materials.md, "Closures put together by hand".
#pragma once

#include "hdStream/shading/graphRows.h"

#include <vector>

namespace hds {

/// All closures of LamA, and its surface. Source: MaterialX 1.39, bxdf/lama.
std::vector<NodeGraph> LamaGraphs();

} // namespace hds
