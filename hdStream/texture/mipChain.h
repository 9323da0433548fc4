// SPDX-License-Identifier: Apache-2.0
// From the rows of an image to the compressed lines of all its mips, in one pass: each level keeps
// one row of lines and hands its rows on to the next level's filter, so memory grows with the
// image's width, not with its area. Explained in docs/texturing.md, section "Mips".
#pragma once

#include "hdStream/texture/halvingFilter.h"
#include "hdStream/texture/lineStore.h"
#include "hdStream/texture/textureRows.h"

#include <cstdint>
#include <map>
#include <string>
#include <vector>

namespace hds {

/// Fills a LineStore. Rows are added by one thread; blocks are compressed on all threads of TBB.
class MipChain {
public:
    /// \param texture its layout; not constant
    MipChain(const shared::HdsTexture& texture, LineStore* lines);

    /// Takes the next rows of mip 0, as TextureRows delivers them.
    void AddRows(std::uint32_t numRows, const std::uint8_t* stored, const float* linear);

    /// After the last row: the last line, which several mips share, is complete.
    void Finish();

    /// Lines that equal an earlier one throughout and consist of equal blocks: (line, the earlier
    /// one). After Finish.
    const std::map<std::uint32_t, std::uint32_t>& Repeats() const { return _repeats; }

private:
    struct Level {
        std::uint32_t width;
        std::uint32_t height;
        std::uint32_t nextRow = 0;      ///< rows that have arrived
        std::vector<std::uint8_t> rows; ///< stored texels of one row of lines, padded to blocks
        HalvingFilter toNext;
    };

    void AddRow(std::uint32_t mip, const std::uint8_t* stored, const float* linear);
    void EncodeRowOfLines(std::uint32_t mip);
    void EncodeColumn(std::uint32_t mip, std::uint32_t column, std::uint32_t numRows);
    void FindRepeat(std::uint32_t line);

    shared::HdsTexture _texture;
    LineStore* _lines;
    TexelConverter _converter;
    std::uint32_t _texelBytes;
    std::uint32_t _lineWidth;  ///< texels
    std::uint32_t _lineHeight; ///< texels
    std::vector<Level> _levels;
    std::vector<std::uint8_t> _storedRow;
    std::map<std::vector<std::uint32_t>, std::uint32_t> _lineByBlock; ///< of lines of equal blocks
    std::map<std::uint32_t, std::uint32_t> _repeats;
};

} // namespace hds
