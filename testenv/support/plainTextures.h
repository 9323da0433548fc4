// SPDX-License-Identifier: Apache-2.0
// Textures without files for device tests: records and texels as TextureBuffers lays them out, and
// the same texels in double precision.
#pragma once

#include "kernels/shared/residency.h"
#include "kernels/shared/texture.h"

#include <glm/vec2.hpp>
#include <glm/vec4.hpp>

#include <cstdint>
#include <vector>

namespace hds::test {

/// Arguments of a kernel's HDS_TEXTURE_ARGS for one buffer, in the order of the macro.
#define HDS_TEST_TEXTURE_ARGS(records, texels) \
    records, texels, texels, texels, texels, texels, texels, texels, texels

class PlainTextures {
public:
    /// Adds a texture of random texels. \return its index.
    std::uint32_t Add(std::uint32_t width, std::uint32_t height, std::uint32_t format,
                      std::uint32_t swizzle, std::uint32_t seed);

    /// As a texture whose image cannot be decoded.
    void MakeUnreadable(std::uint32_t texture) { _records[texture].flags = HDS_TEXTURE_MISSING; }

    const std::vector<shared::HdsTexture>& Records() const { return _records; }
    const std::vector<std::uint8_t>& Texels() const { return _bytes; }

    /// A texel in linear light, as look-ups show it.
    glm::dvec4 Texel(std::uint32_t texture, std::uint32_t mip, int x, int y) const;
    static glm::ivec2 MipSize(const shared::HdsTexture& record, std::uint32_t mip);

private:
    std::vector<shared::HdsTexture> _records;
    std::vector<std::uint8_t> _bytes;
    std::vector<std::vector<std::vector<glm::dvec4>>> _values; ///< [texture][mip][texel]
};

/// A look-up in double precision: level by the footprint, trilinear, wrap modes.
/// \param axes (s, t) of two conjugate diameters of the footprint
glm::dvec4 LookUp(const PlainTextures& textures, std::uint32_t texture, std::uint32_t wrapS,
                  std::uint32_t wrapT, glm::dvec2 st, glm::dvec4 axes, double bias);

} // namespace hds::test
