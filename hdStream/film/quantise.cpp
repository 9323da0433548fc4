// SPDX-License-Identifier: Apache-2.0
#include "hdStream/film/quantise.h"

#include "hdStream/base/error.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>

namespace hds {

namespace {

/// Colour of one row as RGB triples, ready for the display transform.
void GatherColor(const float* row, std::size_t width, std::size_t channels, AlphaMode alphaMode,
                 std::vector<float>* rgb) {
    for (std::size_t x = 0; x < width; ++x) {
        const float* pixel = row + x * channels;
        float scale = 1.0f;
        if (channels == 4 && alphaMode == AlphaMode::Unpremultiplied && pixel[3] > 0.0f) {
            scale = 1.0f / pixel[3]; // without coverage there is nothing to divide by: kept
        }
        for (std::size_t c = 0; c < 3; ++c) {
            (*rgb)[3 * x + c] = pixel[std::min(c, channels - 1)] * scale;
        }
    }
}

} // namespace

std::uint8_t QuantiseUnit(float value) {
    if (!(value > 0.0f)) { // NaN too
        return 0;
    }
    return static_cast<std::uint8_t>(
        std::floor(std::min(1.0, static_cast<double>(value)) * 255.0 + 0.5));
}

QuantisedImage QuantiseLayer(const ImageLayer& layer, const DisplayTransform& transform,
                             AlphaMode alphaMode) {
    const std::size_t channels = layer.channels.size();
    HDS_VERIFY(!layer.isInteger && (channels == 1 || channels == 3 || channels == 4),
               "layer '" + layer.name + "' has no 8-bit form");
    QuantisedImage image;
    image.numChannels = channels == 4 && alphaMode == AlphaMode::OverBlack
                            ? 3
                            : static_cast<std::uint32_t>(channels);
    const std::size_t width = layer.width;
    image.values.resize(width * layer.height * image.numChannels);
    tbb::parallel_for(std::size_t{0}, std::size_t{layer.height}, [&](std::size_t y) {
        std::vector<float> rgb(3 * width);
        const float* row = &layer.values[y * width * channels];
        GatherColor(row, width, channels, alphaMode, &rgb);
        transform.Apply(rgb.data(), width);
        std::uint8_t* out = &image.values[y * width * image.numChannels];
        for (std::size_t x = 0; x < width; ++x) {
            for (std::size_t c = 0; c < std::min<std::size_t>(3, image.numChannels); ++c) {
                out[x * image.numChannels + c] = QuantiseUnit(rgb[3 * x + c]);
            }
            if (image.numChannels == 4) {
                out[x * 4 + 3] = QuantiseUnit(row[x * 4 + 3]);
            }
        }
    });
    return image;
}

} // namespace hds
