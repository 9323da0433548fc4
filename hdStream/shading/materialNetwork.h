// SPDX-License-Identifier: Apache-2.0
// A material network as the front ends translate it (Hydra's HdMaterialNetwork2 without its types).
#pragma once

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
    std::string file;         ///< resolved file; empty: could not be resolved
    std::uint64_t offset = 0; ///< bytes
    std::uint64_t size = 0;   ///< bytes; 0: the whole file
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
    };
    std::map<std::string, Connection> connections; ///< by input name (the first source only)
};

/// A network with its terminals ("surface", "displacement", "volume") by node path.
struct MaterialNetwork {
    std::vector<MaterialNode> nodes;
    std::map<std::string, MaterialNode::Connection> terminals;
};

} // namespace hds
