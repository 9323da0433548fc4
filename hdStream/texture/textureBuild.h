// SPDX-License-Identifier: Apache-2.0
// The steps of TexturePreparer: the key of a texture, building it from its file, and its
// description as a page of the persistent store.
#pragma once

#include "hdStream/texture/preparedTexture.h"
#include "hdStream/texture/textureForm.h"

#include <memory>
#include <optional>

namespace hds {

/// Everything a texture depends on: code version, state of the file, byte range, colour space and
/// (where it is a named one) the OpenColorIO configuration, channels.
/// \return empty when the file or the configuration cannot be read: Build says why.
std::optional<PageKey> TextureKey(const ImageSource& source, const TextureRequest& request);

/// A texture and its lines, complete, or with description.error and a fallback.
struct BuiltTexture {
    TextureDescription description;
    std::shared_ptr<LineStore> lines;
};

/// Reads the file. Memory: a band of rows, a row of lines a mip, and the lines that `store` does
/// not take. \param store may be null
BuiltTexture BuildTexture(const ImageSource& source, const TextureRequest& request,
                          const std::shared_ptr<PageStore>& store, const PageKey& key);

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
