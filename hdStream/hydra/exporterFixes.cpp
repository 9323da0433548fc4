// SPDX-License-Identifier: Apache-2.0
#include "hdStream/hydra/exporterFixes.h"

#include "hdStream/hydra/lightParameters.h"
#include "hdStream/hydra/transparentSides.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <set>
#include <string>
#include <utility>
#include <variant>
#include <vector>

PXR_NAMESPACE_OPEN_SCOPE

namespace {

constexpr double kRadians = 3.14159265358979323846 / 180.0;
constexpr float kBlendersSun = 4.0F; ///< by which Blender's exporter divides
constexpr double kQuarter = 90.0;    ///< in degrees, by which it turns tangents back

/// Flux over the range of cosines within the cone, of a radiance that is 1 up to the angle
/// cutoff * (1 - softness) and falls from there to 0 by a smooth step of the angle. In radians.
double FluxOfSoftness(double cutoff, double softness) {
    constexpr int kNumSteps = 256;
    const double start = cutoff * (1.0 - softness);
    const double step = (cutoff - start) / kNumSteps;
    double flux = 1.0 - std::cos(start);
    for (int i = 0; i < kNumSteps; ++i) {
        const double t = (i + 0.5) / kNumSteps;
        flux += (1.0 - t * t * (3.0 - 2.0 * t)) * std::sin(start + (i + 0.5) * step) * step;
    }
    return flux / (1.0 - std::cos(cutoff));
}

/// The softness whose flux is that of a blend: a smooth step of the cosine over that share of the
/// cone's cosines, which lets half of the share through.
float SoftnessOfBlend(float coneAngle, float blend) {
    const double cutoff = std::clamp(double(coneAngle), 0.0, 180.0) * kRadians;
    const double wanted = 1.0 - 0.5 * std::clamp(double(blend), 0.0, 1.0);
    if (!(cutoff > 0.0) || !(blend > 0.0F)) {
        return blend;
    }
    double low = 0.0;
    double high = 1.0; // at which the flux is least
    for (int i = 0; i < 30; ++i) {
        const double middle = 0.5 * (low + high);
        (FluxOfSoftness(cutoff, middle) > wanted ? low : high) = middle;
    }
    return float(0.5 * (low + high));
}

bool EndsWith(const std::string& text, const std::string& end) {
    return text.size() >= end.size() &&
           text.compare(text.size() - end.size(), end.size(), end) == 0;
}

/// True for files of linear formats that Blender wrote for an image it had in memory.
bool IsOfBlendersCache(const hds::AssetReference& asset) {
    const std::string& path = asset.authoredPath;
    return path.find("/image_cache/img_") != std::string::npos &&
           (EndsWith(path, ".exr") || EndsWith(path, ".hdr"));
}

/// A node between an input and what is connected to it, which is its own "in1".
hds::MaterialNode Insert(const std::string& input, const char* name, const char* identifier,
                         hds::MaterialNode* node) {
    hds::MaterialNode inserted;
    inserted.path = node->path + "_" + input + name;
    inserted.identifier = identifier;
    inserted.connections["in1"] = node->connections.at(input);
    node->connections[input] = {inserted.path, "out"};
    return inserted;
}

/// A colour of glass that is meant of the way in and out becomes its root, which dims light at each
/// surface.
void TintEachWay(const std::string& input, hds::MaterialNode* node,
                 std::vector<hds::MaterialNode>* added) {
    const auto parameter = node->parameters.find(input);
    if (parameter != node->parameters.end()) {
        if (auto* color = std::get_if<std::vector<float>>(&parameter->second)) {
            std::transform(color->begin(), color->end(), color->begin(),
                           [](float c) { return std::sqrt(std::clamp(c, 0.0F, 1.0F)); });
        }
    }
    if (node->connections.count(input) > 0) {
        hds::MaterialNode root = Insert(input, "Root", "ND_power_color3FA", node);
        root.parameters["in2"] = 0.5;
        added->push_back(std::move(root));
    }
}

using NodesByPath = std::map<std::string, hds::MaterialNode*>;

/// Null: nothing is connected.
hds::MaterialNode* Upstream(const NodesByPath& nodes, const hds::MaterialNode& node,
                            const char* input) {
    const auto connection = node.connections.find(input);
    const auto found = connection != node.connections.end()
                           ? nodes.find(connection->second.upstreamPath)
                           : nodes.end();
    return found != nodes.end() ? found->second : nullptr;
}

/// The roughness of a BSDF, whose square is MaterialX's.
void SquareRoughness(hds::MaterialNode* node, std::vector<hds::MaterialNode>* added) {
    const auto parameter = node->parameters.find("roughness");
    if (parameter != node->parameters.end()) {
        if (auto* roughness = std::get_if<std::vector<float>>(&parameter->second)) {
            std::transform(roughness->begin(), roughness->end(), roughness->begin(),
                           [](float r) { return r * r; });
        }
    }
    if (node->connections.count("roughness") > 0) {
        hds::MaterialNode square = Insert("roughness", "Square", "ND_multiply_vector2", node);
        square.connections["in2"] = square.connections["in1"];
        added->push_back(std::move(square));
    }
}

/// Turns the tangent that is Principled's by the quarter which the exporter has taken off.
void TurnTangent(const NodesByPath& nodes, const hds::MaterialNode& node, const char* input,
                 std::set<std::string>* turned, std::vector<hds::MaterialNode>* added) {
    hds::MaterialNode* turn = Upstream(nodes, node, input);
    if (turn != nullptr && turn->identifier == "ND_normalize_vector3") {
        turn = Upstream(nodes, *turn, "in");
    }
    if (turn == nullptr || turn->identifier != "ND_rotate3d_vector3" ||
        !turned->insert(turn->path).second) {
        return;
    }
    if (turn->connections.count("amount") > 0) {
        hds::MaterialNode sum = Insert("amount", "Turn", "ND_add_float", turn);
        sum.parameters["in2"] = kQuarter;
        added->push_back(std::move(sum));
        return;
    }
    const auto parameter = turn->parameters.find("amount");
    if (parameter != turn->parameters.end()) {
        if (auto* amount = std::get_if<double>(&parameter->second)) {
            *amount += kQuarter;
        }
    }
}

/// What single BSDFs and those of Principled have in common, and what not.
void FixBsdfs(hds::MaterialNetwork* network, std::vector<hds::MaterialNode>* added) {
    NodesByPath nodes;
    for (hds::MaterialNode& node : network->nodes) {
        nodes[node.path] = &node;
    }
    std::set<std::string> turned;
    for (hds::MaterialNode& node : network->nodes) {
        if (node.identifier == "ND_open_pbr_surface_surfaceshader") {
            TurnTangent(nodes, node, "geometry_tangent", &turned, added);
        } else if (node.identifier == "ND_conductor_bsdf" ||
                   node.identifier == "ND_dielectric_bsdf") {
            const hds::MaterialNode* roughness = Upstream(nodes, node, "roughness");
            if (roughness != nullptr && roughness->identifier == "ND_roughness_anisotropy") {
                TurnTangent(nodes, node, "tangent", &turned, added); // a part of Principled
            } else {
                SquareRoughness(&node, added);
            }
        }
    }
}

} // namespace

HdStreamExporter HdStreamFindExporter(const std::string& name) {
    return name == "blender" ? HdStreamExporter::Blender : HdStreamExporter::None;
}

void HdStreamFixLight(HdStreamExporter exporter, hds::LightDescription* light) {
    if (exporter != HdStreamExporter::Blender) {
        return;
    }
    if (light->type == hds::LightType::Distant) {
        light->intensity *= kBlendersSun;
    }
    light->shaping.coneSoftness =
        SoftnessOfBlend(light->shaping.coneAngle, light->shaping.coneSoftness);
}

void HdStreamFixTemperature(HdStreamExporter exporter, HdSceneDelegate* delegate, const SdfPath& id,
                            hds::LightDescription* light) {
    if (exporter == HdStreamExporter::Blender && HdStreamLeavesTemperatureOut(delegate, id)) {
        light->enableColorTemperature = false;
    }
}

void HdStreamFixMaterial(HdStreamExporter exporter, hds::MaterialNetwork* network) {
    if (exporter != HdStreamExporter::Blender) {
        return;
    }
    HdStreamTakeTransparentOut(network);
    std::vector<hds::MaterialNode> added;
    FixBsdfs(network, &added);
    for (hds::MaterialNode& node : network->nodes) {
        if (node.identifier == "ND_open_pbr_surface_surfaceshader") {
            if (node.connections.count("coat_darkening") == 0) {
                node.parameters.try_emplace("coat_darkening", 0.0);
            }
            TintEachWay("transmission_color", &node, &added);
        }
        const auto file = node.parameters.find("file");
        const auto space = node.parameters.find("colorSpace:file");
        if (file == node.parameters.end() || space == node.parameters.end()) {
            continue;
        }
        const auto* asset = std::get_if<hds::AssetReference>(&file->second);
        if (asset != nullptr && IsOfBlendersCache(*asset)) {
            space->second = std::string("lin_rec709");
        }
    }
    network->nodes.insert(network->nodes.end(), added.begin(), added.end());
}

PXR_NAMESPACE_CLOSE_SCOPE
