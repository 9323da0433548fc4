// SPDX-License-Identifier: Apache-2.0
#include "hdStream/shading/arnoldNodes.h"

#include "hdStream/shading/arnoldPatterns.h"
#include "hdStream/shading/shaderNodes.h"

#include <algorithm>
#include <array>
#include <initializer_list>
#include <iterator>
#include <map>
#include <optional>
#include <set>
#include <string_view>
#include <utility>
#include <vector>

namespace hds {

namespace {

constexpr const char* kStandardSurface = "ND_standard_surface_surfaceshader";
constexpr const char* kOpenPbrSurface = "ND_open_pbr_surface_surfaceshader";

using Numbers = std::vector<float>;

/// What an input takes, or a node gives. Colours that feed a number give the mean of their
/// channels.
enum class Type { Number, Color };

class Translator;

/// A node that is known.
struct ArnoldType {
    std::string_view name; ///< behind "arnold:"
    Type output;
    bool isSurface; ///< is drawn where a surface hangs on it
    void (Translator::*translate)(const MaterialNode& node);
};

/// Null: not known.
const ArnoldType* FindType(const std::string& identifier);

class Translator {
public:
    Translator(const MaterialNetwork& network, const std::string& materialPath, Warnings& warnings)
        : _network(network), _materialPath(materialPath), _warnings(warnings) {
        for (const MaterialNode& node : network.nodes) {
            _nodeByPath.emplace(node.path, &node);
        }
    }

    MaterialNetwork Translate() {
        _result.terminals = _network.terminals;
        for (const MaterialNode& node : _network.nodes) {
            const ArnoldType* type = FindType(node.identifier);
            if (type != nullptr) {
                (this->*type->translate)(node);
                continue;
            }
            MaterialNode copy = node;
            for (auto& [input, connection] : copy.connections) {
                connection = SourceOf(connection, Type::Color);
            }
            _result.nodes.push_back(std::move(copy));
        }
        SetTerminals();
        return std::move(_result);
    }

    void StandardSurface(const MaterialNode& node) {
        MaterialNode surface = Surface(node, kStandardSurface, {"normal", "coat_normal"});
        Direction(node, "tangent", &surface);
        Add(std::move(surface));
        const std::string walk = TextOf(node, "subsurface_type");
        WarnOf(node, LeftOut(node, {{"internal_reflections", {1.0F}},
                                    {"exit_to_background", {0.0F}},
                                    {"indirect_diffuse", {1.0F}},
                                    {"indirect_specular", {1.0F}},
                                    {"transmit_aovs", {0.0F}}}) +
                         (walk.empty() || walk.compare(0, 10, "randomwalk") == 0
                              ? ""
                              : ", subsurface_type " + walk));
    }
    void OpenPbrSurface(const MaterialNode& node) {
        MaterialNode surface =
            Surface(node, kOpenPbrSurface, {"geometry_normal", "geometry_coat_normal"});
        Direction(node, "geometry_tangent", &surface);
        Direction(node, "geometry_coat_tangent", &surface);
        Add(std::move(surface));
        WarnOf(node, LeftOut(node, {{"internal_reflections", {1.0F}},
                                    {"exit_to_background", {0.0F}},
                                    {"indirect_diffuse", {1.0F}},
                                    {"indirect_specular", {1.0F}},
                                    {"transmission_transmit_aovs", {0.0F}}}));
    }
    void Lambert(const MaterialNode& node) {
        MaterialNode surface{node.path, kStandardSurface, {}, {}};
        surface.parameters["specular"] = 0.0;
        Pass(node, "Kd", "base", Type::Number, Numbers{0.7F}, &surface);
        Pass(node, "Kd_color", "base_color", Type::Color, Numbers{1.0F, 1.0F, 1.0F}, &surface);
        Pass(node, "opacity", "opacity", Type::Color, {}, &surface);
        Direction(node, "normal", &surface);
        Add(std::move(surface));
    }
    void Flat(const MaterialNode& node) {
        MaterialNode color{node.path, "ND_constant_color3", {}, {}};
        Pass(node, "color", "value", Type::Color, Numbers{1.0F, 1.0F, 1.0F}, &color);
        Add(std::move(color));
    }

    void Image(const MaterialNode& node) {
        static const std::map<std::string, std::string> kWraps = {{"periodic", "repeat"},
                                                                  {"file", "useMetadata"}};
        MaterialNode image{node.path, "ND_UsdUVTexture_23", {}, {}};
        Copy(node, "filename", "file", &image);
        for (const auto& [from, to] : {std::pair("swrap", "wrapS"), std::pair("twrap", "wrapT")}) {
            const std::string mode = TextOf(node, from);
            const auto other = kWraps.find(mode);
            if (!mode.empty()) {
                image.parameters[to] = other == kWraps.end() ? mode : other->second;
            }
        }
        const std::string space = TextOf(node, "color_space");
        if (!space.empty()) {
            image.parameters["sourceColorSpace"] = space == "linear" ? "raw" : space;
        }
        PassFour(node, "multiply", "scale", 1.0F, &image);
        PassFour(node, "offset", "bias", 0.0F, &image);
        PassFour(node, "missing_texture_color", "fallback", 1.0F, &image);
        PlaceImage(node, &image);
        Add(std::move(image));
        const bool isSingle = IsOn(node, "single_channel", false);
        WarnOf(node, LeftOut(node, {{"start_channel", {0.0F}}}, isSingle));
    }

    /// In tangent space.
    void NormalMap(const MaterialNode& node) {
        if (!IsOn(node, "tangent_space", true)) {
            Add(node); // stays what is not known
            return;
        }
        MaterialNode map{node.path, "ND_normalmap_vector2", {}, {}};
        if (IsOn(node, "color_to_signed", true)) {
            Pass(node, "input", "in", Type::Color, {}, &map);
        } else { // it has signs already
            const Numbers halves(3, 0.5F);
            MaterialNode half{node.path + "/half", "ND_multiply_color3", {}, {}};
            Pass(node, "input", "in1", Type::Color, {}, &half);
            half.parameters["in2"] = halves;
            const std::string path = half.path;
            Add(std::move(half));
            map.connections["in"] = Binary(node, "encoded", "ND_add_color3", {path, "out"}, halves);
        }
        if (node.connections.count("strength") > 0) {
            Pass(node, "strength", "scale", Type::Number, {}, &map);
        } else {
            const float strength = NumberOf(node, "strength", 1.0F);
            map.parameters["scale"] = Numbers{IsOn(node, "invert_x", false) ? -strength : strength,
                                              IsOn(node, "invert_y", false) ? -strength : strength};
        }
        Add(std::move(map));
        const std::string order = TextOf(node, "order");
        WarnOf(node, LeftOut(node, {{"invert_z", {0.0F}},
                                    {"normal", {0.0F, 0.0F, 0.0F}},
                                    {"tangent", {0.0F, 0.0F, 0.0F}}}) +
                         (order.empty() || order == "XYZ" ? "" : ", order " + order));
    }

    template <Type kType>
    void UserData(const MaterialNode& node) {
        const char* const kind = kType == Type::Number ? "float" : "color3";
        MaterialNode data{node.path, std::string("ND_geompropvalue_") + kind, {}, {}};
        Copy(node, "attribute", "geomprop", &data);
        Pass(node, "default", "default", kType, {}, &data);
        Add(std::move(data));
    }
    void StateFloat(const MaterialNode& node) {
        const std::string variable = TextOf(node, "variable");
        if (variable != "u" && variable != "v") {
            Add(node);
            return;
        }
        Add({node.path + "/st", "ND_texcoord_vector2", {}, {}});
        MaterialNode channel{node.path, "ND_extract_vector2", {}, {}};
        channel.parameters["index"] = std::int64_t{variable == "v"};
        channel.connections["in"] = {node.path + "/st", "out"};
        Add(std::move(channel));
    }

    /// Of two colours. \tparam kDefault of both
    template <const char* kId, int kDefault>
    void Arithmetic(const MaterialNode& node) {
        const Numbers fallback(3, float(kDefault));
        MaterialNode result{node.path, kId, {}, {}};
        Pass(node, "input1", "in1", Type::Color, fallback, &result);
        Pass(node, "input2", "in2", Type::Color, fallback, &result);
        Add(std::move(result));
    }
    void MixRgba(const MaterialNode& node) {
        MaterialNode mix{node.path, "ND_mix_color3", {}, {}};
        Pass(node, "input1", "bg", Type::Color, Numbers{0.0F, 0.0F, 0.0F}, &mix);
        Pass(node, "input2", "fg", Type::Color, Numbers{1.0F, 1.0F, 1.0F}, &mix);
        Pass(node, "mix", "mix", Type::Number, Numbers{0.5F}, &mix);
        Add(std::move(mix));
    }
    void Range(const MaterialNode& node) {
        MaterialNode range{node.path, "ND_remap_color3", {}, {}};
        Pass(node, "input", "in", Type::Color, {}, &range);
        Pass(node, "input_min", "inlow", Type::Number, {}, &range);
        Pass(node, "input_max", "inhigh", Type::Number, {}, &range);
        Pass(node, "output_min", "outlow", Type::Number, {}, &range);
        Pass(node, "output_max", "outhigh", Type::Number, {}, &range);
        Add(std::move(range));
        WarnOf(node, LeftOut(node, {{"smoothstep", {0.0F}},
                                    {"contrast", {1.0F}},
                                    {"bias", {0.5F}},
                                    {"gain", {0.5F}}}));
    }
    /// The input times 2^exposure and `multiply`, plus `add`.
    void ColorCorrect(const MaterialNode& node) {
        const Numbers black(3, 0.0F);
        MaterialNode power{node.path + "/power", "ND_power_float", {}, {}};
        power.parameters["in1"] = 2.0;
        Pass(node, "exposure", "in2", Type::Number, Numbers{0.0F}, &power);
        MaterialNode bright{node.path + "/bright", "ND_multiply_color3FA", {}, {}};
        Pass(node, "input", "in1", Type::Color, black, &bright);
        bright.connections["in2"] = {power.path, "out"};
        MaterialNode scaled{node.path + "/scaled", "ND_multiply_color3", {}, {}};
        Pass(node, "multiply", "in2", Type::Color, Numbers(3, 1.0F), &scaled);
        scaled.connections["in1"] = {bright.path, "out"};
        MaterialNode sum{node.path, "ND_add_color3", {}, {}};
        Pass(node, "add", "in2", Type::Color, black, &sum);
        sum.connections["in1"] = {scaled.path, "out"};
        Add(std::move(power));
        Add(std::move(bright));
        Add(std::move(scaled));
        Add(std::move(sum));
        WarnOf(node, LeftOut(node, {{"mask", {1.0F}},
                                    {"gamma", {1.0F}},
                                    {"hue_shift", {0.0F}},
                                    {"saturation", {1.0F}},
                                    {"contrast", {1.0F}},
                                    {"invert", {0.0F}}}));
    }
    void FloatToRgb(const MaterialNode& node) {
        MaterialNode color{node.path, "ND_combine3_color3", {}, {}};
        Pass(node, "r", "in1", Type::Number, {}, &color);
        Pass(node, "g", "in2", Type::Number, {}, &color);
        Pass(node, "b", "in3", Type::Number, {}, &color);
        Add(std::move(color));
    }

private:
    using Input = std::pair<const char*, Numbers>;

    void Add(MaterialNode node) { _result.nodes.push_back(std::move(node)); }

    /// Null: there is none.
    const MaterialNode* FindNode(const std::string& path) const {
        const auto found = _nodeByPath.find(path);
        return found == _nodeByPath.end() ? nullptr : found->second;
    }

    /// A surface has the names of MaterialX's. \param normals inputs that are normals
    MaterialNode Surface(const MaterialNode& node, const char* identifier,
                         std::initializer_list<const char*> normals) {
        MaterialNode surface{node.path, identifier, {}, {}};
        for (const SurfaceInput& input : SurfaceInputs(identifier)) {
            const std::string name(input.name);
            Pass(node, name, name, input.numComponents == 1 ? Type::Number : Type::Color, {},
                 &surface);
        }
        for (const char* normal : normals) {
            Direction(node, normal, &surface);
        }
        Copy(node, "dielectric_priority", "dielectric_priority", &surface);
        return surface;
    }

    /// A normal or tangent; one that is 0 is the surface's own.
    void Direction(const MaterialNode& node, const char* name, MaterialNode* to) {
        if (node.connections.count(name) > 0 || !IsDefault(node, {name, {0.0F, 0.0F, 0.0F}})) {
            Pass(node, name, name, Type::Color, {}, to);
        }
    }

    /// Adds a node of two inputs below another. \return its output
    MaterialNode::Connection Binary(const MaterialNode& node, const char* name,
                                    const char* identifier, const MaterialNode::Connection& first,
                                    const Numbers& second) {
        MaterialNode result{node.path + "/" + name, identifier, {}, {}};
        result.connections["in1"] = first;
        result.parameters["in2"] = second;
        Add(std::move(result));
        return {node.path + "/" + name, "out"};
    }

    void Copy(const MaterialNode& node, const std::string& from, const std::string& to,
              MaterialNode* result) {
        for (const char* prefix : {"", "colorSpace:"}) {
            const auto parameter = node.parameters.find(prefix + from);
            if (parameter != node.parameters.end()) {
                result->parameters[prefix + to] = parameter->second;
            }
        }
    }

    /// \param fallback empty: the other node's default is the same
    void Pass(const MaterialNode& node, const std::string& from, const std::string& to, Type type,
              const Numbers& fallback, MaterialNode* result) {
        if (!fallback.empty()) {
            result->parameters[to] = fallback;
        }
        Copy(node, from, to, result);
        if (const auto found = node.connections.find(from); found != node.connections.end()) {
            result->connections[to] = SourceOf(ColorOfTexture(found->second), type);
        }
    }

    /// Arnold asks a UsdUVTexture for its colour by any name that is no channel's.
    MaterialNode::Connection ColorOfTexture(const MaterialNode::Connection& connection) const {
        static const std::set<std::string> kOutputs = {"r", "g", "b", "a", "rgb", "rgba"};
        const MaterialNode* node = FindNode(connection.upstreamPath);
        const bool isTexture =
            node != nullptr && node->identifier.find("UsdUVTexture") != std::string::npos;
        return isTexture && kOutputs.count(connection.upstreamOutput) == 0
                   ? MaterialNode::Connection{connection.upstreamPath, "rgb"}
                   : connection;
    }

    /// A colour as an input of four.
    void PassFour(const MaterialNode& node, const char* from, const char* to, float fourth,
                  MaterialNode* result) {
        Pass(node, from, to, Type::Color, {}, result);
        if (const auto found = result->parameters.find(to); found != result->parameters.end()) {
            if (auto* numbers = std::get_if<Numbers>(&found->second)) {
                numbers->resize(std::max<std::size_t>(numbers->size(), 3));
                numbers->resize(4, fourth);
            }
        }
    }

    /// What a connection to a node of Arnold's is connected to: the output of the node in its
    /// place, one channel, or the mean of all.
    MaterialNode::Connection SourceOf(const MaterialNode::Connection& connection, Type type) {
        static const std::string kChannels = "rgbaxyz";
        const std::string& path = connection.upstreamPath;
        const MaterialNode* node = FindNode(path);
        const ArnoldType* upstream = node == nullptr ? nullptr : FindType(node->identifier);
        if (upstream == nullptr) {
            return connection;
        }
        const bool isImage = upstream->name == "image";
        const std::string& output = connection.upstreamOutput;
        std::size_t channel = output.size() == 1 ? kChannels.find(output) : std::string::npos;
        if (isImage && IsOn(*node, "single_channel", false)) {
            const float first = NumberOf(*node, "start_channel", 0.0F);
            channel = static_cast<std::size_t>(std::clamp(first, 0.0F, 3.0F));
        }
        if (channel != std::string::npos && upstream->output == Type::Color) {
            if (isImage) {
                return {path, std::string(1, "rgbargb"[channel])};
            }
            if (channel == 3) {
                WarnOf(*node, ", its alpha");
                return {path, "out"};
            }
            return {Once(path + "/channels", "ND_separate3_color3", path),
                    std::string("out") + "rgbargb"[channel]};
        }
        const std::string whole = isImage ? "rgb" : "out";
        if (type == Type::Number && upstream->output == Type::Color) {
            const std::string mean = Once(path + "/mean", "ND_dotproduct_vector3", path, whole);
            return {mean, "out"};
        }
        return {path, whole};
    }

    /// A node on what is at a path, made for the first who asks. \return its path
    std::string Once(const std::string& path, const char* identifier, const std::string& in,
                     const std::string& output = "out") {
        if (_made.insert(path).second) {
            MaterialNode node{path, identifier, {}, {}};
            const bool isMean = node.identifier == "ND_dotproduct_vector3";
            node.connections[isMean ? "in1" : "in"] = {in, output};
            if (isMean) {
                node.parameters["in2"] = Numbers(3, 1.0F / 3.0F);
            }
            Add(std::move(node));
        }
        return path;
    }

    /// The coordinates of an image: moved, then swapped, then flipped, then scaled.
    void PlaceImage(const MaterialNode& node, MaterialNode* image) {
        MaterialNode::Connection st;
        const std::string set = TextOf(node, "uvset");
        if (const auto found = node.connections.find("uvcoords"); found != node.connections.end()) {
            st = SourceOf(found->second, Type::Color);
        } else if (!set.empty()) {
            MaterialNode primvar{node.path + "/uvset", "ND_geompropvalue_vector2", {}, {}};
            primvar.parameters["geomprop"] = set;
            st = {primvar.path, "out"};
            Add(std::move(primvar));
        }
        const auto start = [&] { // where nothing says which coordinates
            if (st.upstreamPath.empty()) {
                Add({node.path + "/st", "ND_texcoord_vector2", {}, {}});
                st = {node.path + "/st", "out"};
            }
        };
        const auto place = [&](const char* name, const char* identifier, const Numbers& by,
                               float neutral) {
            if (by[0] != neutral || by[1] != neutral) {
                start();
                st = Binary(node, name, identifier, st, by);
            }
        };
        constexpr const char* kAdd = "ND_add_vector2";
        constexpr const char* kMultiply = "ND_multiply_vector2";
        const float flips[2] = {IsOn(node, "sflip", false) ? 1.0F : 0.0F,
                                IsOn(node, "tflip", false) ? 1.0F : 0.0F};
        place("moved", kAdd, {NumberOf(node, "soffset", 0.0F), NumberOf(node, "toffset", 0.0F)},
              0.0F);
        if (IsOn(node, "swap_st", false)) {
            start();
            MaterialNode swapped{node.path + "/swapped", "ND_swizzle_vector2_vector2", {}, {}};
            swapped.parameters["channels"] = std::string("yx");
            swapped.connections["in"] = st;
            st = {swapped.path, "out"};
            Add(std::move(swapped));
        }
        place("turned", kMultiply, {1.0F - 2.0F * flips[0], 1.0F - 2.0F * flips[1]}, 1.0F);
        place("flipped", kAdd, {flips[0], flips[1]}, 0.0F);
        place("scaled", kMultiply, {NumberOf(node, "sscale", 1.0F), NumberOf(node, "tscale", 1.0F)},
              1.0F);
        if (!st.upstreamPath.empty()) {
            image->connections["st"] = st;
        }
    }

    /// Colours where a surface hangs are seen as they are; what displaces is not known.
    void SetTerminals() {
        const auto surface = _result.terminals.find("surface");
        const MaterialNode* node =
            surface == _result.terminals.end() ? nullptr : FindNode(surface->second.upstreamPath);
        const ArnoldType* type = node == nullptr ? nullptr : FindType(node->identifier);
        if (type != nullptr && type->isSurface && !IsClosure(*type)) {
            MaterialNode unlit{node->path + "/surface", "ND_surface_unlit", {}, {}};
            unlit.connections["emission_color"] = SourceOf(surface->second, Type::Color);
            surface->second.upstreamPath = unlit.path;
            Add(std::move(unlit));
        }
        const auto displacement = _result.terminals.find("displacement");
        node = displacement == _result.terminals.end()
                   ? nullptr
                   : FindNode(displacement->second.upstreamPath);
        if (node != nullptr && node->identifier.compare(0, 7, "arnold:") == 0) {
            _warnings.Add(_materialPath, "displacement by " + node->identifier + " of " +
                                             node->path + " is not supported and is left out");
            _result.terminals.erase(displacement);
        }
    }

    static bool IsClosure(const ArnoldType& type) {
        constexpr std::array<std::string_view, 3> kClosures = {"standard_surface",
                                                               "openpbr_surface", "lambert"};
        return std::find(kClosures.begin(), kClosures.end(), type.name) != kClosures.end();
    }

    static std::string TextOf(const MaterialNode& node, const std::string& input) {
        const auto found = node.parameters.find(input);
        const auto* text =
            found == node.parameters.end() ? nullptr : std::get_if<std::string>(&found->second);
        return text == nullptr ? std::string() : *text;
    }

    /// The numbers of a parameter; nothing: it is no number, or not authored.
    static std::optional<Numbers> NumbersOf(const MaterialNode& node, const std::string& input) {
        const auto found = node.parameters.find(input);
        if (found == node.parameters.end()) {
            return std::nullopt;
        }
        if (const auto* numbers = std::get_if<Numbers>(&found->second)) {
            return *numbers;
        }
        if (const auto* number = std::get_if<double>(&found->second)) {
            return Numbers{static_cast<float>(*number)};
        }
        if (const auto* integer = std::get_if<std::int64_t>(&found->second)) {
            return Numbers{static_cast<float>(*integer)};
        }
        if (const auto* flag = std::get_if<bool>(&found->second)) {
            return Numbers{*flag ? 1.0F : 0.0F};
        }
        return std::nullopt;
    }
    static float NumberOf(const MaterialNode& node, const std::string& input, float fallback) {
        const std::optional<Numbers> numbers = NumbersOf(node, input);
        return numbers && !numbers->empty() ? numbers->front() : fallback;
    }
    static bool IsOn(const MaterialNode& node, const std::string& input, bool fallback) {
        return NumberOf(node, input, fallback ? 1.0F : 0.0F) != 0.0F;
    }
    static bool IsDefault(const MaterialNode& node, const Input& input) {
        const std::optional<Numbers> numbers = NumbersOf(node, input.first);
        return node.connections.count(input.first) == 0 && (!numbers || *numbers == input.second);
    }

    /// Of inputs that are left out: ", name" of each that is not at its default.
    static std::string LeftOut(const MaterialNode& node, std::initializer_list<Input> inputs,
                               bool areRead = false) {
        std::string names;
        for (const Input& input : inputs) {
            names += areRead || IsDefault(node, input) ? "" : std::string(", ") + input.first;
        }
        return names;
    }
    void WarnOf(const MaterialNode& node, const std::string& leftOut) {
        if (!leftOut.empty()) {
            _warnings.Add(_materialPath, node.identifier + " of " + node.path +
                                             ": not supported and left out: " + leftOut.substr(2));
        }
    }

    const MaterialNetwork& _network;
    const std::string& _materialPath;
    Warnings& _warnings;
    std::map<std::string, const MaterialNode*> _nodeByPath; ///< of the network
    MaterialNetwork _result;
    std::set<std::string> _made; ///< paths of Once
};

constexpr char kAdd[] = "ND_add_color3";
constexpr char kSubtract[] = "ND_subtract_color3";
constexpr char kMultiply[] = "ND_multiply_color3";
constexpr char kDivide[] = "ND_divide_color3";

constexpr ArnoldType kTypes[] = {
    {"standard_surface", Type::Color, true, &Translator::StandardSurface},
    {"openpbr_surface", Type::Color, true, &Translator::OpenPbrSurface},
    {"lambert", Type::Color, true, &Translator::Lambert},
    {"flat", Type::Color, true, &Translator::Flat},
    {"image", Type::Color, true, &Translator::Image},
    {"normal_map", Type::Color, false, &Translator::NormalMap},
    {"user_data_rgb", Type::Color, true, &Translator::UserData<Type::Color>},
    {"user_data_float", Type::Number, true, &Translator::UserData<Type::Number>},
    {"user_data_int", Type::Number, true, &Translator::UserData<Type::Number>},
    {"state_float", Type::Number, false, &Translator::StateFloat},
    {"add", Type::Color, true, &Translator::Arithmetic<kAdd, 0>},
    {"subtract", Type::Color, true, &Translator::Arithmetic<kSubtract, 0>},
    {"multiply", Type::Color, true, &Translator::Arithmetic<kMultiply, 1>},
    {"divide", Type::Color, true, &Translator::Arithmetic<kDivide, 1>},
    {"mix_rgba", Type::Color, true, &Translator::MixRgba},
    {"range", Type::Color, true, &Translator::Range},
    {"color_correct", Type::Color, true, &Translator::ColorCorrect},
    {"float_to_rgb", Type::Color, true, &Translator::FloatToRgb},
    {"float_to_rgba", Type::Color, true, &Translator::FloatToRgb},
};

const ArnoldType* FindType(const std::string& identifier) {
    constexpr std::string_view kPrefix = "arnold:";
    if (identifier.compare(0, kPrefix.size(), kPrefix) != 0) {
        return nullptr;
    }
    const std::string_view name = std::string_view(identifier).substr(kPrefix.size());
    const auto* found = std::find_if(std::begin(kTypes), std::end(kTypes),
                                     [&](const ArnoldType& one) { return one.name == name; });
    return found == std::end(kTypes) ? nullptr : found;
}

} // namespace

bool IsArnoldSurface(const std::string& identifier) {
    const ArnoldType* type = FindType(identifier);
    return (type != nullptr && type->isSurface) || IsArnoldPattern(identifier);
}

MaterialNetwork TranslateArnold(const MaterialNetwork& network, const std::string& materialPath,
                                Warnings& warnings) {
    const bool hasAny =
        std::any_of(network.nodes.begin(), network.nodes.end(), [](const MaterialNode& node) {
            return node.identifier.compare(0, 7, "arnold:") == 0;
        });
    if (!hasAny) {
        return network;
    }
    const MaterialNetwork expanded = ExpandArnoldPatterns(network, materialPath, warnings);
    return Translator(expanded, materialPath, warnings).Translate();
}

} // namespace hds
