// SPDX-License-Identifier: Apache-2.0
// What the texture cache of a scene streams: lines of images, and of the grids of volumes.
// Explained in docs/volumes.md, section "Grids".
#pragma once

#include "hdStream/texture/textureLines.h"
#include "hdStream/volume/gridPreparer.h"

#include <cstdint>
#include <vector>

namespace hds {

/// The lines of textures, then those of grids. Externally synchronised.
class SceneLines : public LineProvider {
public:
    /// \param textures, grids must outlive it.
    SceneLines(TextureLines* textures, const PreparedGrids* grids)
        : _textures(textures), _grids(grids) {}

    std::uint32_t NumTextures() const override {
        return _textures->NumTextures() + static_cast<std::uint32_t>(_grids->size());
    }
    std::uint64_t TextureId(std::uint32_t texture) const override;
    std::uint32_t FirstGrid() const override { return _textures->NumTextures(); }
    std::uint64_t MaxLines() const override;
    std::uint64_t GridLines() const override;
    /// As of TextureLines.
    std::uint64_t TotalLines() const;
    bool Open(const std::vector<std::uint32_t>& textures, bool allLines,
              const IsCancelled& isCancelled) override;
    shared::HdsTexture Record(std::uint32_t texture) const override;
    bool Read(const std::vector<LineId>& lines, std::uint8_t* bytes,
              const IsCancelled& isCancelled) override;

private:
    void ReadGrids(const std::vector<LineId>& lines, std::size_t begin, std::size_t end,
                   std::uint8_t* bytes) const;
    bool IsGrid(std::uint32_t texture) const { return texture >= _textures->NumTextures(); }
    const PreparedGrid& Grid(std::uint32_t texture) const {
        return *(*_grids)[texture - _textures->NumTextures()];
    }

    TextureLines* _textures;
    const PreparedGrids* _grids;
};

} // namespace hds
