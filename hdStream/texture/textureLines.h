// SPDX-License-Identifier: Apache-2.0
// Images as the texture cache wants them: opened on first request, any line by its number.
// Explained in docs/texturing.md.
#pragma once

#include "hdStream/texture/lineProvider.h"
#include "hdStream/texture/texturePreparer.h"

#include <memory>
#include <vector>

namespace hds {

/// An image in a colour space.
struct TextureImage {
    ImageSource source;
    TextureRequest request;
    std::uint64_t id = 0; ///< equal for equal images and requests
    /// No less than its lines, or LineProvider::kUnknown.
    std::uint64_t maxLines = LineProvider::kUnknown;
};

/// Lines of images. Externally synchronised.
class TextureLines : public LineProvider {
public:
    TextureLines(std::shared_ptr<TexturePreparer> preparer, std::vector<TextureImage> images);

    std::uint32_t NumTextures() const override {
        return static_cast<std::uint32_t>(_images.size());
    }
    std::uint64_t TextureId(std::uint32_t texture) const override { return _images[texture].id; }
    std::uint64_t MaxLines() const override;
    /// All lines: exact for textures that were opened, upper bounds for others. Reads the headers
    /// of those without one.
    std::uint64_t TotalLines() const;
    bool Open(const std::vector<std::uint32_t>& textures, bool allLines,
              const IsCancelled& isCancelled) override;
    /// Opens textures [begin, end) and makes all of their lines that are not there, on all cores.
    /// Blocks.
    void MakeAll(std::uint32_t begin, std::uint32_t end);
    /// Textures that were read and compressed, not found in the store.
    std::uint64_t NumBuilt() const { return _preparer->NumBuilt(); }
    shared::HdsTexture Record(std::uint32_t texture) const override {
        return _textures[texture]->Record();
    }
    bool Read(const std::vector<LineId>& lines, std::uint8_t* bytes,
              const IsCancelled& isCancelled) override;

private:
    bool Make(const std::vector<LineId>& lines, const IsCancelled& isCancelled) const;

    std::shared_ptr<TexturePreparer> _preparer;
    std::vector<TextureImage> _images;
    std::vector<std::shared_ptr<const PreparedTexture>> _textures; ///< null: not opened
};

} // namespace hds
