// SPDX-License-Identifier: Apache-2.0
// Surface shaders and closures of MaterialX that are closures put together: they are replaced by
// those before a network is compiled. Part of the material compiler.
#pragma once

#include "hdStream/shading/materialNetwork.h"

#include <string>
#include <vector>

namespace hds {

/// Whether a surface shader of this id is replaced.
bool HasSurfaceGraph(const std::string& identifier);

/// Ids of closures that are replaced.
std::vector<std::string> ClosureGraphIds();

/// The network with the nodes of all graphs in the place of what they stand for. The last node of a
/// graph has the path of that, what feeds it lies below that path. A UsdPreviewSurface is replaced
/// where it is mixed with another surface. Pure; any thread.
/// Source: MaterialX 1.39, bxdf/disney_principled.mtlx and bxdf/lama.
MaterialNetwork ExpandGraphs(const MaterialNetwork& network);

} // namespace hds
