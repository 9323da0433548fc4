// SPDX-License-Identifier: Apache-2.0
// One channel of a whole image in host memory: what displacement reads. Explained in
// docs/texturing.md.
#pragma once

#include "hdStream/texture/imageReader.h"

#include <cstdint>
#include <string>
#include <vector>

namespace hds {

/// One channel of an image in linear light.
struct ImageChannel {
    std::string error;   ///< one line that names the file; empty when all is well
    std::string warning; ///< one line; often empty
    std::uint32_t width = 0;
    std::uint32_t height = 0;
    std::vector<float> values; ///< rows from the top, finite
};

/// Thread-safe; nothing throws for bad content.
/// \param channel 0 to 3: R, G, B, A; gray is R, G and B, what the file lacks is 0, alpha 1
ImageChannel LoadImageChannel(const ImageSource& source, const std::string& colorSpace,
                              std::uint32_t channel);

} // namespace hds
