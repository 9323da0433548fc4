// SPDX-License-Identifier: Apache-2.0
#include "hdStream/shading/previewGraphs.h"

#include <variant>

namespace hds {

namespace {

using namespace graphRows;

bool IsSaid(const MaterialNode& node, const char* input) {
    return node.parameters.count(input) + node.connections.count(input) > 0;
}

/// Of a constant; 0 where none is said.
double Number(const MaterialNode& node, const char* input) {
    const auto found = node.parameters.find(input);
    if (found == node.parameters.end()) {
        return 0.0;
    }
    if (const auto* whole = std::get_if<std::int64_t>(&found->second)) {
        return static_cast<double>(*whole);
    }
    const auto* number = std::get_if<double>(&found->second);
    return number == nullptr ? 0.0 : *number;
}

/// The nodes that make a colour of what is converted, the last of which is "color".
NodeGraph ConvertGraph(const char* type, std::size_t numComponents, std::vector<GraphNode> nodes,
                       GraphSource color, bool hasAlpha) {
    std::map<std::string, GraphSource> inputs = {{"emission_color", std::move(color)}};
    if (hasAlpha) {
        inputs["opacity"] = Of("alpha");
    }
    nodes.push_back({"", "surface_unlit", std::move(inputs)});
    return {std::string("ND_convert_") + type + "_surfaceshader",
            {{"in", std::vector<float>(numComponents, 0.0F)}},
            std::move(nodes)};
}

GraphNode Convert(const char* name, const char* types, GraphSource from) {
    return {name, std::string("convert_") + types, {{"in", std::move(from)}}};
}

GraphNode AlphaOf(const char* type) {
    return {"alpha", std::string("extract_") + type, {{"in", From("in")}, {"index", Is({3.0F})}}};
}

} // namespace

std::vector<NodeGraph> ConvertGraphs() {
    const GraphSource in = From("in");
    const GraphSource color = Of("color");
    return {
        ConvertGraph("color3", 3, {}, in, false),
        ConvertGraph("color4", 4, {Convert("color", "color4_color3", in), AlphaOf("color4")}, color,
                     true),
        ConvertGraph("float", 1, {Convert("color", "float_color3", in)}, color, false),
        ConvertGraph("vector2", 2,
                     {Convert("vector", "vector2_vector3", in),
                      Convert("color", "vector3_color3", Of("vector"))},
                     color, false),
        ConvertGraph("vector3", 3, {Convert("color", "vector3_color3", in)}, color, false),
        ConvertGraph("vector4", 4,
                     {Convert("color4", "vector4_color4", in),
                      Convert("color", "color4_color3", Of("color4")), AlphaOf("vector4")},
                     color, true),
        ConvertGraph("integer", 1,
                     {Convert("number", "integer_float", in),
                      Convert("color", "float_color3", Of("number"))},
                     color, false),
        ConvertGraph("boolean", 1,
                     {Convert("number", "boolean_float", in),
                      Convert("color", "float_color3", Of("number"))},
                     color, false),
    };
}

bool IsPreviewSurface(const MaterialNode& node) {
    return node.identifier == "UsdPreviewSurface" ||
           node.identifier.rfind("ND_UsdPreviewSurface", 0) == 0;
}

NodeGraph PreviewGraph(const MaterialNode& shader) {
    const std::vector<float> white = {1.0F, 1.0F, 1.0F};
    const bool isSpecular = Number(shader, "useSpecularWorkflow") != 0.0;
    const bool hasNormal = IsSaid(shader, "normal");
    NodeGraph graph{shader.identifier,
                    {{"diffuseColor", {0.18F, 0.18F, 0.18F}},
                     {"specularColor", {0.0F, 0.0F, 0.0F}},
                     {"metallic", {0.0F}},
                     {"roughness", {0.5F}},
                     {"clearcoat", {0.0F}},
                     {"clearcoatRoughness", {0.01F}},
                     {"opacity", {1.0F}},
                     {"opacityThreshold", {0.0F}},
                     {"ior", {1.5F}}},
                    {}};
    std::vector<GraphNode>& nodes = graph.nodes;
    const auto addClosure = [&](const char* name, const char* kind,
                                std::map<std::string, GraphSource> inputs) {
        if (hasNormal) {
            inputs["normal"] = Of("frame");
        }
        nodes.push_back({name, kind, std::move(inputs)});
    };
    if (hasNormal) { // -1 to 1, where the node takes 0 to 1
        nodes.push_back(
            {"half", "multiply_vector3FA", {{"in1", From("normal")}, {"in2", Is({0.5F})}}});
        nodes.push_back({"map", "add_vector3FA", {{"in1", Of("half")}, {"in2", Is({0.5F})}}});
        nodes.push_back({"frame", "normalmap_float", {{"in", Of("map")}}});
    }
    nodes.push_back({"less", "invert_float", {{"in", From("ior")}}});
    nodes.push_back({"more", "add_float", {{"in1", From("ior")}, {"in2", Is({1.0F})}}});
    nodes.push_back({"root", "divide_float", {{"in1", Of("less")}, {"in2", Of("more")}}});
    nodes.push_back({"facing", "multiply_float", {{"in1", Of("root")}, {"in2", Of("root")}}});
    nodes.push_back({"alpha", "roughness_anisotropy", {{"roughness", From("roughness")}}});
    std::map<std::string, GraphSource> diffuse = {{"color", From("diffuseColor")}};
    if (isSpecular) {
        addClosure("reflection", "generalized_schlick_bsdf",
                   {{"color0", From("specularColor")}, {"roughness", Of("alpha")}});
    } else {
        nodes.push_back(
            {"tint",
             "mix_color3",
             {{"bg", Is(white)}, {"fg", From("diffuseColor")}, {"mix", From("metallic")}}});
        nodes.push_back({"low", "multiply_color3FA", {{"in1", Of("tint")}, {"in2", Of("facing")}}});
        nodes.push_back({"color0",
                         "mix_color3",
                         {{"bg", Of("low")}, {"fg", Of("tint")}, {"mix", From("metallic")}}});
        addClosure("reflection", "generalized_schlick_bsdf",
                   {{"color0", Of("color0")}, {"color90", Of("tint")}, {"roughness", Of("alpha")}});
        nodes.push_back({"notMetal", "invert_float", {{"in", From("metallic")}}});
        diffuse["weight"] = Of("notMetal");
    }
    addClosure("diffuse", "oren_nayar_diffuse_bsdf", std::move(diffuse));
    nodes.push_back({"base", "layer_bsdf", {{"top", Of("reflection")}, {"base", Of("diffuse")}}});
    const char* whole = "base";
    if (IsSaid(shader, "clearcoat")) {
        nodes.push_back(
            {"coatAlpha", "roughness_anisotropy", {{"roughness", From("clearcoatRoughness")}}});
        nodes.push_back({"coatColor", "convert_float_color3", {{"in", Of("facing")}}});
        addClosure("coat", "generalized_schlick_bsdf",
                   {{"weight", From("clearcoat")},
                    {"color0", Of("coatColor")},
                    {"roughness", Of("coatAlpha")}});
        nodes.push_back({"coated", "layer_bsdf", {{"top", Of("coat")}, {"base", Of("base")}}});
        whole = "coated";
    }
    std::map<std::string, GraphSource> surface = {{"bsdf", Of(whole)},
                                                  {"opacity", From("opacity")}};
    if (IsSaid(shader, "emissiveColor")) {
        nodes.push_back({"emission", "uniform_edf", {{"color", From("emissiveColor")}}});
        surface["edf"] = Of("emission");
    }
    if (IsSaid(shader, "opacityThreshold")) {
        nodes.push_back({"isThere",
                         "ifgreatereq_float",
                         {{"value1", From("opacity")},
                          {"value2", From("opacityThreshold")},
                          {"in1", Is({1.0F})},
                          {"in2", Is({0.0F})}}});
        nodes.push_back({"cut",
                         "ifgreater_float",
                         {{"value1", From("opacityThreshold")},
                          {"value2", Is({0.0F})},
                          {"in1", Of("isThere")},
                          {"in2", From("opacity")}}});
        surface["opacity"] = Of("cut");
    }
    nodes.push_back({"", "surface", std::move(surface)});
    return graph;
}

} // namespace hds
