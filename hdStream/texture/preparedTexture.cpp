// SPDX-License-Identifier: Apache-2.0
#include "hdStream/texture/preparedTexture.h"

#include "hdStream/texture/textureLayout.h"
#include "kernels/shared/textureCodec.h"

namespace hds {

PreparedTexture::PreparedTexture(TextureDescription description,
                                 std::shared_ptr<const LineStore> lines, Restore restore)
    : _description(std::move(description)), _restore(std::move(restore)), _lines(std::move(lines)) {
}

std::shared_ptr<const LineStore> PreparedTexture::Lines() const {
    const std::lock_guard<std::mutex> lock(_mutex);
    return _lines;
}

std::uint32_t PreparedTexture::CanonicalLine(std::uint32_t line) const {
    const auto repeat = _description.repeats.find(line);
    return repeat == _description.repeats.end() ? line : repeat->second;
}

bool PreparedTexture::ReadLine(std::uint32_t line, TextureLine* out) const {
    const std::shared_ptr<const LineStore> lines = Lines();
    if (lines->Read(line, out)) {
        return true;
    }
    const std::lock_guard<std::mutex> lock(_mutex);
    if (_lines == lines && !_isLost) { // else another thread has tried meanwhile
        const std::shared_ptr<const LineStore> restored = _restore ? _restore() : nullptr;
        _isLost = !restored;
        _lines = restored ? restored : _lines;
    }
    if (!_isLost && _lines->Read(line, out)) {
        return true;
    }
    out->fill(0);
    return false;
}

void PreparedTexture::ReadLines(std::uint32_t first, std::vector<TextureLine>* out) const {
    if (!Lines()->ReadRun(first, out)) {
        for (std::size_t i = 0; i < out->size(); ++i) {
            ReadLine(first + static_cast<std::uint32_t>(i), &(*out)[i]);
        }
    }
}

std::vector<float> PreparedTexture::DecodeMip(std::uint32_t mip) const {
    const shared::HdsTexture& record = Record();
    const std::uint32_t width = shared::texture_mipSize(record.width, mip);
    const std::uint32_t height = shared::texture_mipSize(record.height, mip);
    std::vector<float> pixels(std::size_t{4} * width * height);
    std::map<std::uint32_t, TextureLine> lines; // of the present row of lines
    const std::uint32_t lineHeight = 4u << shared::texel_lineHeightLog2(record.format);
    float* out = pixels.data();
    for (std::uint32_t y = 0; y < height; ++y) {
        if (y % lineHeight == 0) {
            lines.clear();
        }
        for (std::uint32_t x = 0; x < width; ++x, out += 4) {
            const shared::HdsTexelPlace place = PlaceOf(record, mip, x, y);
            auto line = lines.find(place.line);
            if (line == lines.end()) {
                line = lines.emplace(place.line, TextureLine{}).first;
                if (!ReadLine(place.line, &line->second)) {
                    return {};
                }
            }
            const shared::float4 texel = shared::swizzle_apply(
                shared::codec_texel(line->second.data(), record.format, place.x, place.y),
                record.swizzle);
            out[0] = texel.x;
            out[1] = texel.y;
            out[2] = texel.z;
            out[3] = texel.w;
        }
    }
    return pixels;
}

std::uint64_t PreparedTexture::HostBytes() const {
    return Lines()->HostBytes();
}

} // namespace hds
