// SPDX-License-Identifier: Apache-2.0
#include "hdStream/shading/shaderNetwork.h"

#include <algorithm>
#include <optional>
#include <set>
#include <utility>

namespace hds {

namespace {

const char* const kMix = "ND_mix_displacementshader";
const char* const kByFloat = "ND_displacement_float";
const char* const kByVector = "ND_displacement_vector3";

bool StartsWith(const std::string& text, const char* start) {
    return text.rfind(start, 0) == 0;
}

const MaterialNode* FindNode(const MaterialNetwork& network, const std::string& path) {
    const auto found = std::find_if(network.nodes.begin(), network.nodes.end(),
                                    [&](const MaterialNode& node) { return node.path == path; });
    return found == network.nodes.end() ? nullptr : &*found;
}

/// The input that a node hands on; null: it is none of these.
const char* HandsOn(const MaterialNode& node) {
    if (StartsWith(node.identifier, "ND_dot_")) {
        return "in";
    }
    if (StartsWith(node.identifier, "ND_surfacematerial")) {
        return "surfaceshader";
    }
    return node.identifier == "ND_volumematerial" ? "volumeshader" : nullptr;
}

const MaterialNode* SourceOf(const MaterialNetwork& network, const MaterialNode& node,
                             const std::string& input) {
    const auto found = node.connections.find(input);
    return found == node.connections.end() ? nullptr
                                           : FindNode(network, found->second.upstreamPath);
}

/// A node, or what it hands on. As long as a chain may be; longer ones are cycles.
const MaterialNode* Behind(const MaterialNetwork& network, const MaterialNode* node) {
    for (std::size_t i = 0; node != nullptr && i <= network.nodes.size(); ++i) {
        const char* const input = HandsOn(*node);
        if (input == nullptr) {
            return node;
        }
        node = SourceOf(network, *node, input);
    }
    return nullptr;
}

/// Puts one displacement in the place of each mix of two.
class DisplacementMixes {
public:
    DisplacementMixes(MaterialNetwork* network, const std::string& materialPath, Warnings& warnings)
        : _network(network), _materialPath(materialPath), _warnings(warnings) {}

    /// Makes what has this path a displacement, where it is a mix.
    void Join(const std::string& path) {
        const MaterialNode* node = FindNode(*_network, path);
        if (node == nullptr || node->identifier != kMix || !_joined.insert(path).second) {
            return;
        }
        const MaterialNode mix = *node; // nodes move as others are added
        const std::optional<Side> back = SideOf(mix, "bg");
        const std::optional<Side> front = SideOf(mix, "fg");
        if (back && front && (back->isVector != front->isVector || back->space != front->space)) {
            _warnings.Add(_materialPath,
                          kMix + (" " + path) + " has displacements of two kinds; ignored");
            Replace(path, {path, kByFloat, {}, {}});
            return;
        }
        const Side& known = front ? *front : back ? *back : Side();
        const std::string type = known.isVector ? "vector3" : "float";
        MaterialNode sum{path + "/mix", "ND_mix_" + type, {}, {}};
        Hand(mix, "mix", &sum, "mix");
        for (const auto& [input, side] : {std::pair("bg", back), std::pair("fg", front)}) {
            if (side) {
                sum.connections[input] = {side->path, "out"};
            }
        }
        _network->nodes.push_back(std::move(sum));
        MaterialNode whole{path, known.isVector ? kByVector : kByFloat, {}, {}};
        whole.connections["displacement"] = {path + "/mix", "out"};
        if (!known.space.empty()) {
            whole.parameters["space"] = known.space;
        }
        Replace(path, std::move(whole));
    }

private:
    /// What is mixed: the amount, times its scale.
    struct Side {
        std::string path;
        std::string space;
        bool isVector = false;
    };

    std::optional<Side> SideOf(const MaterialNode& mix, const std::string& input) {
        const MaterialNode* shader = FindInputShader(*_network, mix, input);
        if (shader == nullptr) {
            return std::nullopt;
        }
        Join(shader->path);
        shader = FindInputShader(*_network, mix, input);
        const MaterialNode one = *shader;
        if (one.identifier != kByFloat && one.identifier != kByVector) {
            _warnings.Add(_materialPath, "displacement shader " + one.identifier + " of " +
                                             one.path + " cannot be mixed; ignored");
            return std::nullopt;
        }
        Side side{mix.path + "/" + input, "", one.identifier == kByVector};
        const auto space = one.parameters.find("space");
        if (space != one.parameters.end() && std::holds_alternative<std::string>(space->second) &&
            side.isVector && std::get<std::string>(space->second) != "tangent") {
            side.space = std::get<std::string>(space->second);
        }
        MaterialNode amount{
            side.path, side.isVector ? "ND_multiply_vector3FA" : "ND_multiply_float", {}, {}};
        amount.parameters["in1"] = std::vector<float>(side.isVector ? 3 : 1, 0.0F);
        Hand(one, "displacement", &amount, "in1");
        Hand(one, "scale", &amount, "in2"); // whose defaults are the same
        _network->nodes.push_back(std::move(amount));
        return side;
    }

    /// Gives a node what another has at an input.
    static void Hand(const MaterialNode& from, const std::string& input, MaterialNode* to,
                     const std::string& as) {
        if (const auto value = from.parameters.find(input); value != from.parameters.end()) {
            to->parameters[as] = value->second;
        }
        if (const auto source = from.connections.find(input); source != from.connections.end()) {
            to->connections[as] = source->second;
        }
    }

    void Replace(const std::string& path, MaterialNode with) {
        *std::find_if(_network->nodes.begin(), _network->nodes.end(),
                      [&](const MaterialNode& node) { return node.path == path; }) =
            std::move(with);
    }

    MaterialNetwork* _network;
    const std::string& _materialPath;
    Warnings& _warnings;
    std::set<std::string> _joined; ///< paths; one that is met again before it is done is a cycle
};

} // namespace

const MaterialNode* FindTerminalShader(const MaterialNetwork& network,
                                       const std::string& terminal) {
    const auto found = network.terminals.find(terminal);
    return found == network.terminals.end()
               ? nullptr
               : Behind(network, FindNode(network, found->second.upstreamPath));
}

const MaterialNode* FindInputShader(const MaterialNetwork& network, const MaterialNode& node,
                                    const std::string& input) {
    return Behind(network, SourceOf(network, node, input));
}

MaterialNetwork JoinShaders(const MaterialNetwork& network, const std::string& materialPath,
                            Warnings& warnings) {
    MaterialNetwork result = network;
    const auto surface = network.terminals.find("surface");
    const MaterialNode* material = surface == network.terminals.end()
                                       ? nullptr
                                       : FindNode(network, surface->second.upstreamPath);
    if (material != nullptr && network.terminals.count("displacement") == 0 &&
        StartsWith(material->identifier, "ND_surfacematerial")) {
        const auto source = material->connections.find("displacementshader");
        if (source != material->connections.end()) {
            result.terminals["displacement"] = source->second;
        }
    }
    for (auto& [name, terminal] : result.terminals) {
        if (const MaterialNode* shader = FindTerminalShader(result, name)) {
            terminal.upstreamPath = shader->path;
        }
    }
    const auto displacement = result.terminals.find("displacement");
    if (displacement != result.terminals.end()) {
        DisplacementMixes(&result, materialPath, warnings).Join(displacement->second.upstreamPath);
    }
    return result;
}

} // namespace hds
