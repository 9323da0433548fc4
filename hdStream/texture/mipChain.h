// SPDX-License-Identifier: Apache-2.0
// From the rows of an image to the compressed lines of its mips, in one pass: each level keeps one
// row of lines and hands its rows on to the next level's filter, so memory grows with the image's
// width, not with its area. Explained in docs/texturing.md, section "Mips".
#pragma once

#include "hdStream/texture/halvingFilter.h"
#include "hdStream/texture/rowOfLines.h"
#include "hdStream/texture/textureRows.h"

#include <cstdint>
#include <vector>

namespace hds {

/// Fills those lines of a LineStore that are being filled. A mip without any is filtered alone, and
/// nothing is filtered beyond the coarsest that has some. Rows are added by one thread.
class MipChain {
public:
    /// \param texture its layout; not constant
    MipChain(const shared::HdsTexture& texture, LineStore* lines);

    /// Takes the next row of mip 0, as TextureRows delivers it. \param stored null unless it is
    /// read
    void AddRow(const std::uint8_t* stored, const float* linear);
    /// Whether stored texels of mip 0 are read.
    bool ReadsStored() const { return !_levels.empty() && _levels.front().row.IsMipFilling(); }

    /// After the last row: the last line, which several mips share, is complete.
    void Finish() { CompleteLastLine(_texture, _lines); }

private:
    struct Level {
        RowOfLines row;
        HalvingFilter toNext;
    };

    shared::HdsTexture _texture;
    LineStore* _lines;
    TexelConverter _converter;
    std::vector<Level> _levels; ///< up to the coarsest that has lines being filled
    std::vector<std::uint8_t> _storedRow;
};

} // namespace hds
