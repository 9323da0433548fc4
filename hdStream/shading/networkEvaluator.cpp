// SPDX-License-Identifier: Apache-2.0
// Evaluation of UsdPreviewSurface's helper nodes. Source: UsdPreviewSurface specification 2.5.
#include "hdStream/shading/networkEvaluator.h"

#include <algorithm>
#include <cmath>

namespace hds {

namespace {

const std::string kReaderPrefix = "UsdPrimvarReader_";

/// Components of a primvar reader's result by the suffix of its id; 0: not a numeric reader.
std::uint32_t ReaderComponents(const std::string& suffix) {
    static const std::map<std::string, std::uint32_t> kComponents = {
        {"float", 1},  {"int", 1},    {"float2", 2}, {"float3", 3},
        {"float4", 4}, {"normal", 3}, {"point", 3},  {"vector", 3}};
    const auto found = kComponents.find(suffix);
    return found == kComponents.end() ? 0 : found->second;
}

InputValue MakeConstant(const std::array<float, 4>& value, std::uint32_t numComponents) {
    InputValue result;
    result.kind = InputValue::Kind::Constant;
    result.value = value;
    result.numComponents = numComponents;
    return result;
}

/// Numbers of a parameter, or none for text and files.
std::vector<float> Numbers(const ParameterValue& parameter) {
    if (const auto* vector = std::get_if<std::vector<float>>(&parameter)) {
        return *vector;
    }
    if (const auto* number = std::get_if<double>(&parameter)) {
        return {float(*number)};
    }
    if (const auto* integer = std::get_if<std::int64_t>(&parameter)) {
        return {float(*integer)};
    }
    if (const auto* flag = std::get_if<bool>(&parameter)) {
        return {*flag ? 1.0F : 0.0F};
    }
    return {};
}

} // namespace

NetworkEvaluator::NetworkEvaluator(const MaterialNetwork& network, const std::string& materialPath,
                                   const MeanColorCallback& meanColor, Warnings& warnings)
    : _materialPath(materialPath), _meanColor(meanColor), _warnings(warnings) {
    for (const MaterialNode& node : network.nodes) {
        _nodeByPath[node.path] = &node;
    }
}

void NetworkEvaluator::Warn(const std::string& text) {
    _warnings.Add(_materialPath, text);
}

const MaterialNode* NetworkEvaluator::FindNode(const std::string& path) const {
    const auto found = _nodeByPath.find(path);
    return found == _nodeByPath.end() ? nullptr : found->second;
}

InputValue NetworkEvaluator::Parameter(const MaterialNode& node, const std::string& input) {
    const auto found = node.parameters.find(input);
    if (found == node.parameters.end()) {
        return {};
    }
    const std::vector<float> numbers = Numbers(found->second);
    if (numbers.empty() || numbers.size() > 4) {
        Warn("input " + input + " of " + node.path + " has a wrong type");
        return {};
    }
    InputValue result = MakeConstant({0.0F, 0.0F, 0.0F, 1.0F}, std::uint32_t(numbers.size()));
    for (std::size_t i = 0; i < numbers.size(); ++i) {
        if (!std::isfinite(numbers[i])) {
            Warn("input " + input + " of " + node.path + " is not finite");
            return {};
        }
        result.value[i] = numbers[i];
    }
    return result;
}

InputValue NetworkEvaluator::Evaluate(const MaterialNode& node, const std::string& input) {
    const auto found = node.connections.find(input);
    if (found == node.connections.end()) {
        return Parameter(node, input);
    }
    const MaterialNode::Connection& connection = found->second;
    const MaterialNode* upstream = FindNode(connection.upstreamPath);
    if (upstream == nullptr) {
        Warn("input " + input + " of " + node.path + " is connected to " + connection.upstreamPath +
             ", which does not exist");
        return Parameter(node, input);
    }
    const auto key = std::make_pair(upstream->path, connection.upstreamOutput);
    if (!_visiting.insert(key).second) {
        Warn("the connections of " + node.path + " form a cycle");
        return Parameter(node, input);
    }
    InputValue result = EvaluateOutput(*upstream, connection.upstreamOutput);
    _visiting.erase(key);
    return result.kind == InputValue::Kind::None ? Parameter(node, input) : result;
}

InputValue NetworkEvaluator::EvaluateOutput(const MaterialNode& node, const std::string& output) {
    if (node.identifier == "UsdUVTexture") {
        return EvaluateTexture(node, output);
    }
    if (node.identifier.compare(0, kReaderPrefix.size(), kReaderPrefix) == 0) {
        return EvaluateReader(node);
    }
    Warn("shader " + node.identifier + " of " + node.path + " is not supported here");
    return {};
}

std::string NetworkEvaluator::Text(const MaterialNode& node, const std::string& input) const {
    const auto found = node.parameters.find(input);
    const auto* text =
        found == node.parameters.end() ? nullptr : std::get_if<std::string>(&found->second);
    return text == nullptr ? std::string() : *text;
}

InputValue NetworkEvaluator::EvaluateReader(const MaterialNode& node) {
    const std::uint32_t numComponents =
        ReaderComponents(node.identifier.substr(kReaderPrefix.size()));
    if (numComponents == 0) {
        Warn("shader " + node.identifier + " of " + node.path + " gives no number");
        return {};
    }
    InputValue result = Evaluate(node, "fallback");
    if (result.kind != InputValue::Kind::Constant) {
        result = MakeConstant({0.0F, 0.0F, 0.0F, 0.0F}, numComponents);
    }
    result.numComponents = numComponents;
    result.primvar = Text(node, "varname");
    if (result.primvar.empty()) {
        Warn(node.path + " names no primvar");
        return result;
    }
    result.kind = InputValue::Kind::Primvar;
    return result;
}

std::array<float, 4> NetworkEvaluator::Constant4(const MaterialNode& node, const std::string& input,
                                                 const std::array<float, 4>& fallback) {
    const InputValue value = Evaluate(node, input);
    if (value.kind == InputValue::Kind::None) {
        return fallback;
    }
    if (value.kind == InputValue::Kind::Primvar) {
        Warn("input " + input + " of " + node.path + " cannot come from a primvar");
        return fallback;
    }
    std::array<float, 4> result = fallback;
    std::copy_n(value.value.begin(), value.numComponents, result.begin());
    return result;
}

/// The image's mean after scale and bias, or the node's fallback.
std::array<float, 4> NetworkEvaluator::TextureMean(const MaterialNode& node) {
    const std::array<float, 4> fallback = Constant4(node, "fallback", {0.0F, 0.0F, 0.0F, 1.0F});
    AssetReference file;
    if (const auto found = node.parameters.find("file"); found != node.parameters.end()) {
        if (const auto* asset = std::get_if<AssetReference>(&found->second)) {
            file = *asset;
        } else if (const auto* text = std::get_if<std::string>(&found->second)) {
            file.authoredPath = *text;
            file.file = *text;
        }
    }
    if (file.authoredPath.empty() && file.file.empty()) {
        Warn(node.path + " names no image file; its fallback is used");
        return fallback;
    }
    const std::string name = file.authoredPath.empty() ? file.file : file.authoredPath;
    const std::string space = Text(node, "sourceColorSpace");
    const auto mean = _meanColor && !file.file.empty()
                          ? _meanColor(file, space.empty() ? "auto" : space)
                          : std::nullopt;
    if (!mean) {
        Warn("cannot read image " + name + " of " + node.path + "; its fallback is used");
        return fallback;
    }
    Warn("texture " + name + " of " + node.path + " is replaced by its mean colour");
    const std::array<float, 4> scale = Constant4(node, "scale", {1.0F, 1.0F, 1.0F, 1.0F});
    const std::array<float, 4> bias = Constant4(node, "bias", {0.0F, 0.0F, 0.0F, 0.0F});
    std::array<float, 4> result{};
    for (std::size_t i = 0; i < 4; ++i) {
        result[i] = (*mean)[i] * scale[i] + bias[i];
    }
    return result;
}

InputValue NetworkEvaluator::EvaluateTexture(const MaterialNode& node, const std::string& output) {
    const std::array<float, 4> value = TextureMean(node);
    if (output == "rgb") {
        return MakeConstant(value, 3);
    }
    if (output == "rgba") {
        return MakeConstant(value, 4);
    }
    const std::size_t channel = std::string("rgba").find(output);
    if (output.size() != 1 || channel == std::string::npos) {
        Warn(node.path + " has no output " + output);
        return {};
    }
    return MakeConstant({value[channel], 0.0F, 0.0F, 1.0F}, 1);
}

} // namespace hds
