// SPDX-License-Identifier: Apache-2.0
// What the texture cache knows of textures: numbered images whose bytes come in lines of 512.
// Neither files nor colours are known here. Explained in docs/texturing.md.
#pragma once

#include "kernels/shared/textureCache.h"

#include <cstdint>
#include <functional>
#include <limits>
#include <vector>

namespace hds {

/// A line of a texture, counted from the texture's line 0.
struct LineId {
    std::uint32_t texture = 0;
    std::uint32_t line = 0;
};

/// The textures of a scene. Each is opened on the first look at it, before that nothing is known of
/// it. What is wrong with an image is no error here: the provider reports it once and has a texture
/// of its fallback; a line that cannot be read any more is filled with the fallback too. Externally
/// synchronised.
class LineProvider {
public:
    static constexpr std::uint64_t kUnknown = std::numeric_limits<std::uint64_t>::max();
    /// Whether to stop. Asked between images by the thread that has called; never again once it has
    /// said so. May be empty.
    using IsCancelled = std::function<bool()>;

    virtual ~LineProvider() = default;
    virtual std::uint32_t NumTextures() const = 0;
    /// What tells textures apart across providers: two with the same id have the same lines.
    virtual std::uint64_t TextureId(std::uint32_t texture) const = 0;
    /// Textures from this one on are grids of volumes, which may have a budget of their own.
    virtual std::uint32_t FirstGrid() const { return NumTextures(); }
    /// No less than the lines of all textures; kUnknown when that would take opening them.
    virtual std::uint64_t MaxLines() const = 0;
    /// Lines of all grids, which MaxLines counts too.
    virtual std::uint64_t GridLines() const { return 0; }
    /// Makes the records of some textures ready, on all cores, and such lines as are cheap to make
    /// with them; Read makes the others. Blocks. \param allLines all of them will be read
    /// \return false when it was cancelled: some were opened, which are ready when they are asked
    /// for again.
    virtual bool Open(const std::vector<std::uint32_t>& textures, bool allLines,
                      const IsCancelled& isCancelled) = 0;
    /// Record of a texture; its firstLine says nothing. \pre the texture was opened.
    virtual shared::HdsTexture Record(std::uint32_t texture) const = 0;
    /// Copies lines of textures that were opened, one after the other, to `bytes`
    /// [lines.size()][HDS_LINE_BYTES]. Blocks. \return false when it was cancelled: the bytes are
    /// of no use, and some lines were made, which are ready when they are asked for again.
    virtual bool Read(const std::vector<LineId>& lines, std::uint8_t* bytes,
                      const IsCancelled& isCancelled) = 0;
};

} // namespace hds
