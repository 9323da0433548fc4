// SPDX-License-Identifier: Apache-2.0
// Rows of a file's own codes, of 8 or 16 bits, as texels: the codes that are stored, and what they
// stand for in linear light.
#pragma once

#include "hdStream/texture/textureForm.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace hds {

/// Immutable, thread-safe.
class CodeRows {
public:
    /// \param form verbatim
    /// \param places of the stored channels among those of a pixel; -1: filled in with 0, the
    ///        fourth with the largest code
    /// \param numPixelChannels of a pixel as it is read
    CodeRows(const TextureForm& form, bool isSrgb, const std::array<int, 4>& places,
             std::size_t numPixelChannels);

    /// Bytes of a row of so many pixels.
    std::size_t RowBytes(std::size_t width) const;

    /// \param codes [width][numPixelChannels]
    /// \param[out] stored [width] texels; null: not wanted
    /// \param[out] linear [width][channels]; null: not wanted
    void Decode(const void* codes, std::size_t width, std::uint8_t* stored, float* linear) const;

private:
    template <typename T>
    void DecodeAs(const T* codes, std::size_t width, std::uint8_t* stored, float* linear) const;
    template <typename T>
    void DecodeColors(const T* codes, std::size_t width, std::uint8_t* stored, float* linear) const;

    bool _isWide; ///< 16 bits
    std::size_t _numChannels;
    std::array<int, 4> _places;
    std::size_t _stride;
    std::vector<float> _color; ///< linear value of each code
    std::vector<float> _alpha;
    std::array<bool, 4> _isAlpha{};
};

} // namespace hds
