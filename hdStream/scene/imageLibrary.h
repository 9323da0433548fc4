// SPDX-License-Identifier: Apache-2.0
// Images that materials and lights name: read once each, problems warned about once.
#pragma once

#include "hdStream/base/log.h"
#include "hdStream/scene/commit.h"
#include "hdStream/shading/lightTable.h"
#include "hdStream/shading/materialCompiler.h"

#include <map>
#include <mutex>

namespace hds {

/// Mean colours and dome images by file. Thread-safe.
class ImageLibrary {
public:
    explicit ImageLibrary(Warnings& warnings) : _warnings(warnings) {}

    /// The mean colour in linear light; empty when the image cannot be read (the caller warns).
    std::optional<std::array<float, 4>> MeanOf(const AssetReference& asset,
                                               const std::string& colorSpace);

    /// A dome's image; null when it cannot be read (the caller warns).
    std::shared_ptr<const DomeImage> LoadDome(const AssetReference& asset);

    /// All images asked for, each once, in the order of their files.
    std::vector<TextureUse> Uses() const;

private:
    void Record(const AssetReference& asset, const TextureUse& use);

    Warnings& _warnings;
    mutable std::mutex _mutex;
    std::map<std::string, TextureUse> _uses; ///< by file and range
    std::map<std::string, std::optional<std::array<float, 4>>>
        _means; ///< by file, range and colour space
};

} // namespace hds
