// SPDX-License-Identifier: Apache-2.0
// Arnold's checkerboard and ramps as networks of its arithmetic and of MaterialX's nodes. Part of
// arnoldNodes. Formulas: docs/materials.md, "Arnold's shaders".
#pragma once

#include "hdStream/base/log.h"
#include "hdStream/shading/materialNetwork.h"

#include <string>

namespace hds {

/// Whether an id is that of a pattern that ExpandArnoldPatterns replaces.
bool IsArnoldPattern(const std::string& identifier);

/// The network with arnold:mix_rgba in the place of each pattern, which keeps its path; what else
/// it needs lies below. Patterns of kinds whose formula is not public stay as they are. What is
/// left out warns, with one line a node. Pure but for that; any thread.
MaterialNetwork ExpandArnoldPatterns(const MaterialNetwork& network,
                                     const std::string& materialPath, Warnings& warnings);

} // namespace hds
