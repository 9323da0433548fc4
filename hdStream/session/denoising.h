// SPDX-License-Identifier: Apache-2.0
// What Settings::denoise adds to a render's AOVs, and what it does to its pictures.
// Explained in docs/denoising.md.
#pragma once

#include "hdStream/film/denoiser.h"

#include <string>
#include <vector>

namespace hds {

/// The AOVs with those that guide the denoiser added at the end, unless they are there. Nothing is
/// added without a colour.
std::vector<std::string> WithDenoiserGuides(std::vector<std::string> aovs);

/// Denoises the layer `color`, if there is one, guided by `albedo` and `normal`.
void DenoiseColor(const Denoiser& denoiser, std::vector<ImageLayer>* layers);

} // namespace hds
