// SPDX-License-Identifier: Apache-2.0
#include "hdStream/shading/surfaceGraphs.h"

#include "hdStream/shading/graphRows.h"
#include "hdStream/shading/lamaGraphs.h"
#include "hdStream/shading/previewGraphs.h"
#include "hdStream/shading/shaderNetwork.h"

#include <algorithm>
#include <set>
#include <utility>

namespace hds {

namespace {

using namespace graphRows;

/// Burley's model of 2012: what is diffuse or scatters below the surface under sheen, beside glass;
/// a reflection over that, beside metal, under a coat.
NodeGraph DisneyPrincipled() {
    const std::vector<float> white = {1.0F, 1.0F, 1.0F};
    return {
        "ND_disney_principled",
        {{"baseColor", {0.16F, 0.16F, 0.16F}},
         {"metallic", {0.0F}},
         {"roughness", {0.5F}},
         {"anisotropic", {0.0F}},
         {"specular", {0.5F}},
         {"specularTint", {0.0F}},
         {"sheen", {0.0F}},
         {"sheenTint", {0.5F}},
         {"clearcoat", {0.0F}},
         {"clearcoatGloss", {1.0F}},
         {"specTrans", {0.0F}},
         {"ior", {1.5F}},
         {"subsurface", {0.0F}},
         {"subsurfaceDistance", white}},
        {
            {"notMetal", "invert_float", {{"in", From("metallic")}}},
            {"diffuse",
             "burley_diffuse_bsdf",
             {{"weight", Of("notMetal")},
              {"color", From("baseColor")},
              {"roughness", From("roughness")}}},
            {"below",
             "subsurface_bsdf",
             {{"color", From("baseColor")}, {"radius", From("subsurfaceDistance")}}},
            {"body",
             "mix_bsdf",
             {{"bg", Of("diffuse")}, {"fg", Of("below")}, {"mix", From("subsurface")}}},
            {"sheenColor",
             "mix_color3",
             {{"bg", Is(white)}, {"fg", From("baseColor")}, {"mix", From("sheenTint")}}},
            {"sheen", "sheen_bsdf", {{"weight", From("sheen")}, {"color", Of("sheenColor")}}},
            {"cloth", "layer_bsdf", {{"top", Of("sheen")}, {"base", Of("body")}}},
            {"glass",
             "dielectric_bsdf",
             {{"tint", From("baseColor")},
              {"ior", From("ior")},
              {"roughness", Is({0.0F, 0.0F})},
              {"scatter_mode", Named("T")}}},
            {"clothOrGlass",
             "mix_bsdf",
             {{"bg", Of("cloth")}, {"fg", Of("glass")}, {"mix", From("specTrans")}}},
            {"alpha",
             "roughness_anisotropy",
             {{"roughness", From("roughness")}, {"anisotropy", From("anisotropic")}}},
            {"strength", "multiply_float", {{"in1", From("specular")}, {"in2", Is({0.08F})}}},
            {"tint",
             "mix_color3",
             {{"bg", Is(white)}, {"fg", From("baseColor")}, {"mix", From("specularTint")}}},
            {"reflection",
             "generalized_schlick_bsdf",
             {{"weight", Of("strength")}, {"color0", Of("tint")}, {"roughness", Of("alpha")}}},
            {"dielectric", "layer_bsdf", {{"top", Of("reflection")}, {"base", Of("clothOrGlass")}}},
            {"metal",
             "generalized_schlick_bsdf",
             {{"color0", From("baseColor")}, {"roughness", Of("alpha")}}},
            {"base",
             "mix_bsdf",
             {{"bg", Of("dielectric")}, {"fg", Of("metal")}, {"mix", From("metallic")}}},
            {"coatStrength", "multiply_float", {{"in1", From("clearcoat")}, {"in2", Is({0.04F})}}},
            {"matt", "invert_float", {{"in", From("clearcoatGloss")}}},
            {"mattBoth", "convert_float_vector2", {{"in", Of("matt")}}},
            {"coatAlpha", "roughness_dual", {{"roughness", Of("mattBoth")}}},
            {"coat",
             "generalized_schlick_bsdf",
             {{"weight", Of("coatStrength")}, {"roughness", Of("coatAlpha")}}},
            {"all", "layer_bsdf", {{"top", Of("coat")}, {"base", Of("base")}}},
            {"", "surface", {{"bsdf", Of("all")}}},
        }};
}

const std::vector<NodeGraph>& Graphs() {
    static const std::vector<NodeGraph> kGraphs = [] {
        std::vector<NodeGraph> graphs = LamaGraphs();
        graphs.push_back(DisneyPrincipled());
        for (NodeGraph& graph : ConvertGraphs()) {
            graphs.push_back(std::move(graph));
        }
        return graphs;
    }();
    return kGraphs;
}

/// Whether it stands for a surface, and not for a closure.
bool IsSurface(const NodeGraph& graph) {
    return graph.nodes.back().identifier.rfind("surface", 0) == 0;
}

const NodeGraph* FindGraph(const std::string& identifier) {
    const auto found = std::find_if(Graphs().begin(), Graphs().end(), [&](const NodeGraph& one) {
        return one.identifier == identifier;
    });
    return found == Graphs().end() ? nullptr : &*found;
}

std::string PathOf(const MaterialNode& shader, const std::string& name) {
    return name.empty() ? shader.path : shader.path + "/" + name;
}

/// An input of the shader as an input of a node of its graph.
void PassOn(const NodeGraph& graph, const MaterialNode& shader, const std::string& from,
            const std::string& input, MaterialNode* node) {
    if (const auto connection = shader.connections.find(from);
        connection != shader.connections.end()) {
        node->connections[input] = connection->second;
    }
    const auto parameter = shader.parameters.find(from);
    const auto fallback = graph.defaults.find(from);
    if (parameter != shader.parameters.end()) {
        node->parameters[input] = parameter->second;
    } else if (fallback != graph.defaults.end()) {
        node->parameters[input] = fallback->second;
    }
    const auto space = shader.parameters.find("colorSpace:" + from);
    if (space != shader.parameters.end()) {
        node->parameters["colorSpace:" + input] = space->second;
    }
}

MaterialNode MakeNode(const NodeGraph& graph, const MaterialNode& shader, const GraphNode& row) {
    MaterialNode node;
    node.path = PathOf(shader, row.name);
    node.identifier = "ND_" + row.identifier;
    for (const auto& [input, source] : row.inputs) {
        switch (source.kind) {
        case GraphSource::Kind::Interface:
            PassOn(graph, shader, source.name, input, &node);
            break;
        case GraphSource::Kind::Node:
            node.connections[input] = {PathOf(shader, source.name), source.output};
            break;
        case GraphSource::Kind::Numbers:
            node.parameters[input] = source.numbers;
            break;
        case GraphSource::Kind::Text:
            node.parameters[input] = source.name;
            break;
        }
    }
    return node;
}

} // namespace

bool HasSurfaceGraph(const std::string& identifier) {
    const NodeGraph* graph = FindGraph(identifier);
    return graph != nullptr && IsSurface(*graph);
}

std::vector<std::string> ClosureGraphIds() {
    std::vector<std::string> ids;
    for (const NodeGraph& graph : Graphs()) {
        if (!IsSurface(graph)) {
            ids.push_back(graph.identifier);
        }
    }
    return ids;
}

namespace {

/// Paths of the surfaces that are mixed.
std::set<std::string> MixedSurfaces(const MaterialNetwork& network) {
    std::set<std::string> paths;
    for (const MaterialNode& node : network.nodes) {
        if (node.identifier != "ND_mix_surfaceshader") {
            continue;
        }
        for (const char* const input : {"bg", "fg"}) {
            if (const MaterialNode* shader = FindInputShader(network, node, input)) {
                paths.insert(shader->path);
            }
        }
    }
    return paths;
}

} // namespace

MaterialNetwork ExpandGraphs(const MaterialNetwork& network) {
    MaterialNetwork result = network;
    const std::set<std::string> mixed = MixedSurfaces(network);
    for (const MaterialNode& shader : network.nodes) {
        const NodeGraph* graph = FindGraph(shader.identifier);
        NodeGraph ofPreview;
        if (IsPreviewSurface(shader) && mixed.count(shader.path) > 0) {
            ofPreview = PreviewGraph(shader);
            graph = &ofPreview;
        }
        if (graph == nullptr) {
            continue;
        }
        for (const GraphNode& row : graph->nodes) {
            MaterialNode node = MakeNode(*graph, shader, row);
            if (row.name.empty()) {
                const auto self =
                    std::find_if(result.nodes.begin(), result.nodes.end(),
                                 [&](const MaterialNode& one) { return one.path == shader.path; });
                *self = std::move(node);
            } else {
                result.nodes.push_back(std::move(node));
            }
        }
    }
    return result;
}

} // namespace hds
