// SPDX-License-Identifier: Apache-2.0
// A material network as the front ends translate it (Hydra's HdMaterialNetwork2 without its types).
#pragma once

#include "hdStream/base/fields.h"

#include <array>
#include <cstdint>
#include <map>
#include <string>
#include <variant>
#include <vector>

namespace hds {

/// A file, or a byte range of one (a texture inside a usdz package), resolved by the front end.
struct AssetReference {
    std::string authoredPath; ///< as written in the scene, for messages
    /// Resolved file; empty: could not be resolved. Of UDIM sets, whose path has "<UDIM>", also a
    /// path into a package: "a.usdz[b.<UDIM>.png]".
    std::string file;
    std::uint64_t offset = 0; ///< bytes
    std::uint64_t size = 0;   ///< bytes; 0: the whole file
    /// Of an image that a light names: the colour space of its attribute; empty: none is said.
    std::string colorSpace = {};

    static constexpr auto Fields() {
        constexpr auto kWhy = "the text does not depend on where a stage lies";
        return FieldList(HDS_FIELD(AssetReference, authoredPath),
                         HDS_FIELD(AssetReference, file).NotInDump(kWhy),
                         HDS_FIELD(AssetReference, offset).NotInDump(kWhy),
                         HDS_FIELD(AssetReference, size).NotInDump(kWhy),
                         HDS_FIELD(AssetReference, colorSpace));
    }
};

/// A parameter value. Vectors of 2 to 4 floats keep their length.
using ParameterValue =
    std::variant<bool, std::int64_t, double, std::vector<float>, std::string, AssetReference>;

/// One shader node; `identifier` is the shader id (UsdPreviewSurface, UsdUVTexture, ...).
struct MaterialNode {
    std::string path;
    std::string identifier;
    std::map<std::string, ParameterValue> parameters;
    struct Connection {
        std::string upstreamPath;
        std::string upstreamOutput;

        static constexpr auto Fields() {
            return FieldList(HDS_FIELD(Connection, upstreamPath),
                             HDS_FIELD(Connection, upstreamOutput));
        }
    };
    std::map<std::string, Connection> connections; ///< by input name (the first source only)

    static constexpr auto Fields() {
        return FieldList(HDS_FIELD(MaterialNode, path), HDS_FIELD(MaterialNode, identifier),
                         HDS_FIELD(MaterialNode, parameters), HDS_FIELD(MaterialNode, connections));
    }
};

/// A network with its terminals ("surface", "displacement", "volume") by node path.
struct MaterialNetwork {
    std::vector<MaterialNode> nodes;
    std::map<std::string, MaterialNode::Connection> terminals;

    static constexpr auto Fields() {
        return FieldList(HDS_FIELD(MaterialNetwork, nodes), HDS_FIELD(MaterialNetwork, terminals));
    }
};

} // namespace hds
