// SPDX-License-Identifier: Apache-2.0
#include "hdStream/texture/keptImage.h"

#include "hdStream/base/error.h"
#include "hdStream/texture/halvingFilter.h"
#include "hdStream/texture/rowOfLines.h"
#include "hdStream/texture/textureLayout.h"
#include "hdStream/texture/textureRows.h"

#include <algorithm>
#include <cstring>

namespace hds {

/// Rows of the mips in linear light, each from those of the mip before that it covers.
class KeptImage::LinearRows {
public:
    LinearRows(const KeptImage& image, const shared::HdsTexture& texture)
        : _image(image), _texture(texture),
          _numChannels(1u << (texture.format & HDS_TEXEL_CHANNELS_LOG2_MASK)) {}

    std::vector<float> Row(std::uint32_t mip, std::uint32_t row) const {
        if (mip == 0) {
            std::vector<float> linear(std::size_t{_image._width} * _numChannels);
            _image._rows.Decode(&_image._codes[row * _image._rows.RowBytes(_image._width)],
                                _image._width, nullptr, linear.data());
            return linear;
        }
        const std::uint32_t width = shared::texture_mipSize(_texture.width, mip - 1);
        const std::uint32_t height = shared::texture_mipSize(_texture.height, mip - 1);
        HalvingFilter filter(width, height, _numChannels);
        filter.Begin(row);
        const float* reduced = nullptr;
        for (std::uint32_t source = 2 * row; reduced == nullptr; ++source) {
            HDS_VERIFY(source < height, "a row of a mip needs rows that the mip before lacks");
            reduced = filter.AddRow(Row(mip - 1, source).data());
        }
        return {reduced, reduced + std::size_t{filter.TargetWidth()} * _numChannels};
    }

private:
    const KeptImage& _image;
    const shared::HdsTexture& _texture;
    std::uint32_t _numChannels;
};

KeptImage::KeptImage(const CodeRows& rows, std::uint32_t width, std::uint32_t height)
    : _rows(rows), _width(width), _height(height), _codes(new std::uint8_t[Bytes()]) {}

void KeptImage::AddRow(const void* codes) {
    HDS_VERIFY(_nextRow < _height, "more rows than the image has");
    std::memcpy(&_codes[_nextRow++ * _rows.RowBytes(_width)], codes, _rows.RowBytes(_width));
}

void KeptImage::FillLines(const shared::HdsTexture& texture, LineStore* lines) const {
    const TexelConverter converter(texture.format);
    const LinearRows linear(*this, texture);
    std::vector<std::uint8_t> stored(std::size_t{texture.width} * TexelBytes(texture.format));
    for (std::uint32_t mip = 0; mip < texture.numMips; ++mip) {
        RowOfLines rowOfLines(texture, mip, lines);
        for (std::uint32_t first = 0; first < rowOfLines.Height();
             first += rowOfLines.LineHeight()) {
            if (!rowOfLines.IsFilling(first)) {
                continue;
            }
            const std::uint32_t end =
                std::min(rowOfLines.Height(), first + rowOfLines.LineHeight());
            rowOfLines.Begin(first);
            for (std::uint32_t row = first; row < end; ++row) {
                if (mip == 0) {
                    _rows.Decode(&_codes[row * _rows.RowBytes(_width)], _width, stored.data(),
                                 nullptr);
                } else {
                    converter.Convert(linear.Row(mip, row).data(), rowOfLines.Width(),
                                      stored.data());
                }
                rowOfLines.AddRow(stored.data());
            }
        }
    }
    CompleteLastLine(texture, lines);
}

void KeptImages::Add(const PageKey& key, std::shared_ptr<const KeptImage> image) {
    const std::lock_guard<std::mutex> lock(_mutex);
    const auto sameKey = [&](const Entry& entry) { return entry.key == key; };
    if (!Fits(image->Bytes()) || std::any_of(_entries.begin(), _entries.end(), sameKey)) {
        return;
    }
    _bytes += image->Bytes();
    _entries.push_front({key, std::move(image)});
    while (_bytes > _maxBytes) {
        _bytes -= _entries.back().image->Bytes();
        _entries.pop_back();
    }
}

std::shared_ptr<const KeptImage> KeptImages::Find(const PageKey& key) {
    const std::lock_guard<std::mutex> lock(_mutex);
    for (auto entry = _entries.begin(); entry != _entries.end(); ++entry) {
        if (entry->key == key) {
            _entries.splice(_entries.begin(), _entries, entry);
            return entry->image;
        }
    }
    return nullptr;
}

} // namespace hds
