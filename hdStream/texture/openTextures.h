// SPDX-License-Identifier: Apache-2.0
// The textures of a scene that have been opened, and the numbers of their lines among those of all.
// Explained in docs/texturing.md.
#pragma once

#include "hdStream/texture/lineProvider.h"

#include <cstdint>
#include <utility>
#include <vector>

namespace hds {

/// Numbers of lines: first, end.
using LineRange = std::pair<std::uint32_t, std::uint32_t>;

/// Gives lines numbers in the order in which textures are opened, and knows the records that
/// kernels read. 140 bytes a texture. Externally synchronised.
class OpenTextures {
public:
    /// Takes over a provider's textures; those that were open stay open (by id), with the numbers
    /// they have. \return the lines of textures that have gone.
    std::vector<LineRange> Update(const LineProvider& provider);

    /// Numbers the lines of a texture that the provider has opened; no-op when that was done.
    /// \throws Error when there are no numbers left.
    void Add(const LineProvider& provider, std::uint32_t texture);

    bool IsOpen(std::uint32_t texture) const {
        return (_records[texture].flags & HDS_TEXTURE_CLOSED) == 0;
    }
    /// Those that are open, in order.
    std::vector<std::uint32_t> Open() const;
    /// The texture that has a line. \pre there is one.
    LineId Find(std::uint32_t line) const;
    const std::vector<shared::HdsTexture>& Records() const { return _records; }
    /// Numbers below this one have been given.
    std::uint32_t NumLines() const { return _numLines; }
    /// Lines of the textures that are open.
    std::uint32_t NumLiveLines() const { return _numLiveLines; }

private:
    struct Range {
        std::uint32_t firstLine = 0;
        std::uint32_t numLines = 0;
        std::uint32_t texture = 0; ///< HDS_NONE: it has gone
        std::uint64_t id = 0;
    };

    std::vector<shared::HdsTexture> _records; ///< by texture
    std::vector<Range> _ranges;               ///< by firstLine, without gaps
    std::uint32_t _numLines = 0;
    std::uint32_t _numLiveLines = 0;
};

} // namespace hds
