// SPDX-License-Identifier: Apache-2.0
// Surfaces whose closures (BSDF and EDF nodes of MaterialX) are put together by hand, and mixed
// surfaces. Part of the material compiler. Explained in docs/materials.md.
#pragma once

#include "hdStream/shading/layeredMaterial.h"

#include <string>

namespace hds {

/// Whether a shader id is that of a surface made of closures or of other surfaces.
bool IsClosureSurface(const std::string& identifier);

/// \pre IsClosureSurface(node.identifier)
LayeredMaterial EvaluateClosureSurface(NetworkEvaluator& network, const MaterialNode& node);

} // namespace hds
