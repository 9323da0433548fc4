// SPDX-License-Identifier: Apache-2.0
// The sampling tables of images on lights (kernels/light/dome.clh, kernels/light/rectImage.clh).
#pragma once

#include <cstdint>
#include <vector>

namespace hds {

/// An image in the linear working space, top row first.
struct LightImage {
    std::uint32_t width = 0;
    std::uint32_t height = 0;
    std::vector<float> rgb; ///< [height][width][3]
};

/// Distribution of a light's directions or points, in proportion to the luminance of the image's
/// bilinear lookup.
struct LightImageTable {
    std::vector<float> cdf;     ///< marginal [height + 1], then conditionals [height][width + 1]
    double meanLuminance = 0.0; ///< over the sphere of directions, or the image
};

/// Replaces values that are negative or not finite by 0. \return how many there were.
std::size_t SanitizeLightImage(LightImage& image);

/// Halves the image (2 x 2 means) until it is at most `maxWidth` wide.
void ShrinkLightImage(LightImage& image, std::uint32_t maxWidth);

/// For a dome's latitude-longitude image, by solid angle. Cost: O(pixels), on all cores; the result
/// does not depend on their number. A black image gives a uniform distribution.
LightImageTable BuildLatLongTable(const LightImage& image);

/// The same for an image on a flat light, by area.
LightImageTable BuildFlatTable(const LightImage& image);

} // namespace hds
