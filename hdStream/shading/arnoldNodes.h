// SPDX-License-Identifier: Apache-2.0
// Arnold's shaders as those of MaterialX that mean the same. Part of the material compiler. What is
// read, and what is not: docs/materials.md, "Arnold's shaders".
#pragma once

#include "hdStream/base/log.h"
#include "hdStream/shading/materialNetwork.h"

#include <string>

namespace hds {

/// Whether an id is that of a shader of Arnold's that is drawn where a surface hangs on it. Colours
/// are: they are what is seen, whatever the light.
bool IsArnoldSurface(const std::string& identifier);

/// The network with MaterialX's nodes in the place of Arnold's that are known; they keep their
/// paths, and what else they need lies below these. What a node has and is left out warns, with one
/// line a node. Pure but for that; any thread. Source of names, defaults and the conversions
/// between types: Arnold's user guide.
MaterialNetwork TranslateArnold(const MaterialNetwork& network, const std::string& materialPath,
                                Warnings& warnings);

} // namespace hds
