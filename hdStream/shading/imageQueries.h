// SPDX-License-Identifier: Apache-2.0
// What the material compiler asks about images, answered by scene's image library. Headers only: no
// texels are read to compile a material.
#pragma once

#include "hdStream/shading/materialNetwork.h"
#include "kernels/shared/program.h"

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

namespace hds {

/// An image that can be read.
struct ImageFacts {
    bool hasAlpha = true;
    /// HDS_WRAP_* that the file asks for; nothing: it does not say.
    std::optional<std::uint32_t> wrapS;
    std::optional<std::uint32_t> wrapT;
};

/// A file of a UDIM set.
struct UdimTile {
    std::uint32_t index = 0; ///< its number - 1001
    AssetReference file;
};

/// Thread-safe functions; each may be empty.
struct ImageQueries {
    /// Nothing: the image cannot be read.
    std::function<std::optional<ImageFacts>(const AssetReference& file)> probe;
    /// The files of a path with "<UDIM>" in it, by index.
    std::function<std::vector<UdimTile>(const AssetReference& pattern)> findTiles;
};

/// An image in a colour space: what commit makes a texture of.
struct MaterialTexture {
    AssetReference file;
    std::string colorSpace;     ///< "raw", "sRGB", "auto" or a named space
    std::uint32_t channels = 0; ///< outputs that are read: bit 0 R to bit 3 A
    bool isRadiance = false;    ///< of a light: no value is negative

    static constexpr auto Fields() {
        return FieldList(
            HDS_FIELD(MaterialTexture, file), HDS_FIELD(MaterialTexture, colorSpace),
            HDS_FIELD(MaterialTexture, channels).NotInKey("its uses share one texture"),
            HDS_FIELD(MaterialTexture, isRadiance));
    }
};

} // namespace hds
