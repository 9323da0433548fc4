// SPDX-License-Identifier: Apache-2.0
// Image queries for the tests of the material compiler: no file is opened.
#pragma once

#include "hdStream/shading/materialCompiler.h"
#include "kernels/shared/geometry.h"

#include <optional>
#include <vector>

namespace hds::test {

/// Every image can be read but missing.png; opaque.png has no alpha, mirror.png asks to be
/// mirrored; skin.<UDIM>.png has tiles 1001 and 1004.
inline ImageQueries Images() {
    ImageQueries images;
    images.probe = [](const AssetReference& file) -> std::optional<ImageFacts> {
        if (file.file == "missing.png") {
            return std::nullopt;
        }
        ImageFacts facts;
        facts.hasAlpha = file.file != "opaque.png";
        if (file.file == "mirror.png") {
            facts.wrapS = HDS_WRAP_MIRROR;
            facts.wrapT = HDS_WRAP_CLAMP;
        }
        return facts;
    };
    images.findTiles = [](const AssetReference& pattern) {
        std::vector<UdimTile> tiles;
        if (pattern.file == "skin.<UDIM>.png") {
            tiles.push_back({0, {"", "skin.1001.png", 0, 0}});
            tiles.push_back({3, {"", "skin.1004.png", 0, 0}});
        }
        return tiles;
    };
    return images;
}

} // namespace hds::test
