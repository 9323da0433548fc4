// SPDX-License-Identifier: Apache-2.0
// The sampling table of a dome image (kernels/light/dome.clh).
#pragma once

#include <cstdint>
#include <vector>

namespace hds {

/// A latitude-longitude image in the linear working space, top row first.
struct DomeImage {
    std::uint32_t width = 0;
    std::uint32_t height = 0;
    std::vector<float> rgb; ///< [height][width][3]
};

/// Distribution of a dome's directions, in proportion to the luminance of its bilinear lookup.
struct DomeTable {
    std::vector<float> cdf;     ///< marginal [height + 1], then conditionals [height][width + 1]
    double meanLuminance = 0.0; ///< over the sphere of directions
};

/// Replaces values that are negative or not finite by 0. \return how many there were.
std::size_t SanitizeDomeImage(DomeImage& image);

/// Halves the image (2 x 2 means) until it is at most `maxWidth` wide.
void ShrinkDomeImage(DomeImage& image, std::uint32_t maxWidth);

/// Cost: O(pixels), on all cores; the result does not depend on their number. A black image gives a
/// uniform distribution.
DomeTable BuildDomeTable(const DomeImage& image);

} // namespace hds
