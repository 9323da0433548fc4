// SPDX-License-Identifier: Apache-2.0
#include "hdStream/shading/arnoldPatterns.h"

#include <algorithm>
#include <initializer_list>
#include <optional>
#include <utility>
#include <vector>

namespace hds {

namespace {

using Numbers = std::vector<float>;
using Connection = MaterialNode::Connection;

constexpr const char* kCheckerboard = "arnold:checkerboard";
constexpr const char* kRampColor = "arnold:ramp_rgb";
constexpr const char* kRampNumber = "arnold:ramp_float";

/// Interpolations behind a knot of a ramp, by Arnold's numbers.
constexpr int kConstant = 0;
constexpr int kLinear = 1;

/// The numbers of a parameter; empty: it is no number, or not authored.
Numbers NumbersOf(const MaterialNode& node, const std::string& input) {
    const auto found = node.parameters.find(input);
    if (found == node.parameters.end()) {
        return {};
    }
    if (const auto* numbers = std::get_if<Numbers>(&found->second)) {
        return *numbers;
    }
    if (const auto* number = std::get_if<double>(&found->second)) {
        return {static_cast<float>(*number)};
    }
    if (const auto* integer = std::get_if<std::int64_t>(&found->second)) {
        return {static_cast<float>(*integer)};
    }
    if (const auto* flag = std::get_if<bool>(&found->second)) {
        return {*flag ? 1.0F : 0.0F};
    }
    return {};
}

float NumberOf(const MaterialNode& node, const std::string& input, float fallback) {
    const Numbers numbers = NumbersOf(node, input);
    return numbers.empty() ? fallback : numbers.front();
}

std::string TextOf(const MaterialNode& node, const std::string& input) {
    const auto found = node.parameters.find(input);
    const auto* text =
        found == node.parameters.end() ? nullptr : std::get_if<std::string>(&found->second);
    return text == nullptr ? std::string() : *text;
}

/// A colour at a place of a ramp, constant or connected.
struct Knot {
    float position;
    int interpolation; ///< from here to the next
    Numbers color;
    std::optional<Connection> source;
};

class Expander {
public:
    Expander(const std::string& materialPath, Warnings& warnings)
        : _materialPath(materialPath), _warnings(warnings) {}

    void Add(MaterialNode node) { _nodes.push_back(std::move(node)); }
    std::vector<MaterialNode> TakeNodes() { return std::move(_nodes); }

    /// Cells of half a period: the first colour where the sum of their numbers is odd.
    void Checkerboard(const MaterialNode& node) {
        const Connection cells[2] = {Cell(node, 0, "u_frequency"), Cell(node, 1, "v_frequency")};
        MaterialNode sum{node.path + "/cell", "ND_add_float", {}, {}};
        sum.connections["in1"] = cells[0];
        sum.connections["in2"] = cells[1];
        Add(sum);
        MaterialNode mix{node.path, "arnold:mix_rgba", {}, {}};
        mix.connections["mix"] =
            OfNumber(node, "parity", "ND_modulo_float", {sum.path, "out"}, 2.0);
        const std::pair<const char*, float> colors[] = {{"color2", 0.0F}, {"color1", 1.0F}};
        const char* const inputs[] = {"input1", "input2"};
        for (int i = 0; i < 2; ++i) {
            mix.parameters[inputs[i]] = Numbers(3, colors[i].second);
            Copy(node, colors[i].first, inputs[i], &mix);
        }
        Add(std::move(mix));
        Warn(node, {"u_frequency", "v_frequency"},
             {{"u_offset", 0.0F}, {"v_offset", 0.0F}, {"contrast", 1.0F}}, "");
    }

    /// False: its kind is not known.
    bool Ramp(const MaterialNode& node) {
        const std::string type = TextOf(node, "type");
        std::string told;
        const std::vector<Knot> knots = Knots(node, &told);
        const bool isCustom = type.empty() || type == "custom";
        if (knots.empty() || (!isCustom && type != "u" && type != "v")) {
            return false;
        }
        const Connection place = isCustom ? Input(node) : Coordinate(node, type == "v" ? 1 : 0);
        std::optional<Connection> before = knots[0].source;
        for (std::size_t k = 1; k < knots.size(); ++k) {
            const bool isLast = k + 1 == knots.size();
            const std::string name = "/knot" + std::to_string(k);
            MaterialNode mix{isLast ? node.path : node.path + name, "arnold:mix_rgba", {}, {}};
            mix.parameters["input1"] = knots[0].color;
            if (before) {
                mix.connections["input1"] = *before;
            }
            mix.parameters["input2"] = knots[k].color;
            if (knots[k].source) {
                mix.connections["input2"] = *knots[k].source;
            }
            mix.connections["mix"] = Share(node, name, place, knots[k - 1], knots[k]);
            before = Connection{mix.path, "out"};
            Add(std::move(mix));
        }
        if (knots.size() == 1) {
            MaterialNode mix{node.path, "arnold:mix_rgba", {}, {}};
            mix.parameters["mix"] = 0.0;
            mix.parameters["input1"] = knots[0].color;
            if (before) {
                mix.connections["input1"] = *before;
            }
            Add(std::move(mix));
        }
        Warn(node, {}, {{"offset", 0.0F}}, told);
        return true;
    }

private:
    static void Copy(const MaterialNode& node, const std::string& from, const std::string& to,
                     MaterialNode* result) {
        if (const auto found = node.parameters.find(from); found != node.parameters.end()) {
            result->parameters[to] = found->second;
        }
        if (const auto found = node.connections.find(from); found != node.connections.end()) {
            result->connections[to] = found->second;
        }
    }

    /// Adds a node of an input and a number below another. \return its output
    Connection OfNumber(const MaterialNode& node, const std::string& name, const char* identifier,
                        const Connection& first, double second) {
        MaterialNode result{node.path + "/" + name, identifier, {}, {}};
        result.connections["in1"] = first;
        result.parameters["in2"] = second;
        const std::string path = result.path;
        Add(std::move(result));
        return {path, "out"};
    }
    Connection OfOne(const MaterialNode& node, const std::string& name, const char* identifier,
                     const Connection& input) {
        MaterialNode result{node.path + "/" + name, identifier, {}, {}};
        result.connections["in"] = input;
        const std::string path = result.path;
        Add(std::move(result));
        return {path, "out"};
    }

    /// u or v.
    Connection Coordinate(const MaterialNode& node, int axis) {
        const std::string set = TextOf(node, "uvset");
        const std::string name = axis == 0 ? "u" : "v";
        MaterialNode st{node.path + "/st" + name, "ND_texcoord_vector2", {}, {}};
        if (!set.empty()) {
            st.identifier = "ND_geompropvalue_vector2";
            st.parameters["geomprop"] = set;
        }
        MaterialNode channel{node.path + "/" + name, "ND_extract_vector2", {}, {}};
        channel.parameters["index"] = std::int64_t{axis};
        channel.connections["in"] = {st.path, "out"};
        Connection result{channel.path, "out"};
        Add(std::move(st));
        Add(std::move(channel));
        return NumberOf(node, "wrap_uvs", 0.0F) != 0.0F
                   ? OfOne(node, name + "Wrapped", "ND_fract_float", result)
                   : result;
    }

    Connection Cell(const MaterialNode& node, int axis, const char* frequency) {
        const std::string name = axis == 0 ? "u" : "v";
        const double perUnit = 2.0 * double(NumberOf(node, frequency, 1.0F));
        const Connection scaled =
            OfNumber(node, name + "Scaled", "ND_multiply_float", Coordinate(node, axis), perUnit);
        return OfOne(node, name + "Cell", "ND_floor_float", scaled);
    }

    /// What is connected to a number, or the number, as one channel of Arnold's colour.
    Connection Input(const MaterialNode& node) {
        MaterialNode color{node.path + "/input", "arnold:float_to_rgb", {}, {}};
        Copy(node, "input", "r", &color);
        const std::string path = color.path;
        Add(std::move(color));
        return {path, "r"};
    }

    /// In the order of positions. \param[out] told interpolations that are read as linear
    static std::vector<Knot> Knots(const MaterialNode& node, std::string* told) {
        const bool isColor = node.identifier == kRampColor;
        const std::string name = isColor ? "color" : "value";
        const std::size_t width = isColor ? 3 : 1;
        const Numbers positions = NumbersOf(node, "position");
        const Numbers interpolations = NumbersOf(node, "interpolation");
        const Numbers values = NumbersOf(node, name);
        const std::size_t count = std::min(positions.size(), values.size() / width);
        std::vector<Knot> knots;
        for (std::size_t i = 0; i < count; ++i) {
            Knot knot{positions[i], kLinear, {}, {}};
            if (i < interpolations.size()) {
                knot.interpolation = interpolations[i] == float(kConstant) ? kConstant : kLinear;
                if (interpolations[i] != float(knot.interpolation)) {
                    *told = "interpolation that is neither constant nor linear";
                }
            }
            for (std::size_t c = 0; c < 3; ++c) {
                knot.color.push_back(values[width * i + (isColor ? c : 0)]);
            }
            const auto source = node.connections.find(name + ":i" + std::to_string(i));
            if (source != node.connections.end()) {
                knot.source = source->second;
            }
            knots.push_back(std::move(knot));
        }
        std::stable_sort(knots.begin(), knots.end(),
                         [](const Knot& a, const Knot& b) { return a.position < b.position; });
        return knots;
    }

    /// How far a place is from one knot to the next.
    Connection Share(const MaterialNode& node, const std::string& name, const Connection& place,
                     const Knot& from, const Knot& to) {
        MaterialNode share{node.path + name + "Share", "ND_range_float", {}, {}};
        if (from.interpolation == kLinear && to.position > from.position) {
            share.connections["in"] = place;
            share.parameters["inlow"] = double(from.position);
            share.parameters["inhigh"] = double(to.position);
            share.parameters["doclamp"] = true;
        } else {
            share.identifier = "ND_ifgreatereq_float";
            share.connections["value1"] = place;
            share.parameters["value2"] = double(to.position);
            share.parameters["in1"] = 1.0;
            share.parameters["in2"] = 0.0;
        }
        const std::string path = share.path;
        Add(std::move(share));
        return {path, "out"};
    }

    /// \param constants inputs that may not be connected \param neutral numbers that say nothing
    void Warn(const MaterialNode& node, std::initializer_list<const char*> constants,
              std::initializer_list<std::pair<const char*, float>> neutral, std::string leftOut) {
        for (const char* name : constants) {
            if (node.connections.count(name) > 0) {
                leftOut += (leftOut.empty() ? "" : ", ") + std::string(name);
            }
        }
        for (const auto& [name, value] : neutral) {
            if (node.connections.count(name) > 0 || NumberOf(node, name, value) != value) {
                leftOut += (leftOut.empty() ? "" : ", ") + std::string(name);
            }
        }
        if (!leftOut.empty()) {
            _warnings.Add(_materialPath, node.identifier + " of " + node.path +
                                             ": not supported and left out: " + leftOut);
        }
    }

    const std::string& _materialPath;
    Warnings& _warnings;
    std::vector<MaterialNode> _nodes;
};

} // namespace

bool IsArnoldPattern(const std::string& identifier) {
    return identifier == kCheckerboard || identifier == kRampColor || identifier == kRampNumber;
}

MaterialNetwork ExpandArnoldPatterns(const MaterialNetwork& network,
                                     const std::string& materialPath, Warnings& warnings) {
    Expander expander(materialPath, warnings);
    for (const MaterialNode& node : network.nodes) {
        if (node.identifier == kCheckerboard) {
            expander.Checkerboard(node);
        } else if (!IsArnoldPattern(node.identifier) || !expander.Ramp(node)) {
            expander.Add(node);
        }
    }
    return {expander.TakeNodes(), network.terminals};
}

} // namespace hds
