// SPDX-License-Identifier: Apache-2.0
// Textures without files for device tests: records and lines as kernels read them, and the same
// texels in double precision. Blocks have texels that the codec keeps exactly, so what a look-up
// says is compared with what was authored, and no decoder stands between the two.
#pragma once

#include "kernels/shared/texture.h"

#include <glm/vec2.hpp>
#include <glm/vec4.hpp>

#include <cstdint>
#include <vector>

namespace hds::test {

/// Arguments of a kernel's HDS_TEXTURE_ARGS where all lines are there, in the order of the macro.
#define HDS_TEST_TEXTURE_ARGS(records, lines) \
    records, records, lines, lines, lines, lines, lines, lines, lines, lines

class TestTextures {
public:
    /// Adds a texture of random texels; mips have nothing to do with each other. In a block of 4x4
    /// a channel takes one of two values, by chance from texel to texel. \return its index.
    std::uint32_t Add(std::uint32_t width, std::uint32_t height, std::uint32_t format,
                      std::uint32_t swizzle, std::uint32_t seed);

    /// Adds floats in RGB, one mip alone, as near as the codec comes to them. \return its index.
    std::uint32_t AddImage(std::uint32_t width, std::uint32_t height,
                           const std::vector<float>& rgb);

    /// As a texture whose image cannot be decoded.
    void MakeUnreadable(std::uint32_t texture) { _records[texture].flags = HDS_TEXTURE_MISSING; }

    const std::vector<shared::HdsTexture>& Records() const { return _records; }
    const std::vector<std::uint32_t>& Lines() const { return _words; }

    /// A texel in linear light, as look-ups show it. \pre the texture is of Add
    glm::dvec4 Texel(std::uint32_t texture, std::uint32_t mip, int x, int y) const;
    static glm::ivec2 MipSize(const shared::HdsTexture& record, std::uint32_t mip);

private:
    std::uint32_t AddRecord(shared::HdsTexture record);
    void WriteBlock(const shared::HdsTexture& record, std::uint32_t mip, glm::uvec2 corner,
                    const void* texels);

    std::vector<shared::HdsTexture> _records;
    std::vector<std::uint32_t> _words;                         ///< of all lines
    std::vector<std::vector<std::vector<glm::dvec4>>> _values; ///< [texture][mip][texel]
};

/// A look-up in double precision: level by the footprint, trilinear, wrap modes.
/// \param axes (s, t) of two conjugate diameters of the footprint
glm::dvec4 LookUp(const TestTextures& textures, std::uint32_t texture, std::uint32_t wrapS,
                  std::uint32_t wrapT, glm::dvec2 st, glm::dvec4 axes, double bias);

} // namespace hds::test
