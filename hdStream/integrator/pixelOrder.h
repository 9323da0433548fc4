// SPDX-License-Identifier: Apache-2.0
// The order in which pixels enter waves.
#pragma once

#include <cstdint>
#include <vector>

namespace hds {

/// All pixels (y * width + x) in tiles of 32 x 32 along a Z curve inside each tile; tiles run in
/// rows, alternately to the right and to the left. Neighbours in the list are neighbours in the
/// image, so that a wave's camera rays touch little of the scene.
std::vector<std::uint32_t> MakePixelOrder(std::uint32_t width, std::uint32_t height);

/// Strides of a first image from coarse to fine, each half of the one before, down to 1. The first
/// is at least 8 and at most 64, and as coarse as leaves 64 pixels: what these take is how long
/// an edit takes to show.
std::vector<std::uint32_t> PreviewStrides(std::uint32_t width, std::uint32_t height);

/// Pixels in the order of a first image.
struct PreviewOrder {
    std::vector<std::uint32_t> pixels;
    std::vector<std::uint32_t> strides; ///< as PreviewStrides
    /// For each of them: so many pixels at the front of the list are all those whose
    /// coordinates are multiples of it.
    std::vector<std::uint32_t> ends;
};

/// The pixels of `order` sorted by the coarsest stride they belong to; otherwise in its order.
PreviewOrder MakePreviewOrder(const std::vector<std::uint32_t>& order, std::uint32_t width,
                              std::uint32_t height);

} // namespace hds
