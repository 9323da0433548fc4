// SPDX-License-Identifier: Apache-2.0
#include "hdStream/scene/sceneLines.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cstring>
#include <iterator>

namespace hds {

namespace {

constexpr std::size_t kLinesPerTask = 64;
/// Lines that are this far apart are read at once, with those between: a read of eight costs the
/// CPU a quarter more than one of one.
constexpr std::uint32_t kMaxGap = 8;

} // namespace

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

bool SceneLines::Open(const std::vector<std::uint32_t>& textures, bool allLines,
                      const IsCancelled& isCancelled) {
    std::vector<std::uint32_t> images;
    std::copy_if(textures.begin(), textures.end(), std::back_inserter(images),
                 [&](std::uint32_t texture) { return !IsGrid(texture); });
    return _textures->Open(images, allLines, isCancelled);
}

shared::HdsTexture SceneLines::Record(std::uint32_t texture) const {
    if (!IsGrid(texture)) {
        return _textures->Record(texture);
    }
    return Grid(texture).lines->Record();
}

bool SceneLines::Read(const std::vector<LineId>& lines, std::uint8_t* bytes,
                      const IsCancelled& isCancelled) {
    std::vector<LineId> images;
    std::vector<std::size_t> places;
    for (std::size_t i = 0; i < lines.size(); ++i) {
        if (!IsGrid(lines[i].texture)) {
            images.push_back(lines[i]);
            places.push_back(i);
        }
    }
    if (images.size() < lines.size()) {
        const tbb::blocked_range<std::size_t> all(0, lines.size(), kLinesPerTask);
        tbb::parallel_for(
            all, [&](const auto& range) { ReadGrids(lines, range.begin(), range.end(), bytes); });
    }
    if (images.size() == lines.size()) {
        return _textures->Read(lines, bytes, isCancelled);
    }
    if (!images.empty()) {
        std::vector<std::uint8_t> read(images.size() * HDS_LINE_BYTES);
        if (!_textures->Read(images, read.data(), isCancelled)) {
            return false;
        }
        for (std::size_t i = 0; i < images.size(); ++i) {
            std::memcpy(bytes + places[i] * HDS_LINE_BYTES, read.data() + i * HDS_LINE_BYTES,
                        HDS_LINE_BYTES);
        }
    }
    return true;
}

/// Those of lines [begin, end) that are of grids; zeros when they cannot be read any more. Lines of
/// a grid that lie together are read at once.
void SceneLines::ReadGrids(const std::vector<LineId>& lines, std::size_t begin, std::size_t end,
                           std::uint8_t* bytes) const {
    std::vector<TextureLine> run;
    while (begin < end) {
        const LineId first = lines[begin];
        std::size_t next = begin + 1;
        while (next < end && lines[next].texture == first.texture &&
               lines[next].line > lines[next - 1].line &&
               lines[next].line - lines[next - 1].line <= kMaxGap) {
            ++next;
        }
        const std::uint32_t count = lines[next - 1].line - first.line + 1;
        if (IsGrid(first.texture) && count == next - begin) {
            Grid(first.texture)
                .lines->ReadLines(first.line, count,
                                  reinterpret_cast<TextureLine*>(bytes + begin * HDS_LINE_BYTES));
        } else if (IsGrid(first.texture)) {
            run.resize(std::max<std::size_t>(run.size(), count));
            Grid(first.texture).lines->ReadLines(first.line, count, run.data());
            for (std::size_t i = begin; i < next; ++i) {
                std::memcpy(bytes + i * HDS_LINE_BYTES, run[lines[i].line - first.line].data(),
                            HDS_LINE_BYTES);
            }
        }
        begin = next;
    }
}

} // namespace hds
