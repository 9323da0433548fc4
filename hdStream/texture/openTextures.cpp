// SPDX-License-Identifier: Apache-2.0
#include "hdStream/texture/openTextures.h"

#include "hdStream/base/error.h"

#include <algorithm>
#include <unordered_map>

namespace hds {

namespace {

shared::HdsTexture ClosedRecord() {
    shared::HdsTexture record{};
    record.width = 1;
    record.height = 1;
    record.numMips = 1;
    record.numLines = 1;
    record.flags = HDS_TEXTURE_CLOSED;
    return record;
}

} // namespace

std::vector<LineRange> OpenTextures::Update(const LineProvider& provider) {
    std::unordered_map<std::uint64_t, std::uint32_t> textureById;
    for (std::uint32_t texture = 0; texture < provider.NumTextures(); ++texture) {
        textureById.emplace(provider.TextureId(texture), texture);
    }
    std::vector<shared::HdsTexture> records(provider.NumTextures(), ClosedRecord());
    std::vector<LineRange> gone;
    _numLiveLines = 0;
    for (Range& range : _ranges) {
        if (range.texture == HDS_NONE) {
            continue;
        }
        const auto found = textureById.find(range.id);
        if (found == textureById.end()) {
            gone.emplace_back(range.firstLine, range.firstLine + range.numLines);
            range.texture = HDS_NONE;
        } else {
            records[found->second] = _records[range.texture];
            range.texture = found->second;
            _numLiveLines += range.numLines;
        }
    }
    _records = std::move(records);
    return gone;
}

void OpenTextures::Add(const LineProvider& provider, std::uint32_t texture) {
    if (IsOpen(texture)) {
        return;
    }
    shared::HdsTexture record = provider.Record(texture);
    if (record.numLines >= HDS_REQUEST_TEXTURE - _numLines) {
        throw Error("textures: more than " + std::to_string(HDS_REQUEST_TEXTURE) + " lines of " +
                    std::to_string(HDS_LINE_BYTES) + " bytes");
    }
    record.firstLine = _numLines;
    record.flags &= ~HDS_TEXTURE_CLOSED;
    _records[texture] = record;
    _ranges.push_back({_numLines, record.numLines, texture, provider.TextureId(texture)});
    _numLines += record.numLines;
    _numLiveLines += record.numLines;
}

std::vector<std::uint32_t> OpenTextures::Open() const {
    std::vector<std::uint32_t> textures;
    for (std::uint32_t texture = 0; texture < _records.size(); ++texture) {
        if (IsOpen(texture)) {
            textures.push_back(texture);
        }
    }
    return textures;
}

LineId OpenTextures::Find(std::uint32_t line) const {
    auto range = std::upper_bound(
        _ranges.begin(), _ranges.end(), line,
        [](std::uint32_t value, const Range& candidate) { return value < candidate.firstLine; });
    HDS_VERIFY(range != _ranges.begin() && (--range)->texture != HDS_NONE &&
                   line - range->firstLine < range->numLines,
               "line " + std::to_string(line) + " belongs to no texture");
    return {range->texture, line - range->firstLine};
}

} // namespace hds
