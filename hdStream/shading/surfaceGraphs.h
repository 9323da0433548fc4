// SPDX-License-Identifier: Apache-2.0
// Surface shaders of MaterialX that are closures put together: they are replaced by those before a
// network is compiled. Part of the material compiler.
#pragma once

#include "hdStream/shading/materialNetwork.h"

#include <string>

namespace hds {

/// Whether a surface shader of this id is replaced.
bool HasSurfaceGraph(const std::string& identifier);

/// The network with the nodes of those surfaces in their place. An `ND_surface` has the path of the
/// shader that it stands for, what feeds it lies below that path. Pure; any thread.
/// Source: MaterialX 1.39, bxdf/disney_principled.mtlx.
MaterialNetwork ExpandSurfaceGraphs(const MaterialNetwork& network);

} // namespace hds
