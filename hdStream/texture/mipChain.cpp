// SPDX-License-Identifier: Apache-2.0
#include "hdStream/texture/mipChain.h"

#include "hdStream/texture/textureLayout.h"

namespace hds {

MipChain::MipChain(const shared::HdsTexture& texture, LineStore* lines)
    : _texture(texture), _lines(lines), _converter(texture.format) {
    const std::uint32_t numChannels = 1u << (texture.format & HDS_TEXEL_CHANNELS_LOG2_MASK);
    for (std::uint32_t mip = 0; mip < texture.numMips; ++mip) {
        _levels.push_back(
            {RowOfLines(texture, mip, lines),
             HalvingFilter(shared::texture_mipSize(texture.width, mip),
                           shared::texture_mipSize(texture.height, mip), numChannels)});
    }
    while (!_levels.empty() && !_levels.back().row.IsMipFilling()) {
        _levels.pop_back();
    }
    _storedRow.resize(std::size_t{texture.width} * TexelBytes(texture.format));
}

void MipChain::AddRow(const std::uint8_t* stored, const float* linear) {
    for (std::size_t mip = 0; mip < _levels.size(); ++mip) {
        Level& level = _levels[mip];
        if (level.row.IsMipFilling()) {
            if (mip > 0) {
                _converter.Convert(linear, level.row.Width(), _storedRow.data());
                stored = _storedRow.data();
            }
            level.row.AddRow(stored);
        }
        if (mip + 1 == _levels.size()) {
            return;
        }
        linear = level.toNext.AddRow(linear);
        if (linear == nullptr) {
            return;
        }
    }
}

} // namespace hds
