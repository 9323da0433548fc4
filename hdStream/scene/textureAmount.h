// SPDX-License-Identifier: Apache-2.0
// Displacement by an image: a function of texture coordinates for geometry to evaluate on the host.
#pragma once

#include "hdStream/geometry/displacement.h"
#include "hdStream/shading/materialCompiler.h"

#include <memory>
#include <string>

namespace hds {

/// Bilinear, at the image's finest. \param wrapS HDS_WRAP_*. \param s, t any; not finite: 0
double LookUpHeight(const HeightImage& image, std::uint32_t wrapS, std::uint32_t wrapT, double s,
                    double t);

/// Of all look-ups in the image.
AmountRange RangeOfHeights(const HeightImage& image, std::uint32_t wrapS, std::uint32_t wrapT);

/// Bilinear look-ups in the image at its finest, with the wrap modes of kernels/texture/lookup.clh.
/// Its range is that of the whole image. \param primvar holds the coordinates; empty: they are
/// `lookup.missing`. \pre lookup.image
std::shared_ptr<const DisplacementAmount> MakeTextureAmount(std::string primvar,
                                                            DisplacementLookup lookup);

} // namespace hds
