// SPDX-License-Identifier: Apache-2.0
// The nodes of the UsdPreviewSurface specification, which MaterialX has as well: ids with and
// without "ND_". The table of what there is: docs/shading.md.
#include "hdStream/shading/patternNode.h"

#include <map>

namespace hds {

namespace {

constexpr std::string_view kReader = "UsdPrimvarReader";

/// Components of a primvar reader's result by the suffix of its id, which names a type of USD or
/// one of MaterialX; 0: no number, or too many.
std::uint32_t ReaderComponents(const std::string& suffix) {
    static const std::map<std::string, std::uint32_t> kComponents = {
        {"float", 1},   {"int", 1},     {"float2", 2}, {"float3", 3},  {"float4", 4},
        {"normal", 3},  {"point", 3},   {"vector", 3}, {"integer", 1}, {"boolean", 1},
        {"vector2", 2}, {"vector3", 3}, {"vector4", 4}};
    const auto found = kComponents.find(suffix);
    return found == kComponents.end() ? 0 : found->second;
}

ShaderValue EvaluateReader(NetworkEvaluator& network, const MaterialNode& node,
                           const std::string& /*output*/) {
    const std::size_t end = node.identifier.find(kReader) + kReader.size() + 1; // and "_"
    const std::uint32_t numComponents =
        end > node.identifier.size() ? 0 : ReaderComponents(node.identifier.substr(end));
    if (numComponents == 0) {
        network.Warn("shader " + node.identifier + " of " + node.path +
                     " gives nothing that can be shown");
        return {};
    }
    network.WarnOfWidth(node, "fallback", numComponents);
    const ShaderValue fallback = network.EvaluateOr(node, "fallback", {}, numComponents);
    const std::string primvar = network.Text(node, "varname");
    if (primvar.empty()) {
        network.Warn(node.path + " names no primvar");
        return fallback;
    }
    return MakePrimvar(primvar, fallback, numComponents);
}

ShaderValue EvaluateTransform2d(NetworkEvaluator& network, const MaterialNode& node,
                                const std::string& /*output*/) {
    return network.EvaluateTransform2d(node);
}

ShaderValue EvaluateTexture(NetworkEvaluator& network, const MaterialNode& node,
                            const std::string& output) {
    return network.EvaluateTexture(node, output);
}

constexpr PatternType kTypes[] = {
    {"UsdUVTexture", &EvaluateTexture},
    {"UsdTransform2d", &EvaluateTransform2d},
    {kReader, &EvaluateReader},
};

} // namespace

PatternTable UsdNodes() {
    return PatternTable(kTypes);
}

} // namespace hds
