// SPDX-License-Identifier: Apache-2.0
// Textures for tests of the cache: what is in a line follows from the texture's id and the line's
// number, so that every texel tells where it comes from.
#pragma once

#include "hdStream/texture/lineProvider.h"

#include <array>
#include <cstdint>
#include <cstring>
#include <set>
#include <vector>

namespace hds::test {

constexpr std::uint32_t kLineWords = HDS_LINE_BYTES / sizeof(std::uint32_t);

struct FakeTexture {
    std::uint64_t id = 0;
    std::uint32_t width = 1;
    std::uint32_t height = 1;
    std::uint32_t format = HDS_TEXEL_U8 | 2U; ///< RGBA8
};

/// Word `word` of a line. Every eleventh line repeats one block, one of three.
inline std::uint32_t FakeWord(std::uint64_t id, std::uint32_t line, std::uint32_t word) {
    if (line % 11 == 5) {
        return static_cast<std::uint32_t>(id % 3) + 1;
    }
    std::uint32_t hash = static_cast<std::uint32_t>(id) * 0x9e3779b1U;
    for (const std::uint32_t value : {line, word}) {
        hash = (hash ^ value) * 0x85ebca6bU;
        hash ^= hash >> 13U;
    }
    return hash;
}

/// The record of a texture; firstLine is 0.
inline shared::HdsTexture FakeRecord(const FakeTexture& texture) {
    shared::HdsTexture record{};
    record.width = texture.width;
    record.height = texture.height;
    record.format = texture.format;
    record.swizzle = HDS_SWIZZLE_RGBA;
    const std::uint32_t blocksPerLine =
        HDS_LINE_BYTES >> shared::texel_blockBytesLog2(texture.format);
    const auto blocks = [&](std::uint32_t mip) {
        return (shared::texture_mipSize(texture.width, mip) + 3) / 4 *
               ((shared::texture_mipSize(texture.height, mip) + 3) / 4);
    };
    while (shared::texture_mipSize(texture.width, record.numMips) > 1 ||
           shared::texture_mipSize(texture.height, record.numMips) > 1) {
        ++record.numMips;
    }
    ++record.numMips;
    for (std::uint32_t mip = 0; mip < record.numMips; ++mip) {
        std::uint32_t rest = 0;
        for (std::uint32_t other = mip; other < record.numMips; ++other) {
            rest += blocks(other);
        }
        record.mipBlock[mip] = record.numLines * blocksPerLine;
        if (rest <= blocksPerLine) { // the last line
            for (std::uint32_t other = mip + 1; other < record.numMips; ++other) {
                record.mipBlock[other] = record.mipBlock[other - 1] + blocks(other - 1);
            }
            break;
        }
        const std::uint32_t across = 4U << shared::texel_lineWidthLog2(texture.format);
        const std::uint32_t down = 4U << shared::texel_lineHeightLog2(texture.format);
        record.numLines += (shared::texture_mipSize(texture.width, mip) + across - 1) / across *
                           ((shared::texture_mipSize(texture.height, mip) + down - 1) / down);
    }
    ++record.numLines;
    return record;
}

class FakeTextures : public LineProvider {
public:
    explicit FakeTextures(std::vector<FakeTexture> textures) : _textures(std::move(textures)) {
        for (const FakeTexture& texture : _textures) {
            _records.push_back(FakeRecord(texture));
        }
    }

    std::uint32_t NumTextures() const override {
        return static_cast<std::uint32_t>(_textures.size());
    }
    std::uint64_t TextureId(std::uint32_t texture) const override { return _textures[texture].id; }
    std::uint64_t MaxLines() const override { return maxLines; }
    std::uint32_t FirstGrid() const override { return NumTextures() - numGrids; }
    std::uint64_t GridLines() const override {
        std::uint64_t lines = 0;
        for (std::uint32_t grid = FirstGrid(); grid < NumTextures(); ++grid) {
            lines += _records[grid].numLines;
        }
        return lines;
    }
    bool Open(const std::vector<std::uint32_t>& textures, bool allLines,
              const IsCancelled& isCancelled) override {
        for (const std::uint32_t texture : textures) {
            opened.insert(texture);
            ++numOpens;
            if (isCancelled && isCancelled()) {
                return false;
            }
        }
        return true;
    }
    shared::HdsTexture Record(std::uint32_t texture) const override { return _records[texture]; }
    /// Whether a texture was read before it was opened.
    bool isMisused = false;
    bool Read(const std::vector<LineId>& lines, std::uint8_t* bytes,
              const IsCancelled& isCancelled) override {
        for (const LineId& line : lines) {
            isMisused = isMisused || opened.count(line.texture) == 0;
            for (std::uint32_t word = 0; word < kLineWords; ++word) {
                const std::uint32_t value = FakeWord(_textures[line.texture].id, line.line, word);
                std::memcpy(bytes, &value, sizeof(value));
                bytes += sizeof(value);
            }
            ++numReads;
        }
        return !isCancelled || !isCancelled();
    }

    std::uint64_t TotalLines() const {
        std::uint64_t lines = 0;
        for (const shared::HdsTexture& record : _records) {
            lines += record.numLines;
        }
        return lines;
    }

    std::uint64_t maxLines = kUnknown;
    std::uint32_t numGrids = 0; ///< the last textures stand for grids
    std::set<std::uint32_t> opened;
    std::uint64_t numOpens = 0;
    std::uint64_t numReads = 0;

private:
    std::vector<FakeTexture> _textures;
    std::vector<shared::HdsTexture> _records;
};

} // namespace hds::test
