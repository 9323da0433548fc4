// SPDX-License-Identifier: Apache-2.0
// Follows the connections of a material network from one shader input to what feeds it. Part of the
// material compiler. Sources: UsdPreviewSurface specification 2.5; MaterialX 1.39 specification,
// standard nodes.
#pragma once

#include "hdStream/base/log.h"
#include "hdStream/shading/imageQueries.h"
#include "hdStream/shading/shaderExpression.h"

#include <array>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

namespace hds {

/// What a node wants to know of an image.
struct ImageRequest {
    ShaderValue coordinates;
    std::uint32_t numComponents = 0;
    std::string input = "file"; ///< names the image
    std::array<float, 4> fallback{};
    std::uint32_t number = 0; ///< of several look-ups of one image
    bool isPeriodic = false;  ///< repeats, whatever the node's address modes are; not tiles
    std::optional<std::uint32_t> wraps = {}; ///< HDS_LOOKUP_WRAPS, whatever else there is
};

/// Evaluates inputs of a network's nodes. Externally synchronised; the arguments must outlive it.
class NetworkEvaluator {
public:
    NetworkEvaluator(const MaterialNetwork& network, const std::string& materialPath,
                     const ImageQueries& images, Warnings& warnings);

    /// The node, or null.
    const MaterialNode* FindNode(const std::string& path) const;

    /// Follows the input's connection; without one, or when it gives nothing, the authored
    /// parameter. Empty: neither. Cycles end with a warning.
    ShaderValue Evaluate(const MaterialNode& node, const std::string& input);

    /// As Evaluate; an input that gives nothing has the fallback, one number spreads over all
    /// components, and what has too few warns and has the fallback. A constant of 3 has the
    /// fallback's fourth.
    ShaderValue EvaluateOr(const MaterialNode& node, const std::string& input,
                           const std::array<float, 4>& fallback, std::uint32_t numComponents);

    /// Warns of an input whose authored constant has another count of numbers than the input.
    void WarnOfWidth(const MaterialNode& node, const std::string& input,
                     std::uint32_t numComponents);

    /// An input's connected node, through nodes that pass it on; null: none.
    const MaterialNode* FindSource(const MaterialNode& node, const std::string& input) const;

    /// An input's authored text; empty: none.
    std::string Text(const MaterialNode& node, const std::string& input) const;

    void Warn(const std::string& text);

    /// The textures that the values evaluated so far read.
    const std::vector<MaterialTexture>& Textures() const { return _textures; }

    /// Of MaterialX's nodes that look images up: the channels that the node has.
    ShaderValue EvaluateImage(const MaterialNode& node, const ImageRequest& request);
    /// Of those: the coordinates that an input has, or the prim's first.
    ShaderValue ImageCoordinates(const MaterialNode& node, const std::string& input = "texcoord");
    /// An output of a UsdUVTexture.
    ShaderValue EvaluateTexture(const MaterialNode& node, const std::string& output);
    ShaderValue EvaluateTransform2d(const MaterialNode& node);

private:
    ShaderValue Parameter(const MaterialNode& node, const std::string& input);
    ShaderValue EvaluateOutput(const MaterialNode& node, const std::string& output);
    ShaderValue MakeImage(const MaterialNode& node, const ImageRequest& request);
    std::uint32_t AddressModeOf(const MaterialNode& node, const std::string& input);
    ShaderValue MakeTexture(const MaterialNode& node);
    std::vector<std::uint32_t> FindTiles(const MaterialNode& node, const AssetReference& file,
                                         const std::string& input, std::vector<ImageFacts>* facts);
    std::uint32_t WrapOf(const MaterialNode& node, const std::string& input,
                         const std::optional<std::uint32_t>& ofFile);
    std::uint32_t AddTexture(const MaterialNode& node, const AssetReference& file,
                             const std::string& input);
    const std::string& _materialPath;
    const ImageQueries& _images;
    Warnings& _warnings;
    std::map<std::string, const MaterialNode*> _nodeByPath;
    std::map<std::string, ShaderValue> _lookups;    ///< by the path of their UsdUVTexture
    std::map<std::string, bool> _hasAlpha;          ///< by the path of their UsdUVTexture
    std::map<std::string, ShaderValue> _transforms; ///< by the path of their UsdTransform2d
    /// Of MaterialX's nodes, by (node, output).
    std::map<std::pair<std::string, std::string>, ShaderValue> _patterns;
    std::vector<MaterialTexture> _textures;
    std::set<std::pair<std::string, std::string>> _visiting; ///< (node, output) on the present walk
};

} // namespace hds
