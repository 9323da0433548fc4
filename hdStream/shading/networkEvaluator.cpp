// SPDX-License-Identifier: Apache-2.0
// Parameters, connections and transforms; look-ups are in textureNode.cpp.
#include "hdStream/shading/networkEvaluator.h"

#include "hdStream/shading/patternRegistry.h"

#include <algorithm>
#include <cmath>
#include <memory>

namespace hds {

namespace {

/// Nodes in a row. Expressions are as deep, and walked by recursion.
constexpr std::size_t kMaxDepth = 1024;

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
                                   const ImageQueries& images, Warnings& warnings)
    : _materialPath(materialPath), _images(images), _warnings(warnings) {
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

/// The authored parameter as numbers; empty when absent, not numeric or not finite (warns).
ShaderValue NetworkEvaluator::Parameter(const MaterialNode& node, const std::string& input) {
    const auto found = node.parameters.find(input);
    if (found == node.parameters.end()) {
        return {};
    }
    const std::vector<float> numbers = Numbers(found->second);
    if (numbers.empty() || numbers.size() > 4) {
        Warn("input " + input + " of " + node.path + " has a wrong type");
        return {};
    }
    std::array<float, 4> value{0.0F, 0.0F, 0.0F, 1.0F};
    for (std::size_t i = 0; i < numbers.size(); ++i) {
        if (!std::isfinite(numbers[i])) {
            Warn("input " + input + " of " + node.path + " is not finite");
            return {};
        }
        value[i] = numbers[i];
    }
    return MakeConstant(value, static_cast<std::uint32_t>(numbers.size()));
}

ShaderValue NetworkEvaluator::Evaluate(const MaterialNode& node, const std::string& input) {
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
    if (_visiting.size() >= kMaxDepth) {
        Warn("the connections of " + node.path + " lie behind more than " +
             std::to_string(kMaxDepth) + " nodes in a row, and are left out");
        return Parameter(node, input);
    }
    const auto key = std::make_pair(upstream->path, connection.upstreamOutput);
    if (!_visiting.insert(key).second) {
        Warn("the connections of " + node.path + " form a cycle");
        return Parameter(node, input);
    }
    ShaderValue result = EvaluateOutput(*upstream, connection.upstreamOutput);
    _visiting.erase(key);
    return result ? result : Parameter(node, input);
}

/// An input of a helper node; what has fewer components than it needs warns and is left out, but
/// one number spreads over all.
ShaderValue NetworkEvaluator::EvaluateOr(const MaterialNode& node, const std::string& input,
                                         const std::array<float, 4>& fallback,
                                         std::uint32_t numComponents) {
    const ShaderValue value = Evaluate(node, input);
    if (!value) {
        return MakeConstant(fallback, numComponents);
    }
    if (value.numComponents == 1 && numComponents > 1) {
        if (IsConstant(value)) {
            const float x = ConstantOf(value)[0];
            return MakeConstant({x, x, x, x}, numComponents);
        }
        return {value.expression, value.channel == HDS_CHANNEL_ALL ? 0 : value.channel,
                numComponents};
    }
    if (value.numComponents < std::min(numComponents, 3U)) {
        Warn("input " + input + " of " + node.path + " has a wrong type");
        return MakeConstant(fallback, numComponents);
    }
    if (value.numComponents == 3 && numComponents == 4 && IsConstant(value)) {
        const std::array<float, 4>& c = ConstantOf(value);
        return MakeConstant({c[0], c[1], c[2], fallback[3]}, 4);
    }
    return value;
}

void NetworkEvaluator::WarnOfWidth(const MaterialNode& node, const std::string& input,
                                   std::uint32_t numComponents) {
    const auto found = node.parameters.find(input);
    if (found == node.parameters.end() || node.connections.count(input) != 0) {
        return;
    }
    const std::size_t count = Numbers(found->second).size();
    // Counts that give nothing at all are told where they are read.
    const bool isRead = count == 1 || (count <= 4 && count >= std::min(numComponents, 3U));
    if (isRead && count != numComponents) {
        Warn("input " + input + " of " + node.path + " has " + std::to_string(count) +
             (count == 1 ? " number" : " numbers") + " in place of " +
             std::to_string(numComponents));
    }
}

const MaterialNode* NetworkEvaluator::FindSource(const MaterialNode& node,
                                                 const std::string& input) const {
    const auto found = node.connections.find(input);
    const MaterialNode* source =
        found == node.connections.end() ? nullptr : FindNode(found->second.upstreamPath);
    // As long as a chain may be; longer ones are cycles.
    for (std::size_t i = 0; source != nullptr && i < _nodeByPath.size(); ++i) {
        if (source->identifier.compare(0, 7, "ND_dot_") != 0) {
            return source;
        }
        const auto next = source->connections.find("in");
        source = next == source->connections.end() ? nullptr : FindNode(next->second.upstreamPath);
    }
    return source;
}

/// USD's nodes keep what their outputs share themselves; an output of another node is evaluated
/// once.
ShaderValue NetworkEvaluator::EvaluateOutput(const MaterialNode& node, const std::string& output) {
    const PatternType* type = FindPatternType(node.identifier);
    if (type != nullptr && IsOfUsd(*type)) {
        return type->evaluate(*this, node, output);
    }
    if (node.identifier.compare(0, 3, "ND_") != 0) {
        Warn("shader " +
             (node.identifier.empty() ? node.path + ", which has no shader id,"
                                      : node.identifier + " of " + node.path) +
             " is not supported here");
        return {};
    }
    const auto key = std::make_pair(node.path, output);
    const auto known = _patterns.find(key);
    if (known != _patterns.end()) {
        return known->second;
    }
    if (type == nullptr) {
        Warn("node " + node.identifier + " of " + node.path +
             " is not supported; what it feeds keeps its default");
    }
    const ShaderValue value = type == nullptr ? ShaderValue() : type->evaluate(*this, node, output);
    _patterns[key] = value;
    return value;
}

std::string NetworkEvaluator::Text(const MaterialNode& node, const std::string& input) const {
    const auto found = node.parameters.find(input);
    const auto* text =
        found == node.parameters.end() ? nullptr : std::get_if<std::string>(&found->second);
    return text == nullptr ? std::string() : *text;
}

ShaderValue NetworkEvaluator::EvaluateTransform2d(const MaterialNode& node) {
    ShaderValue& transform = _transforms[node.path];
    if (!transform) {
        WarnOfWidth(node, "rotation", 1);
        WarnOfWidth(node, "scale", 2);
        WarnOfWidth(node, "translation", 2);
        transform =
            MakeTransform2d({EvaluateOr(node, "in", {}, 2), EvaluateOr(node, "rotation", {}, 1),
                             EvaluateOr(node, "scale", {1.0F, 1.0F, 0.0F, 0.0F}, 2),
                             EvaluateOr(node, "translation", {}, 2)});
    }
    return transform;
}

} // namespace hds
