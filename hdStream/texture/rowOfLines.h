// SPDX-License-Identifier: Apache-2.0
// One row of lines of a mip: takes rows of stored texels, and when it has them all compresses those
// of its lines that are being filled. Explained in docs/texturing.md, section "Mips".
#pragma once

#include "hdStream/texture/lineStore.h"

#include <cstdint>
#include <vector>

namespace hds {

/// Goes from row of lines to row of lines. Used by one thread; blocks are compressed on all threads
/// of TBB.
class RowOfLines {
public:
    /// \param texture its layout; not constant
    RowOfLines(const shared::HdsTexture& texture, std::uint32_t mip, LineStore* lines);

    /// Whether some lines of the mip are being filled.
    bool IsMipFilling() const { return !_rows.empty(); }
    /// Whether some lines of the row of lines that has texel row `row` are being filled.
    bool IsFilling(std::uint32_t row) const;

    /// The row that comes next. \param row the first of a row of lines
    void Begin(std::uint32_t row) { _nextRow = row; }
    /// Takes the next row. \param stored [width] texels
    void AddRow(const std::uint8_t* stored);

    /// Of the mip, in texels.
    std::uint32_t Width() const { return _width; }
    std::uint32_t Height() const { return _height; }
    /// Texel rows of a row of lines.
    std::uint32_t LineHeight() const { return _lineHeight; }

private:
    std::uint32_t FirstLine(std::uint32_t row) const;
    std::size_t RowBytes() const;
    void Encode();
    void EncodeColumn(std::uint32_t column, std::uint32_t numRows);

    shared::HdsTexture _texture;
    std::uint32_t _mip;
    LineStore* _lines;
    std::uint32_t _width;
    std::uint32_t _height;
    std::uint32_t _texelBytes;
    std::uint32_t _lineWidth;  ///< texels
    std::uint32_t _lineHeight; ///< texels
    std::uint32_t _columns;    ///< lines
    bool _isShared;            ///< the mip lies in the line that several share
    std::uint32_t _nextRow = 0;
    std::vector<std::uint8_t> _rows; ///< stored texels, padded to blocks
};

/// Says that the last line of a texture is complete, which several mips share, if it is being
/// filled.
void CompleteLastLine(const shared::HdsTexture& texture, LineStore* lines);

} // namespace hds
