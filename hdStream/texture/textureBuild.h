// SPDX-License-Identifier: Apache-2.0
// The steps of TexturePreparer: the key of a texture, building it from its file, and its
// description as a page of the persistent store.
#pragma once

#include "hdStream/texture/keptImage.h"
#include "hdStream/texture/preparedTexture.h"
#include "hdStream/texture/textureForm.h"

#include <memory>
#include <optional>

namespace hds {

/// Everything a texture depends on: code version, state of the file, byte range, colour space and
/// (where it is a named one) the OpenColorIO configuration, channels.
/// \return empty when the file or the configuration cannot be read: Build says why.
std::optional<PageKey> TextureKey(const ImageSource& source, const TextureRequest& request);

/// A texture and its lines, or with description.error and a fallback.
struct BuiltTexture {
    TextureDescription description;
    std::shared_ptr<LineStore> lines;
    std::shared_ptr<const KeptImage> image; ///< null: not kept
};

/// How much of a texture is made when its file is read.
struct BuildExtent {
    std::uint64_t maxTexels = ~std::uint64_t{0}; ///< of the finest mip whose lines are made
    std::uint64_t maxKeptBytes = 0;              ///< the file's codes are kept up to so many bytes
};

/// Reads the file. Memory: a band of rows, a row of lines a mip, the lines that `store` does not
/// take, and what is kept. \param store may be null
BuiltTexture BuildTexture(const ImageSource& source, const TextureRequest& request,
                          const std::shared_ptr<PageStore>& store, const PageKey& key,
                          const BuildExtent& extent);

/// Reads the file again, and makes those lines of the mip that `line` is of, and of coarser ones,
/// that are not there. \param record of the same file, not constant
/// \return an error, one line that names the file, or empty
std::string BuildLines(const ImageSource& source, const TextureRequest& request,
                       const shared::HdsTexture& record, std::uint32_t line, LineStore* lines);

/// One black opaque texel, and the error.
BuiltTexture MakeMissingTexture(const std::string& error);

/// The record of an image of a form; empty with `error` when it is too large for one.
std::optional<shared::HdsTexture> RecordOf(const ImageFile& file, const TextureForm& form,
                                           std::string* error);

/// Keeps a description; its lines are in the store already.
void SaveDescription(PageStore* store, const PageKey& key, const TextureDescription& description);
/// \return empty when it is not there.
std::optional<TextureDescription> LoadDescription(PageStore* store, const PageKey& key);

} // namespace hds
