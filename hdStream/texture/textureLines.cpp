// SPDX-License-Identifier: Apache-2.0
#include "hdStream/texture/textureLines.h"

#include "hdStream/base/callerQuestion.h"

#include <tbb/parallel_for.h>

#include <cstring>
#include <map>
#include <numeric>
#include <utility>
#include <vector>

namespace hds {

namespace {

/// Lines that a task reads, so that small rounds of requests are no work for a second core.
constexpr std::size_t kLinesPerTask = 64;

/// Does something for each of `count` images, on all cores. The thread that calls asks after each
/// of its own whether to go on, so who cancels waits for one image a thread.
/// \return false when it was cancelled.
template <typename Action>
bool ForEachImage(std::size_t count, const LineProvider::IsCancelled& isCancelled,
                  const Action& action) {
    CallerQuestion isOver(isCancelled);
    tbb::parallel_for(std::size_t{0}, count, [&](std::size_t i) {
        if (!isOver.IsYes()) {
            action(i);
            isOver.Ask();
        }
    });
    return !isOver.IsYes();
}

} // namespace

TextureLines::TextureLines(std::shared_ptr<TexturePreparer> preparer,
                           std::vector<TextureImage> images)
    : _preparer(std::move(preparer)), _images(std::move(images)), _textures(_images.size()) {}

std::uint64_t TextureLines::MaxLines() const {
    std::uint64_t lines = 0;
    for (std::size_t i = 0; i < _images.size(); ++i) {
        if (!_textures[i] && _images[i].maxLines == kUnknown) {
            return kUnknown;
        }
        lines += _textures[i] ? _textures[i]->NumLines() : _images[i].maxLines;
    }
    return lines;
}

std::uint64_t TextureLines::TotalLines() const {
    std::uint64_t lines = 0;
    for (std::size_t i = 0; i < _images.size(); ++i) {
        if (_textures[i]) {
            lines += _textures[i]->NumLines();
        } else if (_images[i].maxLines != kUnknown) {
            lines += _images[i].maxLines;
        } else {
            const auto record = TexturePreparer::Estimate(_images[i].source, _images[i].request);
            lines += record ? record->numLines : 1; // the fallback
        }
    }
    return lines;
}

bool TextureLines::Open(const std::vector<std::uint32_t>& textures, bool allLines,
                        const IsCancelled& isCancelled) {
    const std::uint64_t texelsAtOnce =
        allLines ? TexturePreparer::kAllTexels : TexturePreparer::kTexelsAtOnce;
    return ForEachImage(textures.size(), isCancelled, [&](std::size_t i) {
        const TextureImage& image = _images[textures[i]];
        if (!_textures[textures[i]]) {
            _textures[textures[i]] = _preparer->Prepare(image.source, image.request, texelsAtOnce);
        }
    });
}

void TextureLines::MakeAll(std::uint32_t begin, std::uint32_t end) {
    std::vector<std::uint32_t> textures(end - begin);
    std::iota(textures.begin(), textures.end(), begin);
    Open(textures, true, {});
    tbb::parallel_for(begin, end, [this](std::uint32_t texture) {
        std::vector<std::uint32_t> lines(_textures[texture]->NumLines());
        std::iota(lines.begin(), lines.end(), 0U);
        _textures[texture]->MakeLines(lines);
    });
}

/// Makes lines that are not there, different textures at once. \return false when it was cancelled.
bool TextureLines::Make(const std::vector<LineId>& lines, const IsCancelled& isCancelled) const {
    std::map<std::uint32_t, std::vector<std::uint32_t>> byTexture;
    for (const LineId& id : lines) {
        byTexture[id.texture].push_back(id.line);
    }
    const std::vector<std::pair<std::uint32_t, std::vector<std::uint32_t>>> ofTextures(
        byTexture.begin(), byTexture.end());
    return ForEachImage(ofTextures.size(), isCancelled, [&](std::size_t i) {
        _textures[ofTextures[i].first]->MakeLines(ofTextures[i].second);
    });
}

bool TextureLines::Read(const std::vector<LineId>& lines, std::uint8_t* bytes,
                        const IsCancelled& isCancelled) {
    std::vector<std::uint8_t> isMissing(lines.size());
    const tbb::blocked_range<std::size_t> all(0, lines.size(), kLinesPerTask);
    tbb::parallel_for(all, [&](const auto& range) {
        for (std::size_t i = range.begin(); i < range.end(); ++i) {
            TextureLine line;
            if (_textures[lines[i].texture]->FindLine(lines[i].line, &line)) {
                std::memcpy(bytes + i * HDS_LINE_BYTES, line.data(), HDS_LINE_BYTES);
            } else {
                isMissing[i] = 1;
            }
        }
    });
    std::vector<LineId> missing;
    for (std::size_t i = 0; i < lines.size(); ++i) {
        if (isMissing[i] != 0) {
            missing.push_back(lines[i]);
        }
    }
    if (!Make(missing, isCancelled)) {
        return false;
    }
    for (std::size_t i = 0; i < lines.size(); ++i) {
        if (isMissing[i] != 0) {
            TextureLine line;
            // A line that is lost is black; the preparer has said so.
            _textures[lines[i].texture]->ReadLine(lines[i].line, &line);
            std::memcpy(bytes + i * HDS_LINE_BYTES, line.data(), HDS_LINE_BYTES);
        }
    }
    return true;
}

} // namespace hds
