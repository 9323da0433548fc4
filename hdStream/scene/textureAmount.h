// SPDX-License-Identifier: Apache-2.0
// Displacement by an image: a function of texture coordinates for geometry to evaluate on the host.
#pragma once

#include "hdStream/geometry/displacement.h"
#include "hdStream/shading/materialCompiler.h"

#include <memory>
#include <string>

namespace hds {

/// Bilinear look-ups in the image at its finest, with the wrap modes of kernels/texture/lookup.clh.
/// Its range is that of the whole image. \param primvar holds the coordinates; empty: they are
/// `lookup.missing`. \pre lookup.image
std::shared_ptr<const DisplacementAmount> MakeTextureAmount(std::string primvar,
                                                            DisplacementLookup lookup);

} // namespace hds
