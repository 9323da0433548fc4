// SPDX-License-Identifier: Apache-2.0
#include "hdStream/texture/rowOfLines.h"

#include "hdStream/base/error.h"
#include "hdStream/texture/blockEncoder.h"
#include "hdStream/texture/textureLayout.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>

#include <algorithm>

namespace hds {

namespace {

/// Blocks that one task compresses at least: some tens of microseconds.
constexpr std::uint32_t kBlocksPerTask = 256;

std::uint32_t PaddedWidth(std::uint32_t width) {
    return (width + 3) / 4 * 4;
}

} // namespace

RowOfLines::RowOfLines(const shared::HdsTexture& texture, std::uint32_t mip, LineStore* lines)
    : _texture(texture), _mip(mip), _lines(lines),
      _width(shared::texture_mipSize(texture.width, mip)),
      _height(shared::texture_mipSize(texture.height, mip)),
      _texelBytes(TexelBytes(texture.format)),
      _lineWidth(4u << shared::texel_lineWidthLog2(texture.format)),
      _lineHeight(4u << shared::texel_lineHeightLog2(texture.format)),
      _columns((_width + _lineWidth - 1) / _lineWidth),
      _isShared(FirstLineOf(texture, mip) + 1 == texture.numLines) {
    for (std::uint32_t row = 0; row < _height && _rows.empty(); row += _lineHeight) {
        if (IsFilling(row)) {
            _rows.resize(RowBytes() * std::min(_lineHeight, PaddedWidth(_height)));
        }
    }
}

std::uint32_t RowOfLines::FirstLine(std::uint32_t row) const {
    return PlaceOf(_texture, _mip, 0, row / _lineHeight * _lineHeight).line;
}

std::size_t RowOfLines::RowBytes() const {
    return std::size_t{PaddedWidth(_width)} * _texelBytes;
}

bool RowOfLines::IsFilling(std::uint32_t row) const {
    const std::uint32_t first = FirstLine(row);
    for (std::uint32_t line = first; line < first + (_isShared ? 1 : _columns); ++line) {
        if (_lines->IsFilling(line)) {
            return true;
        }
    }
    return false;
}

void RowOfLines::AddRow(const std::uint8_t* stored) {
    HDS_VERIFY(_nextRow < _height, "more rows than the image has");
    std::uint8_t* row = &_rows[RowBytes() * (_nextRow % _lineHeight)];
    std::copy_n(stored, std::size_t{_width} * _texelBytes, row);
    // Blocks that reach over the edge repeat it: what is there does not widen their intervals.
    for (std::size_t x = _width; x < PaddedWidth(_width); ++x) {
        std::copy_n(row + (x - 1) * _texelBytes, _texelBytes, row + x * _texelBytes);
    }
    ++_nextRow;
    if (_nextRow % _lineHeight == 0 || _nextRow == _height) {
        Encode();
    }
}

void RowOfLines::Encode() {
    std::uint32_t numRows = (_nextRow - 1) % _lineHeight + 1;
    for (; numRows % 4 != 0; ++numRows) {
        std::copy_n(&_rows[RowBytes() * (numRows - 1)], RowBytes(), &_rows[RowBytes() * numRows]);
    }
    const std::uint32_t first = FirstLine(_nextRow - 1);
    const auto lineOf = [&](std::uint32_t column) { return _isShared ? first : first + column; };
    for (std::uint32_t column = 0; column < _columns; ++column) {
        if (_lines->IsFilling(lineOf(column))) {
            _lines->Open(lineOf(column));
        }
    }
    const std::uint32_t grain = std::max(1u, kBlocksPerTask * 16 / (_lineWidth * _lineHeight));
    // Isolated: a thread that waits here must not begin another texture, which it may hold a lock
    // of already.
    tbb::this_task_arena::isolate([&] {
        tbb::parallel_for(tbb::blocked_range<std::uint32_t>(0, _columns, grain),
                          [&](const tbb::blocked_range<std::uint32_t>& range) {
                              for (std::uint32_t i = range.begin(); i < range.end(); ++i) {
                                  if (_lines->IsFilling(lineOf(i))) {
                                      EncodeColumn(i, numRows);
                                  }
                              }
                          });
    });
    for (std::uint32_t column = 0; column < _columns && !_isShared; ++column) {
        if (_lines->IsFilling(first + column)) {
            _lines->Complete(first + column, 1);
        }
    }
}

void RowOfLines::EncodeColumn(std::uint32_t column, std::uint32_t numRows) {
    const std::uint32_t top = (_nextRow - 1) / _lineHeight * _lineHeight;
    const std::uint32_t right = std::min((column + 1) * _lineWidth, _width);
    const std::uint32_t blockWords = 1u << (shared::texel_blockBytesLog2(_texture.format) - 2);
    std::vector<std::uint8_t> texels(std::size_t{16} * _texelBytes);
    for (std::uint32_t y = 0; y < numRows; y += 4) {
        for (std::uint32_t x = column * _lineWidth; x < right; x += 4) {
            for (std::size_t row = 0; row < 4; ++row) {
                std::copy_n(&_rows[RowBytes() * (y + row) + std::size_t{x} * _texelBytes],
                            4 * _texelBytes, &texels[4 * _texelBytes * row]);
            }
            const shared::HdsTexelPlace place = PlaceOf(_texture, _mip, x, top + y);
            const std::uint32_t block =
                ((place.y / 4) << shared::texel_lineWidthLog2(_texture.format)) + place.x / 4;
            EncodeBlock(_texture.format, texels.data(),
                        _lines->Open(place.line)->data() + std::size_t{block} * blockWords);
        }
    }
}

void CompleteLastLine(const shared::HdsTexture& texture, LineStore* lines) {
    const std::uint32_t last = texture.numLines - 1;
    if (lines->IsFilling(last)) {
        lines->Open(last);
        lines->Complete(last, 1);
    }
}

} // namespace hds
