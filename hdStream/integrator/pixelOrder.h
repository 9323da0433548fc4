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

} // namespace hds
