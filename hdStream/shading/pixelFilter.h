// SPDX-License-Identifier: Apache-2.0
// Pixel filters as tables for importance sampling (kernels/sample/filter.clh).
#pragma once

#include <string>
#include <vector>

namespace hds {

/// The inverse of a separable filter's cumulative distribution along one axis:
/// HDS_FILTER_TABLE_SIZE + 1 offsets in pixels from the pixel's centre, ascending from half the
/// width on the left to 0; entry i belongs to the cumulative share (i / size)^2 / 2. \param name
/// "blackmanHarris" or "box". \param width full width in pixels, > 0. \throws Error (usage) for any
/// other name or width.
std::vector<float> BuildPixelFilterTable(const std::string& name, double width);

/// The filter itself at an offset in pixels: not normalised, 1 at the centre, 0 outside.
double EvaluatePixelFilter(const std::string& name, double width, double offset);

} // namespace hds
