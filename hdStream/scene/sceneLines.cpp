// SPDX-License-Identifier: Apache-2.0
#include "hdStream/scene/sceneLines.h"

#include <algorithm>
#include <cstring>
#include <iterator>

namespace hds {

std::uint64_t SceneLines::TextureId(std::uint32_t texture) const {
    return IsGrid(texture) ? Grid(texture).description.id : _textures->TextureId(texture);
}

std::uint64_t SceneLines::MaxLines() const {
    const std::uint64_t most = _textures->MaxLines();
    return most == kUnknown ? most : most + GridLines();
}

std::uint64_t SceneLines::TotalLines() const {
    return _textures->TotalLines() + GridLines();
}

std::uint64_t SceneLines::GridLines() const {
    std::uint64_t sum = 0;
    for (const std::shared_ptr<const PreparedGrid>& grid : *_grids) {
        sum += grid->lines->NumLines();
    }
    return sum;
}

void SceneLines::Open(const std::vector<std::uint32_t>& textures) {
    std::vector<std::uint32_t> images;
    std::copy_if(textures.begin(), textures.end(), std::back_inserter(images),
                 [&](std::uint32_t texture) { return !IsGrid(texture); });
    _textures->Open(images);
}

shared::HdsTexture SceneLines::Record(std::uint32_t texture) const {
    if (!IsGrid(texture)) {
        return _textures->Record(texture);
    }
    return Grid(texture).lines->Record();
}

void SceneLines::Read(const std::vector<LineId>& lines, std::uint8_t* bytes) {
    std::vector<LineId> images;
    std::vector<std::size_t> places;
    for (std::size_t i = 0; i < lines.size(); ++i) {
        if (!IsGrid(lines[i].texture)) {
            images.push_back(lines[i]);
            places.push_back(i);
            continue;
        }
        TextureLine values{}; // zeros when it cannot be read any more
        Grid(lines[i].texture).lines->ReadLine(lines[i].line, &values);
        std::memcpy(bytes + i * HDS_LINE_BYTES, values.data(), HDS_LINE_BYTES);
    }
    if (images.size() == lines.size()) {
        _textures->Read(lines, bytes);
    } else if (!images.empty()) {
        std::vector<std::uint8_t> read(images.size() * HDS_LINE_BYTES);
        _textures->Read(images, read.data());
        for (std::size_t i = 0; i < images.size(); ++i) {
            std::memcpy(bytes + places[i] * HDS_LINE_BYTES, read.data() + i * HDS_LINE_BYTES,
                        HDS_LINE_BYTES);
        }
    }
}

} // namespace hds
