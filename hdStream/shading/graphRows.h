// SPDX-License-Identifier: Apache-2.0
// Shaders and closures of MaterialX that are other nodes put together, as tables: a row is a node
// of the graph. Internal to the expansion of graphs (surfaceGraphs.h).
#pragma once

#include <map>
#include <string>
#include <utility>
#include <vector>

namespace hds {

/// What feeds an input of a graph's node: an input of the shader, a node of the graph, a number or
/// a text.
struct GraphSource {
    enum class Kind { Interface, Node, Numbers, Text };
    Kind kind = Kind::Numbers;
    std::string name; ///< or the text
    std::string output = "out";
    std::vector<float> numbers;
};

struct GraphNode {
    std::string name;       ///< "": what stands for the shader
    std::string identifier; ///< without "ND_"
    std::map<std::string, GraphSource> inputs;
};

struct NodeGraph {
    std::string identifier;
    std::map<std::string, std::vector<float>> defaults; ///< of the shader's inputs
    std::vector<GraphNode> nodes;
};

namespace graphRows {

inline GraphSource From(const char* input) {
    return {GraphSource::Kind::Interface, input, "", {}};
}
inline GraphSource Of(const char* node, const char* output = "out") {
    return {GraphSource::Kind::Node, node, output, {}};
}
inline GraphSource Is(std::vector<float> numbers) {
    return {GraphSource::Kind::Numbers, "", "", std::move(numbers)};
}
inline GraphSource Named(const char* text) {
    return {GraphSource::Kind::Text, text, "", {}};
}

} // namespace graphRows

} // namespace hds
