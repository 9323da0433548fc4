// SPDX-License-Identifier: Apache-2.0
// From a layer of linear floats to 8-bit display values, with the alpha rules of PNG and JPEG.
#pragma once

#include "hdStream/film/displayTransform.h"
#include "hdStream/film/imageLayer.h"

#include <cstdint>
#include <vector>

namespace hds {

/// What happens to premultiplied colour and its alpha.
enum class AlphaMode {
    Unpremultiplied, ///< colour is divided by alpha before the display transform (PNG)
    OverBlack,       ///< alpha is dropped, which leaves the image over black (JPEG)
};

/// 8-bit pixels: [height][width][numChannels].
struct QuantisedImage {
    std::uint32_t numChannels = 0; ///< 1, 3 or 4
    std::vector<std::uint8_t> values;
};

/// The 8-bit code nearest to `value` (1 is 255), halves up; NaN is 0, values outside are clamped.
std::uint8_t QuantiseUnit(float value);

/// Quantises a float layer of 1, 3 or 4 (colour and alpha) channels. Rows are done in parallel;
/// each pixel depends on itself only.
QuantisedImage QuantiseLayer(const ImageLayer& layer, const DisplayTransform& transform,
                             AlphaMode alphaMode);

} // namespace hds
