// SPDX-License-Identifier: Apache-2.0
// The textures of a scene's materials and lights as the texture layer prepares them.
#pragma once

#include "hdStream/scene/imageLibrary.h"
#include "hdStream/texture/textureLines.h"

#include <vector>

namespace hds {

/// Opens nothing. Bounds of their lines are from the headers that the library has read.
std::vector<TextureImage> MakeTextureImages(const std::vector<MaterialTexture>& textures,
                                            const ImageLibrary& library);

} // namespace hds
