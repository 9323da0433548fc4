// SPDX-License-Identifier: Apache-2.0
#include "hdStream/texture/preparedTexture.h"

#include "hdStream/texture/textureLayout.h"
#include "kernels/shared/textureCodec.h"

#include <algorithm>
#include <iterator>
#include <map>

namespace hds {

PreparedTexture::PreparedTexture(TextureDescription description,
                                 std::shared_ptr<const LineStore> lines, Make make)
    : _description(std::move(description)), _make(std::move(make)), _lines(std::move(lines)) {}

std::shared_ptr<const LineStore> PreparedTexture::Lines() const {
    const std::lock_guard<std::mutex> lock(_mutex);
    return _lines;
}

void PreparedTexture::MakeLines(const std::vector<std::uint32_t>& lines) const {
    const std::lock_guard<std::mutex> making(_making);
    std::vector<std::uint32_t> missing;
    const std::shared_ptr<const LineStore> present = Lines();
    std::copy_if(lines.begin(), lines.end(), std::back_inserter(missing),
                 [&](std::uint32_t line) { return !present->Has(line); });
    if (missing.empty() || _isLost) {
        return; // another thread has made them meanwhile
    }
    std::shared_ptr<const LineStore> made = _make ? _make(missing) : nullptr;
    _isLost = !made;
    if (made) {
        const std::lock_guard<std::mutex> lock(_mutex);
        _lines = std::move(made);
    }
}

bool PreparedTexture::ReadLine(std::uint32_t line, TextureLine* out) const {
    if (Lines()->Read(line, out)) {
        return true;
    }
    MakeLines({line});
    if (Lines()->Read(line, out)) {
        return true;
    }
    out->fill(0);
    return false;
}

void PreparedTexture::ReadLines(std::uint32_t first, std::uint32_t count, TextureLine* out) const {
    if (!Lines()->ReadRun(first, count, out)) {
        for (std::uint32_t i = 0; i < count; ++i) {
            ReadLine(first + i, out + i);
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
    const std::lock_guard<std::mutex> making(_making);
    return Lines()->HostBytes();
}

} // namespace hds
