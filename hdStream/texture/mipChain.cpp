// SPDX-License-Identifier: Apache-2.0
#include "hdStream/texture/mipChain.h"

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

MipChain::MipChain(const shared::HdsTexture& texture, LineStore* lines)
    : _texture(texture), _lines(lines), _converter(texture.format),
      _texelBytes(TexelBytes(texture.format)),
      _lineWidth(4u << shared::texel_lineWidthLog2(texture.format)),
      _lineHeight(4u << shared::texel_lineHeightLog2(texture.format)) {
    const std::uint32_t numChannels = 1u << (texture.format & HDS_TEXEL_CHANNELS_LOG2_MASK);
    for (std::uint32_t mip = 0; mip < texture.numMips; ++mip) {
        const std::uint32_t width = shared::texture_mipSize(texture.width, mip);
        const std::uint32_t height = shared::texture_mipSize(texture.height, mip);
        _levels.push_back(
            {width, height, 0,
             std::vector<std::uint8_t>(std::size_t{PaddedWidth(width)} *
                                       std::min(_lineHeight, PaddedWidth(height)) * _texelBytes),
             HalvingFilter(width, height, numChannels)});
    }
    _storedRow.resize(std::size_t{texture.width} * _texelBytes);
}

void MipChain::AddRows(std::uint32_t numRows, const std::uint8_t* stored, const float* linear) {
    const std::size_t width = _texture.width;
    const std::size_t numChannels = std::size_t{1}
                                    << (_texture.format & HDS_TEXEL_CHANNELS_LOG2_MASK);
    for (std::size_t row = 0; row < numRows; ++row) {
        AddRow(0, stored + row * width * _texelBytes, linear + row * width * numChannels);
    }
}

void MipChain::AddRow(std::uint32_t mip, const std::uint8_t* stored, const float* linear) {
    Level& level = _levels[mip];
    HDS_VERIFY(level.nextRow < level.height, "more rows than the image has");
    const std::size_t rowBytes = std::size_t{PaddedWidth(level.width)} * _texelBytes;
    std::uint8_t* row = &level.rows[rowBytes * (level.nextRow % _lineHeight)];
    std::copy_n(stored, std::size_t{level.width} * _texelBytes, row);
    // Blocks that reach over the edge repeat it: what is there does not widen their intervals.
    for (std::size_t x = level.width; x < PaddedWidth(level.width); ++x) {
        std::copy_n(row + (x - 1) * _texelBytes, _texelBytes, row + x * _texelBytes);
    }
    ++level.nextRow;
    if (level.nextRow % _lineHeight == 0 || level.nextRow == level.height) {
        EncodeRowOfLines(mip);
    }
    if (mip + 1 == _texture.numMips) {
        return;
    }
    if (const float* next = level.toNext.AddRow(linear)) {
        _converter.Convert(next, level.toNext.TargetWidth(), _storedRow.data());
        AddRow(mip + 1, _storedRow.data(), next);
    }
}

void MipChain::EncodeRowOfLines(std::uint32_t mip) {
    Level& level = _levels[mip];
    const std::size_t rowBytes = std::size_t{PaddedWidth(level.width)} * _texelBytes;
    std::uint32_t numRows = (level.nextRow - 1) % _lineHeight + 1;
    for (; numRows % 4 != 0; ++numRows) {
        std::copy_n(&level.rows[rowBytes * (numRows - 1)], rowBytes,
                    &level.rows[rowBytes * numRows]);
    }
    const std::uint32_t top = (level.nextRow - 1) / _lineHeight * _lineHeight;
    const std::uint32_t columns = (level.width + _lineWidth - 1) / _lineWidth;
    const std::uint32_t first = PlaceOf(_texture, mip, 0, top).line;
    const bool isShared = first + 1 == _texture.numLines;
    for (std::uint32_t column = 0; column < columns; ++column) {
        _lines->Open(isShared ? first : first + column);
    }
    const std::uint32_t grain = std::max(1u, kBlocksPerTask * 16 / (_lineWidth * _lineHeight));
    // Isolated: a thread that waits here must not begin another texture, which it may hold a lock
    // of already.
    tbb::this_task_arena::isolate([&] {
        tbb::parallel_for(tbb::blocked_range<std::uint32_t>(0, columns, grain),
                          [&](const tbb::blocked_range<std::uint32_t>& range) {
                              for (std::uint32_t column = range.begin(); column < range.end();
                                   ++column) {
                                  EncodeColumn(mip, column, numRows);
                              }
                          });
    });
    for (std::uint32_t column = 0; column < columns && !isShared; ++column) {
        FindRepeat(first + column);
        _lines->Complete(first + column, 1);
    }
}

void MipChain::EncodeColumn(std::uint32_t mip, std::uint32_t column, std::uint32_t numRows) {
    const Level& level = _levels[mip];
    const std::size_t rowBytes = std::size_t{PaddedWidth(level.width)} * _texelBytes;
    const std::uint32_t top = (level.nextRow - 1) / _lineHeight * _lineHeight;
    const std::uint32_t right = std::min((column + 1) * _lineWidth, level.width);
    const std::uint32_t blockWords = 1u << (shared::texel_blockBytesLog2(_texture.format) - 2);
    std::vector<std::uint8_t> texels(std::size_t{16} * _texelBytes);
    for (std::uint32_t y = 0; y < numRows; y += 4) {
        for (std::uint32_t x = column * _lineWidth; x < right; x += 4) {
            for (std::size_t row = 0; row < 4; ++row) {
                std::copy_n(&level.rows[rowBytes * (y + row) + std::size_t{x} * _texelBytes],
                            4 * _texelBytes, &texels[4 * _texelBytes * row]);
            }
            const shared::HdsTexelPlace place = PlaceOf(_texture, mip, x, top + y);
            const std::uint32_t block =
                ((place.y / 4) << shared::texel_lineWidthLog2(_texture.format)) + place.x / 4;
            EncodeBlock(_texture.format, texels.data(),
                        _lines->Open(place.line)->data() + std::size_t{block} * blockWords);
        }
    }
}

void MipChain::FindRepeat(std::uint32_t line) {
    const TextureLine& words = *_lines->Open(line);
    const std::size_t blockWords = std::size_t{1}
                                   << (shared::texel_blockBytesLog2(_texture.format) - 2);
    if (!std::equal(words.begin() + static_cast<std::ptrdiff_t>(blockWords), words.end(),
                    words.begin())) {
        return;
    }
    const std::vector<std::uint32_t> block(words.begin(),
                                           words.begin() + static_cast<std::ptrdiff_t>(blockWords));
    const auto [known, isNew] = _lineByBlock.emplace(block, line);
    if (!isNew) {
        _repeats.emplace(line, known->second);
    }
}

void MipChain::Finish() {
    _lines->Open(_texture.numLines - 1);
    _lines->Complete(_texture.numLines - 1, 1);
}

} // namespace hds
