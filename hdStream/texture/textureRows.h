// SPDX-License-Identifier: Apache-2.0
// An image file as rows of a texture: the values to store, and the same in linear light for
// filtering. See textureForm.h.
#pragma once

#include "hdStream/texture/codeRows.h"
#include "hdStream/texture/keptImage.h"
#include "hdStream/texture/textureForm.h"

#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

namespace hds {

/// Converts linear floats to stored texels. Immutable, thread-safe.
class TexelConverter {
public:
    explicit TexelConverter(std::uint32_t format);
    /// \param linear [numTexels][channels], finite
    /// \param stored [numTexels] of TexelBytes(format)
    void Convert(const float* linear, std::size_t numTexels, std::uint8_t* stored) const;

private:
    std::uint8_t ByteOf(float linear, bool isEncoded) const;

    std::uint32_t _format;
    std::uint32_t _numChannels;
    std::vector<float> _thresholds;   ///< linear value from which on a code is the nearest, sRGB
    std::vector<std::uint8_t> _guess; ///< the least code of a part of [0, 1)
};

/// What was found wrong in an image's values and replaced.
struct TexelRepairs {
    std::uint64_t numNonFinite = 0; ///< NaN by 0, infinities by +-65504
    std::uint64_t numClamped = 0;   ///< beyond what the stored format holds, after decoding
    std::uint64_t numNegative = 0;  ///< of radiance: below 0, by 0
};

/// One line without the file's name; empty when nothing was replaced.
std::string WarningOf(const TexelRepairs& repairs);

/// Decides what of a form depends on the values. \return an error, one line that names the file,
/// or empty
std::string ChooseForm(ImageFile* file, const ColorDecoder& decoder, TextureForm* form);

/// Reads one file. One thread.
class TextureRows {
public:
    /// Rows in order from the top, one by one. \param stored [width] texels as TexelConverter's,
    /// null when they are left out; \param linear [width][channels]
    using RowCallback = std::function<void(const std::uint8_t* stored, const float* linear)>;

    TextureRows(ImageFile* file, const ColorDecoder* decoder, const TextureForm& form);

    /// The largest magnitude of any value, decoded; reads the file once.
    /// \return an error, one line that names the file, or empty
    std::string FindRange(double* largestMagnitude);

    /// Reads the file. \return as FindRange
    std::string Read(const RowCallback& onRow, TexelRepairs* repairs);

    /// Lets Read keep the file's codes. \return null: the form is not verbatim, or they take more
    /// than `maxBytes`
    std::shared_ptr<const KeptImage> Keep(std::uint64_t maxBytes);

    /// From the next row on nobody reads stored texels: only coarser mips are made. While Read
    /// runs, on its thread.
    void LeaveOutStored() { _isStoredLeftOut = true; }

private:
    CodeRows Codes() const;
    std::string ReadCodes(const RowCallback& onRow);
    std::string ReadFloats(const RowCallback& onRow, TexelRepairs* repairs);
    void DecodeRow(const float* pixels, float* linear, TexelRepairs* repairs);
    int Source(std::size_t stored) const;

    ImageFile* _file;
    const ColorDecoder* _decoder;
    TextureForm _form;
    ColorChannels _channels;
    int _begin = 0; ///< channels of the file that are read
    int _end = 0;
    float _limit; ///< of magnitudes
    std::vector<float> _rgb;
    std::shared_ptr<KeptImage> _kept;
    bool _isStoredLeftOut = false;
};

} // namespace hds
